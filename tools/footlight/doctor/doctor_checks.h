// The checks of `footlight doctor`: causes of missing or bad DMX on this machine, and the command that fixes each.
//
// A check is one pure function of a DoctorView and a row in the table that doctor_checks() returns. It reads files
// below the roots of the view, changes nothing, opens no device and needs no privilege. What this user may not read is
// reported as not visible. Tests use roots of their own and check each verdict.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/registry.h"
#include "sim/core/clock.h"

namespace footlight::tools {

enum class Verdict {
  kOk,
  kWarn,     // works, or may work; worth checking
  kFail,     // a configured part, or a device that is plugged in, cannot work
  kSkipped,  // does not apply here
};
// "ok", "warn", "fail", "skipped": stable words for JSON.
[[nodiscard]] std::string_view name_of(Verdict verdict);

// The parts of the machine and of the user that the checks read.
struct DoctorView {
  drivers::FindOptions find;  // /sys, /dev, /proc
  std::string etc_root = "/etc";
  std::vector<std::string> lib_roots = {"/usr/local/lib", "/usr/lib"};  // the first one with the file is used
  unsigned user_id = 0;
  std::string user_name;
  std::vector<std::string> groups;  // of this process, by name
  std::uint64_t realtime_max = 0;   // RLIMIT_RTPRIO, the hard one
  DurationNs clock_resolution_ns = 1;
};
// The machine and the user that run this program.
[[nodiscard]] DoctorView this_machine();

struct Outcome {
  Verdict verdict = Verdict::kOk;
  std::string seen;  // one or two sentences
  std::string fix;   // a command to copy, or an instruction; empty: nothing to do
};

struct Check {
  const char* id;     // "udev-rules": stays the same in later versions
  const char* title;  // for people
  Outcome (*run)(const DoctorView& view);
};

// In the order in which they are printed.
[[nodiscard]] std::span<const Check> doctor_checks();

// The number of universes with 44 frames a second that a receive buffer of `rmem_max_bytes` holds through a stall of
// 150 ms, the longest that was measured on a virtual machine (docs/doctor.md).
[[nodiscard]] std::uint64_t universes_through_a_stall(std::uint64_t rmem_max_bytes);

}  // namespace footlight::tools

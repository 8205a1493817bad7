// The checks of `footlight doctor`: what of this machine stands in the way of DMX, and the command that mends it.
//
// A check is one pure function of a DoctorView and a row in the table that doctor_checks() returns. It reads files
// below the roots of the view, changes nothing, opens no device and needs no privilege; what this user may not see is
// said to be unseen. Tests lay out roots of their own and check each verdict.
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
  kWarn,     // works, or may; somebody should look at it
  kFail,     // something that was asked for, or is plugged in, cannot work
  kSkipped,  // does not apply here
};
// "ok", "warn", "fail", "skipped": stable words for JSON.
[[nodiscard]] std::string_view name_of(Verdict verdict);

// The machine and the user, as far as checks look at them.
struct DoctorView {
  drivers::FindOptions find;  // /sys, /dev, /proc
  std::string etc_root = "/etc";
  std::vector<std::string> lib_roots = {"/usr/local/lib", "/usr/lib"};  // the first that has a file counts
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
  std::string mend;  // a command to copy, or what to do; empty where there is nothing
};

struct Check {
  const char* id;     // "udev-rules": stays as it is from version to version
  const char* title;  // for people
  Outcome (*snapshot)(const DoctorView& view);
};

// In the order in which they are printed.
[[nodiscard]] std::span<const Check> doctor_checks();

// How many universes of 44 frames a second a receive buffer of `rmem_max_bytes` keeps through a stall of 150 ms, the
// longest that was seen on a virtual machine (docs/doctor.md).
[[nodiscard]] std::uint64_t universes_through_a_stall(std::uint64_t rmem_max_bytes);

}  // namespace footlight::tools

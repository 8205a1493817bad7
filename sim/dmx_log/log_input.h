// Recordings in other formats than the DMX log: frames with their times, read once from front to back. Used by convert,
// info and replay. Captures of networks and of lines are in drivers/capture. Threads: none; one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/result.h"
#include "sim/dmx_log/dmx_log.h"

namespace footlight {

class LogInput {
 public:
  virtual ~LogInput() = default;
  [[nodiscard]] virtual LogFormat format() const = 0;
  [[nodiscard]] virtual const std::string& path() const = 0;
  // Time 0 of the recording, on the clock of FrameView::stamp_ns.
  [[nodiscard]] virtual TimeNs origin_ns() const { return 0; }
  // The wall clock at that moment, ns since 1970-01-01 UTC; 0: unknown.
  [[nodiscard]] virtual std::int64_t wall_start_unix_ns() const { return 0; }
  // The universes listed in the file, with or without frames; may be empty.
  [[nodiscard]] virtual std::vector<Universe> universes() const { return {}; }
  // The next frame, valid until the next call; false at the end. Repeats of unchanged levels are included. Stamps
  // decrease where the file's times do. Errors name the file and the place in it.
  [[nodiscard]] virtual Result<bool> next(FrameView& frame) = 0;
  // When the recording ended; valid after the end was read.
  [[nodiscard]] virtual TimeNs end_ns() const = 0;
  // False if the file seems to be cut off; valid after the end was read. notes() names the place.
  [[nodiscard]] virtual bool finished() const { return true; }
  // Parts of the file that could not be used.
  [[nodiscard]] virtual std::uint64_t damage_count() const { return 0; }
  // What was left out and why, as whole lines for people; complete after the end was read.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

// Detects the format by the file's first bytes, or by its blocks if the first bytes of a DMX log are damaged. Errors:
// kNotFound, kPermission, kBadInput (no known format).
[[nodiscard]] Result<LogFormat> detect_log_format(const std::string& path);

// Opens a DMX log or an OLA Show; of a damaged DMX log it reads what is readable. universe_offset is added to the
// universes of an OLA Show. Errors: those of LogReader and OlaShowReader; kUnsupported for a capture, which
// drivers/capture reads.
[[nodiscard]] Result<std::unique_ptr<LogInput>> open_log_input(const std::string& path, int universe_offset = 0);

// The rest of `input` as a log in memory: compressed, so some bytes a frame (docs/formats/dmxlog.md lists sizes).
[[nodiscard]] Result<LogReader> read_into_memory(LogInput& input);

// All information about `input`, which is read to its end. For DMX logs read_log_info() returns more and is faster.
[[nodiscard]] Result<LogInfo> describe(LogInput& input);

struct ConvertOptions {
  bool overwrite = false;
  bool changes_only = false;  // leave out frames that repeat the levels before them
  // From (in the input) to (in the result). If not empty, universes that are not listed are left out.
  std::vector<std::pair<Universe, Universe>> renumber;
};

struct ConvertReport {
  std::uint64_t frames = 0;           // written
  std::uint64_t left_out = 0;         // repeats (changes_only) and, in an OLA Show, frames that end a stream
  std::uint64_t other_universes = 0;  // frames of universes that `renumber` does not list
  std::vector<Universe> absent;       // listed in `renumber` but without a frame; numbers of the input
  std::uint64_t late_stamps = 0;      // frames stamped before the previous one; raised to its time
  DurationNs duration_ns = 0;         // of the result
  DurationNs lead_dropped_ns = 0;     // silence before the first frame, which an OLA Show cannot hold
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
  std::uint64_t damage_count = 0;  // of the input
  std::vector<std::string> notes;  // of the input
};

// Converts `in` to `out`: a DMX log if the name ends in .dmxlog, else an OLA Show. Converting a format to itself is
// allowed and recovers a damaged log. An error leaves no output file.
[[nodiscard]] Result<ConvertReport> convert_log(LogInput& in, const std::string& out,
                                                const ConvertOptions& options = {});

}  // namespace footlight

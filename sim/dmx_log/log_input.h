// Anything that holds frames with their times, read once from front to back: what convert, info and replay have in
// common for files that are no DMX log. Captures of networks and of lines are in drivers/capture.
// Threads: none; one thread at a time.
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
  // What time 0 of the recording is on the clock of FrameView::stamp_ns.
  [[nodiscard]] virtual TimeNs origin_ns() const { return 0; }
  // The wall clock at that moment, ns since 1970-01-01 UTC; 0: unknown.
  [[nodiscard]] virtual std::int64_t wall_start_unix_ns() const { return 0; }
  // Those that the file announces, heard or not; may be empty.
  [[nodiscard]] virtual std::vector<Universe> universes() const { return {}; }
  // The next frame, valid until the next call; false at the end. A frame that repeats a look comes, too. Stamps may
  // fall where those of the file do. Errors name the file and the place in it.
  [[nodiscard]] virtual Result<bool> next(FrameView& frame) = 0;
  // When the recording ended; known after the end.
  [[nodiscard]] virtual TimeNs end_ns() const = 0;
  // Parts of the file that could not be used.
  [[nodiscard]] virtual std::uint64_t damage_count() const { return 0; }
  // What was left out, and why, as whole lines for people; complete after the end.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

// Which format a file has, by its first bytes; a DMX log whose first bytes are damaged, by its blocks.
// Errors: kNotFound, kPermission, kBadInput (none of them).
[[nodiscard]] Result<LogFormat> detect_log_format(const std::string& path);

// A DMX log or an OLA Show; of a DMX log what can be read. universe_offset is added to the universes of an OLA Show.
// Errors: those of LogReader and OlaShowReader; kUnsupported for a capture, which drivers/capture reads.
[[nodiscard]] Result<std::unique_ptr<LogInput>> open_log_input(const std::string& path, int universe_offset = 0);

// The rest of `input` as a log in memory: compressed, so some bytes a frame (docs/formats/dmxlog.md has sizes).
[[nodiscard]] Result<LogReader> read_into_memory(LogInput& input);

// All about what `input` holds, which is read to its end. For DMX logs read_log_info() knows more and is faster.
[[nodiscard]] Result<LogInfo> describe(LogInput& input);

struct ConvertOptions {
  bool overwrite = false;
  bool changes_only = false;  // leave out frames that repeat the levels before them
  // From (in the input) to (in the result); where not empty, universes that it does not name are left out.
  std::vector<std::pair<Universe, Universe>> renumber;
};

struct ConvertReport {
  std::uint64_t frames = 0;           // written
  std::uint64_t left_out = 0;         // repeats (changes_only) and, in an OLA Show, frames that end a stream
  std::uint64_t other_universes = 0;  // frames of universes that `renumber` does not name
  std::vector<Universe> absent;       // that `renumber` names and of which no frame came; numbers of the input
  std::uint64_t late_stamps = 0;      // frames stamped before the one before them; raised to its time
  DurationNs duration_ns = 0;         // of the result
  DurationNs lead_dropped_ns = 0;     // silence before the first frame, which an OLA Show cannot hold
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
  std::uint64_t damage_count = 0;  // of the input
  std::vector<std::string> notes;  // of the input
};

// Writes what `in` holds as `out`: a DMX log where its name ends in .dmxlog, an OLA Show otherwise. From one format to
// itself is allowed: that recovers a damaged log. Errors leave nothing behind.
[[nodiscard]] Result<ConvertReport> convert_log(LogInput& in, const std::string& out,
                                                const ConvertOptions& options = {});

}  // namespace footlight

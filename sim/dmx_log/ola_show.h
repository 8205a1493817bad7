// OLA Show text, as the Open Lighting Architecture's recorder writes and plays it: the line "OLA Show", then
// alternating "<universe> <level>,<level>,..." and a delay in whole milliseconds. Unix or DOS line ends; a final delay
// may follow.
//
// OLA ends every line, so a last line without a line end is a sign that the file was cut off. It is read all the same,
// because editors also write such files. A file that was cut off between two lines cannot be recognised.
//
// An empty level is 0, as in OLA's DmxBuffer::SetFromString: "1,,3" is 1, 0, 3, and "1," is 1, 0. OLA also reads text
// as 0, reads levels past 255 modulo 256, and drops levels past 512. Those are errors here, because they lose levels.
//
// The format has no stamps, senders or priorities, and does not distinguish repeats from changes. So a DMX log that is
// converted to it and back keeps levels, and times rounded to 1 ms. Rounding is carried forward: no frame and no total
// is off by more than 0.5 ms. Threads: none; one thread at a time.
#pragma once

#include <cstdint>
#include <fstream>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/result.h"
#include "sim/dmx_log/dmx_log.h"

namespace footlight {

struct OlaShowFrame {
  DurationNs time_ns = 0;  // since the start; a whole number of milliseconds
  Universe universe = 0;
  std::vector<std::uint8_t> slots;  // 0 to 512
};

class OlaShowReader {
 public:
  // `universe_offset` is added to each universe: 1 for shows that count from 0, as OLA may.
  [[nodiscard]] static Result<OlaShowReader> open(const std::string& path, int universe_offset = 0);
  // A show in memory; `name` replaces the path in messages.
  [[nodiscard]] static Result<OlaShowReader> open_text(std::string text, const std::string& name,
                                                       int universe_offset = 0);
  // The next frame; false at the end. Errors name file:line and what was expected there.
  [[nodiscard]] Result<bool> next(OlaShowFrame& frame);
  // The sum of all delays read so far; at the end the length of the show.
  [[nodiscard]] DurationNs time_ns() const { return time_ns_; }
  // The number of a last line that has no line end; 0: none was read.
  [[nodiscard]] int open_line() const { return open_line_; }

 private:
  OlaShowReader(std::string path, std::unique_ptr<std::istream> stream, int universe_offset);
  [[nodiscard]] static Result<OlaShowReader> begin(std::string path, std::unique_ptr<std::istream> stream,
                                                   int universe_offset);
  // The next line that is not empty, without its line end; false at the end.
  [[nodiscard]] Result<bool> read_line(std::string& line);
  // Reads "<level>,<level>,..." of the current line into `slots`.
  [[nodiscard]] Status read_levels(std::string_view levels, std::vector<std::uint8_t>& slots) const;

  std::string path_;
  std::unique_ptr<std::istream> stream_;
  int universe_offset_ = 0;
  int line_ = 0;
  int open_line_ = 0;
  bool delay_next_ = false;
  DurationNs time_ns_ = 0;
  std::string text_;
};

class OlaShowWriter {
 public:
  // Writes `path`.part; close() renames it to `path`.
  [[nodiscard]] static Result<OlaShowWriter> create(const std::string& path, bool overwrite = false);
  // Times must not decrease. The format starts with its first frame: silence before it cannot be written.
  Status append(DurationNs time_ns, Universe universe, std::span<const std::uint8_t> slots);
  // Writes the delay up to the end of the show.
  Status close(DurationNs end_ns);
  // The silence before the first frame, which the file does not contain.
  [[nodiscard]] DurationNs lead_ns() const { return lead_ns_; }

 private:
  OlaShowWriter(std::string path, std::ofstream stream);
  void write_delay(DurationNs time_ns);
  [[nodiscard]] Status check_stream();

  std::string path_;
  std::ofstream stream_;
  bool any_ = false;
  DurationNs lead_ns_ = 0;
  std::int64_t written_ms_ = 0;  // all delays so far
  std::string text_;
};

}  // namespace footlight

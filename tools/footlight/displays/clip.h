// A video file for displays: any of its pictures by number, in any order.
//
// The same number gives the same picture, whatever was read before: after a seek pictures are decoded from the last one
// before it that needs none. A picture that is damaged or missing is replaced by the last whole one before it, at the
// start by the first whole one. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/vrsl/picture.h"
#include "fixtures/displays/display.h"
#include "sim/core/clock.h"
#include "tools/footlight/vrsl/video_reader.h"

namespace footlight::tools {

class Clip {
 public:
  // Reads the file once for the times of its pictures, and decodes the first one. Errors, with the name of the file:
  // kNotFound, kPermission, kBadInput (no video, no picture that can be decoded), kUnsupported (no decoder, HDR, no
  // libav).
  [[nodiscard]] static Result<std::unique_ptr<Clip>> open(const std::string& path);

  [[nodiscard]] const VideoFacts& facts() const { return reader_->facts(); }
  [[nodiscard]] std::size_t count() const { return times_.starts_ns.size(); }  // of pictures, at least 1
  [[nodiscard]] DurationNs duration_ns() const { return times_.end_ns; }

  // The picture that is due at a time of the file; times outside are those of its first and last picture.
  [[nodiscard]] std::size_t index_at(DurationNs time_ns) const;
  // 8 bits, as the file has it; valid until the next call. index: less than count().
  [[nodiscard]] Result<const drivers::Picture*> picture(std::size_t index);
  // Pictures so far that were replaced.
  [[nodiscard]] std::size_t replaced() const;

 private:
  Clip(std::string path, std::unique_ptr<VideoReader> reader) : path_(std::move(path)), reader_(std::move(reader)) {}
  Status go_to(std::size_t index);
  // The number of the next picture of the file that can be decoded; nullopt: there is none.
  [[nodiscard]] Result<std::optional<std::size_t>> decode_next();
  Status decode(std::size_t index);
  void replace(std::size_t first, std::size_t end, std::size_t by);

  std::string path_;
  std::unique_ptr<VideoReader> reader_;
  VideoTimes times_;
  std::vector<std::size_t> stands_for_;  // of each number, the picture that is shown: itself or another one
  drivers::Picture picture_;
  std::optional<std::size_t> decoded_;  // the number of picture_
};

// The time of the file at a time of the show. Exact to a nanosecond for shows of 100 days.
[[nodiscard]] DurationNs clip_time_ns(const fixtures::DisplayVideo& video, DurationNs show_ns, DurationNs duration_ns);

}  // namespace footlight::tools

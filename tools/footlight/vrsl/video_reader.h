// Pictures of a video file: any container and codec that the installed libavformat and libavcodec read.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/vrsl/picture_port.h"

namespace footlight::tools {

// What a stream states about itself; it may be wrong about range and matrix.
struct VideoFacts {
  std::string container;     // "mov,mp4,m4a,3gp,3g2,mj2"
  std::string codec;         // "h264"
  std::string pixel_format;  // "yuv420p"
  std::string range;         // "tv" (limited), "pc" (full), "unknown"
  std::string matrix;        // "bt709", "unknown"
  std::string transfer;      // "bt709", "unknown"
  int width = 0;
  int height = 0;
  double pictures_hz = 0;                 // mean; 0: unknown
  std::optional<DurationNs> duration_ns;  // as the container states it
};

struct VideoCounters {
  std::uint64_t pictures = 0;  // returned
  // Decoded with errors, or after one and before the next picture that needs none before it; not returned.
  std::uint64_t damaged = 0;
  bool cut_off = false;  // the file ends within a packet, or before its index
};

// When the pictures of a file are due, from the first one, as its packets state it. Without decoding.
struct VideoTimes {
  std::vector<DurationNs> starts_ns;  // ascending
  std::vector<bool> keys;             // of each, whether it needs none before it
  DurationNs end_ns = 0;              // of the last one
};

// Times are those of the stream, from its first picture. The picture that is passed to next() must be the same and
// unchanged from call to call: only rows that differ from the picture before are written.
class VideoReader : public drivers::PictureInput {
 public:
  // Errors: kNotFound, kPermission, kBadInput (not a video, no picture stream, too large), kUnsupported (no decoder, or
  // a build without libav).
  [[nodiscard]] static Result<std::unique_ptr<VideoReader>> open(const std::string& path);
  [[nodiscard]] virtual const VideoFacts& facts() const = 0;
  [[nodiscard]] virtual const VideoCounters& counters() const = 0;
  // Reads the whole file once; next() then begins at its start. Errors: kBadInput (no pictures in it).
  [[nodiscard]] virtual Result<VideoTimes> read_times() = 0;
  // next() then begins at a picture that needs none before it, if possible one that is due at time_ns or before. A file
  // that cannot be sought is read from its start.
  virtual Status seek(DurationNs time_ns) = 0;
};

// True for names that end as those of video files do.
[[nodiscard]] bool is_video_name(std::string_view name);

// For endpoints of pictures. Options: none.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureInput>> open_video_input(const drivers::PictureTarget& target);

}  // namespace footlight::tools

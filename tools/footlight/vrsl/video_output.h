// Pictures as an H.264 stream: .mp4, .mkv and .ts files, and an MPEG transport stream into a pipe.
//
// Settings fit grids: a key picture every second, no pictures that refer to later ones, no delay in the encoder, and
// much quality, since a grid costs little: a block of one colour is one number.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "drivers/vrsl/picture_port.h"

namespace footlight::tools {

// Options of a target:
//   quality   0 to 51, lower is better: 12; x264's constant rate factor
//   bitrate   10 to 200000 kbit/s, instead of a quality
//   lossless  yes: every pixel exactly, as RGB; few players show that, Footlight reads it
//   luma      limited (default) or full: the range of luma in the stream
//   preset    ultrafast to veryslow: the time that the encoder takes; superfast
struct VideoSettings {
  int quality = 12;
  int bitrate_kbps = 0;  // 0: by quality
  bool lossless = false;
  bool full_range = false;
  std::string preset = "superfast";
};
// Errors: kBadInput; the message begins with the endpoint.
[[nodiscard]] Result<VideoSettings> read_video_settings(const drivers::PictureTarget& target);

// True for "-" (standard output), pipes that exist, and names that end as those of videos do.
[[nodiscard]] bool is_video_target(std::string_view name);

// A file is written as NAME.part and gets its name in finish(); the error for an existing one comes at once. A pipe is
// opened with the first picture: while it has no reader, pictures fail with kIo, and each reader gets a stream of its
// own. Errors: kBadInput, kUnsupported (no encoder, a build without libav), kIo.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureOutput>> open_video_output(const drivers::PictureTarget& target);

}  // namespace footlight::tools

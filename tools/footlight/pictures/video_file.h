// Pictures as a video file (.mp4, H.264 if the installed libavcodec supports it, else MPEG-4 part 2).
#pragma once

#include <memory>
#include <string>

#include "render/image.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::tools {

class VideoFile {
 public:
  // Pictures of even width and height (video formats halve the colour resolution), one each frame_ns.
  // kUnsupported if this build has no libavcodec or the library no encoder.
  [[nodiscard]] static Result<std::unique_ptr<VideoFile>> create(const std::string& path, int width, int height,
                                                                 DurationNs frame_ns);
  virtual ~VideoFile() = default;
  virtual Status add(const render::ScreenImage& image) = 0;
  // Writes the end and renames the file; without it the file stays `path`.part.
  virtual Status close() = 0;
};

}  // namespace footlight::tools

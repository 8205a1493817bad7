// Replaces video_file.cpp in a build without libavcodec.
#include "tools/footlight/pictures/video_file.h"

namespace footlight::tools {

Result<std::unique_ptr<VideoFile>> VideoFile::create(const std::string& path, int, int, DurationNs) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build cannot write video; install libavcodec-dev, libavformat-dev, libavutil-dev and "
              "libswscale-dev and build again, or write pictures: -o frame_%04d.png",
              path);
}

}  // namespace footlight::tools

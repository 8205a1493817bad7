// Replaces video_reader.cpp and video_output.cpp in a build without libav.
#include "tools/footlight/vrsl/video_output.h"
#include "tools/footlight/vrsl/video_reader.h"

namespace footlight::tools {
namespace {

tl::unexpected<Error> without_libav(const std::string& name) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build has no video; install libavcodec-dev, libavformat-dev, libavutil-dev and libswscale-dev "
              "and build again, or use pictures: frame_%05d.png",
              name);
}

}  // namespace

Result<std::unique_ptr<VideoReader>> VideoReader::open(const std::string& path) { return without_libav(path); }

Result<std::unique_ptr<drivers::PictureInput>> open_video_input(const drivers::PictureTarget& target) {
  return without_libav(target.endpoint);
}

Result<std::unique_ptr<drivers::PictureOutput>> open_video_output(const drivers::PictureTarget& target) {
  return without_libav(target.endpoint);
}

}  // namespace footlight::tools

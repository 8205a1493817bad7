// Replaces video_ways.cpp in a build without libav.
#include "tools/footlight/vrsl/video_ways.h"

namespace footlight::tools {

Result<std::vector<PictureWay>> video_ways() {
  return fail(ErrorCode::kUnsupported,
              "this build has no video; install libavcodec-dev, libavformat-dev, libavutil-dev and libswscale-dev, and "
              "build again");
}

}  // namespace footlight::tools

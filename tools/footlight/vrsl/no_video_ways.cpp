// Replaces video_ways.cpp in a build without libav.
#include "tools/footlight/vrsl/video_ways.h"

namespace footlight::tools {

std::vector<PictureWay> video_ways() { return {}; }

}  // namespace footlight::tools

// The H.264 encoder with settings that fit grids.
#pragma once

#include "tools/footlight/vrsl/video_output.h"

struct AVCodecContext;

namespace footlight::tools {

inline constexpr int kVideoTicksPerS = 90'000;  // of its time stamps; fits every usual rate

// Takes RGB24 if lossless, else 4:2:0 as BT.709. Each picture gives its packet at once. The caller frees it.
// `in_header`: the container has the parameters, not the stream. kUnsupported: libavcodec has no such encoder.
[[nodiscard]] Result<AVCodecContext*> open_h264_encoder(const VideoSettings& settings, int width, int height,
                                                        double pictures_hz, bool in_header);

}  // namespace footlight::tools

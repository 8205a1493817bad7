#include "tools/footlight/vrsl/video_encoder.h"

#include <algorithm>
#include <cmath>
#include <memory>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/opt.h>
}

#include "tools/footlight/vrsl/av_error.h"

namespace footlight::tools {

Result<AVCodecContext*> open_h264_encoder(const VideoSettings& settings, int width, int height, double pictures_hz,
                                          bool in_header) {
  const char* const name = settings.lossless ? "libx264rgb" : "libx264";
  const AVCodec* const codec = avcodec_find_encoder_by_name(name);
  if (codec == nullptr) {
    return fail(ErrorCode::kUnsupported,
                "the installed libavcodec has no H.264 encoder ({}); write pictures: frame_%05d.png", name);
  }
  const auto release = [](AVCodecContext* context) { avcodec_free_context(&context); };
  std::unique_ptr<AVCodecContext, decltype(release)> encoder(avcodec_alloc_context3(codec), release);
  encoder->width = width;
  encoder->height = height;
  encoder->pix_fmt = settings.lossless ? AV_PIX_FMT_RGB24 : AV_PIX_FMT_YUV420P;
  encoder->time_base = {1, kVideoTicksPerS};
  encoder->framerate = av_d2q(pictures_hz, 100'000);
  encoder->gop_size = std::max(1, static_cast<int>(std::lround(pictures_hz)));
  encoder->max_b_frames = 0;
  encoder->thread_count = 1;
  encoder->color_range = settings.full_range || settings.lossless ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  encoder->colorspace = settings.lossless ? AVCOL_SPC_RGB : AVCOL_SPC_BT709;
  encoder->color_primaries = AVCOL_PRI_BT709;
  encoder->color_trc = AVCOL_TRC_BT709;
  if (in_header) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  av_opt_set(encoder->priv_data, "preset", settings.preset.c_str(), 0);
  av_opt_set(encoder->priv_data, "tune", "zerolatency", 0);
  if (settings.lossless) {
    av_opt_set(encoder->priv_data, "qp", "0", 0);
  } else if (settings.bitrate_kbps != 0) {
    encoder->bit_rate = std::int64_t{settings.bitrate_kbps} * 1'000;
    encoder->rc_max_rate = encoder->bit_rate;
    encoder->rc_buffer_size = static_cast<int>(encoder->bit_rate);  // one second
  } else {
    av_opt_set(encoder->priv_data, "crf", std::to_string(settings.quality).c_str(), 0);
  }
  FL_TRY(av_check(avcodec_open2(encoder.get(), codec, nullptr), name, "starting the encoder"));
  return encoder.release();
}

}  // namespace footlight::tools

#include "tools/footlight/vrsl/video_ways.h"

#include <memory>
#include <string>
#include <utility>

extern "C" {
#include <libavcodec/avcodec.h>
}

#include "drivers/av/libav.h"
#include "tools/footlight/vrsl/av_error.h"
#include "tools/footlight/vrsl/video_encoder.h"
#include "tools/footlight/vrsl/yuv.h"

namespace footlight::tools {
namespace {

constexpr double kWayHz = 60;

// An encoder and a decoder, one behind the other. Opened with the first picture, and again for another size.
class H264Way {
 public:
  explicit H264Way(int bitrate_kbps) { settings_.bitrate_kbps = bitrate_kbps; }
  ~H264Way() { close(); }
  H264Way(const H264Way&) = delete;
  H264Way& operator=(const H264Way&) = delete;

  Status pass(drivers::Picture& picture) {
    if (encoder_ == nullptr || encoder_->width != picture.width || encoder_->height != picture.height) {
      FL_TRY(open(picture.width, picture.height));
    }
    const RgbToYuv to_yuv{YuvCoding{}};
    bool any = false;
    for (int i = 0; i < kWayHeldPictures; ++i) {
      FL_TRY(av_check(av_frame_make_writable(sent_), "h264", "reusing a picture"));
      to_yuv.convert(picture.view(), {{sent_->data[0], sent_->data[1], sent_->data[2]},
                                      {sent_->linesize[0], sent_->linesize[1], sent_->linesize[2]}});
      sent_->pts += std::int64_t{kVideoTicksPerS} / static_cast<int>(kWayHz);
      FL_TRY(av_check(avcodec_send_frame(encoder_, sent_), "h264", "encoding"));
      while (avcodec_receive_packet(encoder_, packet_) >= 0) {
        FL_TRY(av_check(avcodec_send_packet(decoder_, packet_), "h264", "decoding"));
        av_packet_unref(packet_);
      }
      while (avcodec_receive_frame(decoder_, next_) >= 0) {  // also empties the frame when there is none
        any = true;
        std::swap(next_, got_);
      }
    }
    if (!any || got_->format != AV_PIX_FMT_YUV420P) {
      return fail(ErrorCode::kUnsupported, "h264: the decoder gave no picture");
    }
    YuvView view{{got_->data[0], got_->data[1], got_->data[2]},
                 {got_->linesize[0], got_->linesize[1], got_->linesize[2]}};
    view.width = picture.width;
    view.height = picture.height;
    YuvToRgb(YuvCoding{}).convert(view, 0, view.height, picture);
    return {};
  }

 private:
  Status open(int width, int height) {
    close();
    FL_ASSIGN(encoder_, open_h264_encoder(settings_, width, height, kWayHz, false));
    const AVCodec* const codec = avcodec_find_decoder(AV_CODEC_ID_H264);
    if (codec == nullptr) return fail(ErrorCode::kUnsupported, "the installed libavcodec has no H.264 decoder");
    decoder_ = avcodec_alloc_context3(codec);
    decoder_->thread_count = 1;
    decoder_->flags |= AV_CODEC_FLAG_LOW_DELAY;
    FL_TRY(av_check(avcodec_open2(decoder_, codec, nullptr), "h264", "starting the decoder"));
    packet_ = av_packet_alloc();
    got_ = av_frame_alloc();
    next_ = av_frame_alloc();
    sent_ = av_frame_alloc();
    sent_->format = encoder_->pix_fmt;
    sent_->width = width;
    sent_->height = height;
    sent_->pts = 0;
    return av_check(av_frame_get_buffer(sent_, 0), "h264", "allocating a picture");
  }
  void close() {
    avcodec_free_context(&encoder_);
    avcodec_free_context(&decoder_);
    av_packet_free(&packet_);
    av_frame_free(&sent_);
    av_frame_free(&got_);
    av_frame_free(&next_);
  }

  VideoSettings settings_;
  AVCodecContext* encoder_ = nullptr;
  AVCodecContext* decoder_ = nullptr;
  AVPacket* packet_ = nullptr;
  AVFrame* sent_ = nullptr;
  AVFrame* got_ = nullptr;  // the newest picture
  AVFrame* next_ = nullptr;
};

PictureWay way_of(const std::string& name, int bitrate_kbps, const std::function<Status(drivers::Picture&)>& before) {
  return {name, [way = std::make_shared<H264Way>(bitrate_kbps), before](drivers::Picture& picture) -> Status {
            if (before) FL_TRY(before(picture));
            return way->pass(picture);
          }};
}

}  // namespace

Result<std::vector<PictureWay>> video_ways() {
  FL_TRY(drivers::load_libav());
  std::function<Status(drivers::Picture&)> smaller;
  for (const PictureWay& way : plain_ways()) {
    if (way.name == "1280x720") smaller = way.pass;
  }
  av_log_set_level(AV_LOG_QUIET);
  return std::vector<PictureWay>{way_of("h264-8000k", 8'000, {}), way_of("h264-4000k", 4'000, {}),
                                 way_of("h264-1000k", 1'000, {}), way_of("720p-4000k", 4'000, smaller)};
}

}  // namespace footlight::tools

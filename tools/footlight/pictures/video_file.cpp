#include "tools/footlight/pictures/video_file.h"

#include <array>
#include <cstdio>
#include <filesystem>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "drivers/av/libav.h"
#include "sim/file_kind.h"

namespace footlight::tools {
namespace {

std::string av_message(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

Status av_check(int code, const std::string& path, const char* what) {
  if (code >= 0) return {};
  return fail(ErrorCode::kIo, "{}: {} failed: {}", path, what, av_message(code));
}

class AvVideoFile final : public VideoFile {
 public:
  explicit AvVideoFile(std::string path) : path_(std::move(path)), part_(path_ + ".part") {}
  ~AvVideoFile() override {
    sws_freeContext(scaler_);
    av_frame_free(&frame_);
    av_packet_free(&packet_);
    avcodec_free_context(&codec_);
    if (format_ != nullptr) {
      if (format_->pb != nullptr) avio_closep(&format_->pb);
      avformat_free_context(format_);
    }
  }

  Status open(int width, int height, DurationNs frame_ns) {
    av_log_set_level(AV_LOG_ERROR);
    FL_TRY(av_check(avformat_alloc_output_context2(&format_, nullptr, "mp4", part_.c_str()), path_, "opening"));
    const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_H264);
    if (codec == nullptr) codec = avcodec_find_encoder(AV_CODEC_ID_MPEG4);
    if (codec == nullptr) {
      return fail(ErrorCode::kUnsupported,
                  "{}: the installed libavcodec has no H.264 and no MPEG-4 encoder; write pictures instead, "
                  "-o frame_%04d.png",
                  path_);
    }
    stream_ = avformat_new_stream(format_, nullptr);
    codec_ = avcodec_alloc_context3(codec);
    codec_->width = width;
    codec_->height = height;
    codec_->pix_fmt = AV_PIX_FMT_YUV420P;
    codec_->time_base = av_d2q(static_cast<double>(frame_ns) * 1e-9, 1'000'000);
    codec_->framerate = av_inv_q(codec_->time_base);
    codec_->gop_size = 50;
    codec_->color_range = AVCOL_RANGE_MPEG;
    codec_->colorspace = AVCOL_SPC_BT709;
    codec_->color_primaries = AVCOL_PRI_BT709;
    codec_->color_trc = AVCOL_TRC_BT709;
    if (codec->id == AV_CODEC_ID_H264) {
      av_opt_set(codec_->priv_data, "crf", "18", 0);
      av_opt_set(codec_->priv_data, "preset", "medium", 0);
    } else {
      codec_->bit_rate = std::int64_t{width} * height * 8;
    }
    if ((format_->oformat->flags & AVFMT_GLOBALHEADER) != 0) codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    FL_TRY(av_check(avcodec_open2(codec_, codec, nullptr), path_, "starting the encoder"));
    FL_TRY(av_check(avcodec_parameters_from_context(stream_->codecpar, codec_), path_, "describing the video"));
    stream_->time_base = codec_->time_base;
    FL_TRY(av_check(avio_open(&format_->pb, part_.c_str(), AVIO_FLAG_WRITE), path_, "writing"));
    FL_TRY(av_check(avformat_write_header(format_, nullptr), path_, "writing the header"));
    frame_ = av_frame_alloc();
    frame_->format = codec_->pix_fmt;
    frame_->width = width;
    frame_->height = height;
    FL_TRY(av_check(av_frame_get_buffer(frame_, 0), path_, "allocating a picture"));
    packet_ = av_packet_alloc();
    scaler_ = sws_getContext(width, height, AV_PIX_FMT_RGBA, width, height, codec_->pix_fmt, SWS_BICUBIC, nullptr,
                             nullptr, nullptr);
    const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
    sws_setColorspaceDetails(scaler_, bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16);
    return {};
  }

  Status add(const render::ScreenImage& image) override {
    FL_TRY(av_check(av_frame_make_writable(frame_), path_, "reusing a picture"));
    const std::uint8_t* rows[] = {image.rgba.data()};
    const int stride[] = {image.width * 4};
    sws_scale(scaler_, rows, stride, 0, image.height, frame_->data, frame_->linesize);
    frame_->pts = next_++;
    return encode(frame_);
  }

  Status close() override {
    FL_TRY(encode(nullptr));
    FL_TRY(av_check(av_write_trailer(format_), path_, "writing the end"));
    FL_TRY(av_check(avio_closep(&format_->pb), path_, "closing"));
    std::error_code trouble;
    std::filesystem::rename(part_, path_, trouble);
    if (trouble) return fail(ErrorCode::kIo, "{}: cannot be renamed from {}: {}", path_, part_, trouble.message());
    return {};
  }

 private:
  Status encode(const AVFrame* frame) {
    FL_TRY(av_check(avcodec_send_frame(codec_, frame), path_, "encoding"));
    while (true) {
      const int got = avcodec_receive_packet(codec_, packet_);
      if (got == AVERROR(EAGAIN) || got == AVERROR_EOF) return {};
      FL_TRY(av_check(got, path_, "encoding"));
      if (packet_->duration == 0) packet_->duration = 1;  // or the last picture would last no time
      av_packet_rescale_ts(packet_, codec_->time_base, stream_->time_base);
      packet_->stream_index = stream_->index;
      FL_TRY(av_check(av_interleaved_write_frame(format_, packet_), path_, "writing"));
    }
  }

  std::string path_;
  std::string part_;
  AVFormatContext* format_ = nullptr;
  AVStream* stream_ = nullptr;  // owned by format_
  AVCodecContext* codec_ = nullptr;
  AVFrame* frame_ = nullptr;
  AVPacket* packet_ = nullptr;
  SwsContext* scaler_ = nullptr;
  std::int64_t next_ = 0;
};

}  // namespace

Result<std::unique_ptr<VideoFile>> VideoFile::create(const std::string& path, int width, int height,
                                                     DurationNs frame_ns) {
  if (width % 2 != 0 || height % 2 != 0) {
    return fail(ErrorCode::kBadInput, "{}: a video needs an even width and height, got {}x{}", path, width, height);
  }
  FL_TRY(refuse_pipe_output(path));
  if (const Status has_libav = drivers::load_libav(); !has_libav) {
    return fail(has_libav.error().code, "{}: {}", path, has_libav.error().message);
  }
  auto file = std::make_unique<AvVideoFile>(path);
  FL_TRY(file->open(width, height, frame_ns));
  return file;
}

}  // namespace footlight::tools

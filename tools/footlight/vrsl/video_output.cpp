#include "tools/footlight/vrsl/video_output.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstring>
#include <filesystem>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include "drivers/av/libav.h"
#include "drivers/fd.h"
#include "sim/file_kind.h"
#include "tools/footlight/vrsl/av_error.h"
#include "tools/footlight/vrsl/video_encoder.h"
#include "tools/footlight/vrsl/yuv.h"

namespace footlight::tools {
namespace {

constexpr AVRational kStreamTimeBase = {1, kVideoTicksPerS};
constexpr int kPipeBufferBytes = 64 * 1024;
constexpr int kPipeWaitMs = 2'000;  // for a reader that takes nothing

// The encoder of one stream and the container around it.
class H264Stream {
 public:
  H264Stream(const drivers::PictureTarget& target, const VideoSettings& settings)
      : target_(target), settings_(settings), to_yuv_({YuvMatrix::kBt709, settings.full_range}) {}
  ~H264Stream() {
    av_frame_free(&frame_);
    av_packet_free(&packet_);
    avcodec_free_context(&codec_);
    if (format_ == nullptr) return;
    if (own_io_ != nullptr) {
      av_freep(&own_io_->buffer);
      avio_context_free(&own_io_);
    } else if (format_->pb != nullptr) {
      avio_closep(&format_->pb);
    }
    avformat_free_context(format_);
  }
  H264Stream(const H264Stream&) = delete;
  H264Stream& operator=(const H264Stream&) = delete;

  // Into a file, or into a pipe if `pipe` is open.
  Status open(const std::string& path, const char* container, int pipe) {
    av_log_set_level(AV_LOG_QUIET);
    pipe_ = pipe;
    FL_TRY(check(avformat_alloc_output_context2(&format_, nullptr, container, path.c_str()), "opening"));
    const bool in_header = (format_->oformat->flags & AVFMT_GLOBALHEADER) != 0;
    FL_ASSIGN(codec_, open_h264_encoder(settings_, target_.width, target_.height, target_.pictures_hz, in_header));
    stream_ = avformat_new_stream(format_, nullptr);
    FL_TRY(check(avcodec_parameters_from_context(stream_->codecpar, codec_), "describing the video"));
    stream_->time_base = codec_->time_base;
    stream_->avg_frame_rate = codec_->framerate;
    if (pipe_ >= 0) {
      auto* const buffer = static_cast<unsigned char*>(av_malloc(kPipeBufferBytes));
      own_io_ = avio_alloc_context(buffer, kPipeBufferBytes, 1, this, nullptr, &H264Stream::write_to_pipe, nullptr);
      format_->pb = own_io_;
      format_->flags |= AVFMT_FLAG_CUSTOM_IO | AVFMT_FLAG_FLUSH_PACKETS;
    } else {
      FL_TRY(check(avio_open(&format_->pb, path.c_str(), AVIO_FLAG_WRITE), "writing"));
    }
    FL_TRY(check(avformat_write_header(format_, nullptr), "writing the header"));
    packet_ = av_packet_alloc();
    frame_ = av_frame_alloc();
    frame_->format = codec_->pix_fmt;
    frame_->width = codec_->width;
    frame_->height = codec_->height;
    return check(av_frame_get_buffer(frame_, 0), "allocating a picture");
  }

  Status add(const drivers::Picture& picture, DurationNs time_ns) {
    FL_TRY(check(av_frame_make_writable(frame_), "reusing a picture"));
    if (settings_.lossless) {
      const auto row_bytes = 3 * static_cast<std::size_t>(picture.width);
      for (int y = 0; y < picture.height; ++y) {
        std::memcpy(frame_->data[0] + std::ptrdiff_t{y} * frame_->linesize[0], picture.view().row(y), row_bytes);
      }
    } else {
      const YuvPlanes planes = {{frame_->data[0], frame_->data[1], frame_->data[2]},
                                {frame_->linesize[0], frame_->linesize[1], frame_->linesize[2]}};
      to_yuv_.convert(picture.view(), planes);
    }
    const std::int64_t pts =
        av_rescale_q(time_ns, AVRational{1, static_cast<int>(kNsPerS)}, kStreamTimeBase) - first_pts_.value_or(0);
    if (!first_pts_) {  // a stream that begins later begins at 0 as well
      first_pts_ = pts;
      frame_->pts = 0;
    } else {
      frame_->pts = std::max(pts, frame_->pts + 1);
    }
    return encode(frame_);
  }

  Status finish() {
    FL_TRY(encode(nullptr));
    return check(av_write_trailer(format_), "writing the end");
  }

 private:
  [[nodiscard]] Status check(int code, const char* what) const {
    if (code >= 0) return {};
    return fail(ErrorCode::kIo, "{} failed: {}", what, av_text(code));
  }

  Status encode(const AVFrame* frame) {
    FL_TRY(check(avcodec_send_frame(codec_, frame), "encoding"));
    while (true) {
      const int got = avcodec_receive_packet(codec_, packet_);
      if (got == AVERROR(EAGAIN) || got == AVERROR_EOF) return {};
      FL_TRY(check(got, "encoding"));
      if (packet_->duration == 0) packet_->duration = std::llround(kVideoTicksPerS / target_.pictures_hz);
      av_packet_rescale_ts(packet_, codec_->time_base, stream_->time_base);
      packet_->stream_index = stream_->index;
      FL_TRY(check(av_interleaved_write_frame(format_, packet_), "writing"));
    }
  }

  static int write_to_pipe(void* opaque, std::uint8_t* bytes, int size) {
    const int fd = static_cast<H264Stream*>(opaque)->pipe_;
    int written = 0;
    while (written < size) {
      pollfd waiting = {fd, POLLOUT, 0};
      const int ready = ::poll(&waiting, 1, kPipeWaitMs);
      if (ready == 0) return AVERROR(ETIMEDOUT);
      if (ready < 0 && errno == EINTR) continue;
      // As much as a pipe with room takes at once: more would block on standard output, which may not be non-blocking.
      const auto part = std::min<std::size_t>(static_cast<std::size_t>(size - written), PIPE_BUF);
      const ssize_t sent = ::write(fd, bytes + written, part);
      if (sent < 0 && (errno == EAGAIN || errno == EINTR)) continue;
      if (sent < 0) return AVERROR(errno);
      written += static_cast<int>(sent);
    }
    return written;
  }

  const drivers::PictureTarget& target_;
  const VideoSettings& settings_;
  RgbToYuv to_yuv_;
  int pipe_ = -1;
  AVFormatContext* format_ = nullptr;
  AVStream* stream_ = nullptr;     // owned by format_
  AVIOContext* own_io_ = nullptr;  // of a pipe
  AVCodecContext* codec_ = nullptr;
  AVFrame* frame_ = nullptr;
  AVPacket* packet_ = nullptr;
  std::optional<std::int64_t> first_pts_;
};

class VideoFileOutput final : public drivers::PictureOutput {
 public:
  VideoFileOutput(drivers::PictureTarget target, VideoSettings settings)
      : target_(std::move(target)),
        settings_(std::move(settings)),
        part_(target_.name + ".part"),
        stream_(target_, settings_) {}

  Status open() {
    FL_TRY(refuse_pipe_output(target_.name));
    FL_TRY(refuse_existing(target_.name, target_.overwrite));
    const char* container = "matroska";
    if (target_.name.ends_with(".mp4")) container = "mp4";
    if (target_.name.ends_with(".ts")) container = "mpegts";
    return stream_.open(part_, container, -1);
  }
  Status show(const drivers::Picture& picture, DurationNs time_ns) override { return stream_.add(picture, time_ns); }
  Status finish() override {
    FL_TRY(stream_.finish());
    std::error_code trouble;
    std::filesystem::rename(part_, target_.name, trouble);
    if (trouble) return fail(ErrorCode::kIo, "cannot be renamed from {}: {}", part_, trouble.message());
    return {};
  }

 private:
  const drivers::PictureTarget target_;
  const VideoSettings settings_;
  const std::string part_;
  H264Stream stream_;
};

class VideoPipeOutput final : public drivers::PictureOutput {
 public:
  VideoPipeOutput(drivers::PictureTarget target, VideoSettings settings)
      : target_(std::move(target)), settings_(std::move(settings)), is_standard_output_(target_.name == "-") {}

  Status show(const drivers::Picture& picture, DurationNs time_ns) override {
    if (!stream_) FL_TRY(open());
    const Status added = stream_->add(picture, time_ns);
    if (added) return {};
    close();
    // What follows would be no stream for whoever reads standard output.
    if (is_standard_output_) return fail(ErrorCode::kDisconnected, "{}", added.error().message);
    return added;
  }
  Status finish() override {
    const Status finished = stream_ ? stream_->finish() : Status();
    close();
    return finished;
  }

 private:
  Status open() {
    if (is_standard_output_) {
      pipe_ = drivers::Fd(::dup(STDOUT_FILENO));
    } else {
      pipe_ = drivers::Fd(::open(target_.name.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
    }
    if (!pipe_ && errno == ENXIO) return fail(ErrorCode::kIo, "no program reads the pipe");
    if (!pipe_) return fail(ErrorCode::kIo, "cannot be opened: {}", std::strerror(errno));
    auto stream = std::make_unique<H264Stream>(target_, settings_);
    FL_TRY(stream->open("pipe.ts", "mpegts", pipe_.get()));
    stream_ = std::move(stream);
    return {};
  }
  void close() {
    stream_.reset();
    pipe_.reset();
  }

  const drivers::PictureTarget target_;
  const VideoSettings settings_;
  const bool is_standard_output_;
  drivers::Fd pipe_;
  std::unique_ptr<H264Stream> stream_;
};

}  // namespace

Result<std::unique_ptr<drivers::PictureOutput>> open_video_output(const drivers::PictureTarget& target) {
  FL_ASSIGN(VideoSettings settings, read_video_settings(target));
  if (!settings.lossless && (target.width % 2 != 0 || target.height % 2 != 0)) {
    return fail(ErrorCode::kBadInput, "{}: a video needs an even width and height, got {}x{}", target.endpoint,
                target.width, target.height);
  }
  if (const Status has_libav = drivers::load_libav(); !has_libav) {
    return fail(has_libav.error().code, "{}: {}", target.endpoint, has_libav.error().message);
  }
  std::error_code ignored;
  if (target.name == "-" && ::isatty(STDOUT_FILENO) != 0) {
    return fail(ErrorCode::kBadInput, "{}: standard output is a terminal; pipe it into a program, as in | mpv -",
                target.endpoint);
  }
  if (target.name == "-" || std::filesystem::is_fifo(target.name, ignored)) {
    return std::unique_ptr<drivers::PictureOutput>(std::make_unique<VideoPipeOutput>(target, std::move(settings)));
  }
  const std::string& name = target.name;
  if (!name.ends_with(".mp4") && !name.ends_with(".mkv") && !name.ends_with(".ts")) {
    return fail(ErrorCode::kBadInput, "{}: videos are written as .mp4, .mkv or .ts, or as \"-\" into a pipe",
                target.endpoint);
  }
  auto file = std::make_unique<VideoFileOutput>(target, std::move(settings));
  const Status opened = file->open();
  if (!opened) return fail(opened.error().code, "{}: {}", target.endpoint, opened.error().message);
  return std::unique_ptr<drivers::PictureOutput>(std::move(file));
}

}  // namespace footlight::tools

#include "tools/footlight/vrsl/video_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include "drivers/av/libav.h"
#include "drivers/vrsl/grid.h"
#include "sim/file_kind.h"
#include "tools/footlight/vrsl/av_error.h"
#include "tools/footlight/vrsl/yuv.h"

namespace footlight::tools {
namespace {

// Times and lengths of damaged files may be any number: those whose differences could overflow count as missing.
constexpr std::int64_t kTicksMax = std::int64_t{1} << 60;
std::int64_t ticks_or_none(std::int64_t pts) { return pts >= -kTicksMax && pts <= kTicksMax ? pts : AV_NOPTS_VALUE; }
std::int64_t length_or(std::int64_t ticks, std::int64_t usual) {
  return ticks > 0 && ticks <= kTicksMax ? ticks : std::clamp<std::int64_t>(usual, 1, kTicksMax);
}

constexpr int kBandRows = 8;  // rows that are compared and converted together; even, for their chroma

std::string text_or_unknown(const char* text) { return text == nullptr ? "unknown" : text; }

class AvVideoReader final : public VideoReader {
 public:
  explicit AvVideoReader(std::string path) : path_(std::move(path)) {}
  ~AvVideoReader() override {
    sws_freeContext(scaler_);
    av_frame_free(&frame_);
    av_frame_free(&before_);
    close();
  }

  Status open();
  [[nodiscard]] Result<drivers::PictureStep> next(drivers::Picture& picture, std::optional<DurationNs>& time_ns,
                                                  DurationNs wait_ns) override;
  [[nodiscard]] const VideoFacts& facts() const override { return facts_; }
  [[nodiscard]] const VideoCounters& counters() const override { return counters_; }
  [[nodiscard]] Result<VideoTimes> read_times() override;
  Status seek(DurationNs time_ns) override;

 private:
  void close() {
    av_packet_free(&packet_);
    avcodec_free_context(&codec_);
    avformat_close_input(&format_);
  }
  Status open_again();
  [[nodiscard]] DurationNs time_of(std::int64_t pts) const {
    return av_rescale_q(pts - first_pts_.value_or(0), stream_->time_base, AVRational{1, static_cast<int>(kNsPerS)});
  }
  Status open_decoder(const AVCodec* decoder);
  void read_facts();
  void send_next_packet();
  [[nodiscard]] bool is_damaged();
  Status convert(drivers::Picture& picture);
  Status scale(drivers::Picture& picture);
  [[nodiscard]] std::optional<YuvView> planes_of(const AVFrame& frame) const;
  [[nodiscard]] bool same_rows(const YuvView& now, const YuvView& before, int first, int last) const;

  std::string path_;
  AVFormatContext* format_ = nullptr;
  AVStream* stream_ = nullptr;  // owned by format_
  AVCodecContext* codec_ = nullptr;
  AVFrame* frame_ = nullptr;
  AVFrame* before_ = nullptr;  // the picture before, of which `picture` has the pixels
  AVPacket* packet_ = nullptr;
  SwsContext* scaler_ = nullptr;
  YuvToRgb to_rgb_{YuvCoding{}};
  VideoFacts facts_;
  VideoCounters counters_;
  std::optional<std::int64_t> first_pts_;
  std::int64_t last_pts_ = 0;
  bool draining_ = false;
  bool wait_for_key_ = false;
  bool sought_ = false;  // wait_for_key_ is since a seek, not since damage
};

Status AvVideoReader::open() {
  FL_TRY(refuse_pipe_input(path_));
  std::error_code trouble;
  if (!std::filesystem::exists(path_, trouble)) return fail(ErrorCode::kNotFound, "{}: there is no such file", path_);
  if (std::filesystem::is_directory(path_, trouble)) {
    return fail(ErrorCode::kBadInput, "{}: a folder; expected a file with a video", path_);
  }
  av_log_set_level(AV_LOG_QUIET);  // damaged streams are counted, not printed
  const std::string url = "file:" + path_;
  const int opened = avformat_open_input(&format_, url.c_str(), nullptr, nullptr);
  if (opened == AVERROR(EACCES)) return fail(ErrorCode::kPermission, "{}: may not be read by this user", path_);
  if (opened < 0) {
    return fail(ErrorCode::kBadInput,
                "{}: cannot be read as video: {}. An .mp4 that was not finished has no index; write .mkv where a "
                "recording may be interrupted",
                path_, av_text(opened));
  }
  // Lists of other files: some are read again without end, and all name files that are not this one.
  const std::string_view kind = format_->iformat->name;
  for (const char* list : {"hls", "dash", "concat", "imf"}) {
    if (kind.find(list) == std::string_view::npos) continue;
    return fail(ErrorCode::kUnsupported, "{}: a list of other files ({}): expected one file with a video", path_, kind);
  }
  FL_TRY(av_check(avformat_find_stream_info(format_, nullptr), path_, "reading the streams", ErrorCode::kBadInput));
  const AVCodec* decoder = nullptr;
  const int index = av_find_best_stream(format_, AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (index == AVERROR_DECODER_NOT_FOUND) {
    return fail(ErrorCode::kUnsupported, "{}: the installed libavcodec cannot decode its video", path_);
  }
  if (index < 0)
    return fail(ErrorCode::kBadInput, "{}: has no video, only other streams; use a file with pictures", path_);
  stream_ = format_->streams[index];
  for (unsigned i = 0; i < format_->nb_streams; ++i) {
    if (static_cast<int>(i) != index) format_->streams[i]->discard = AVDISCARD_ALL;
  }
  FL_TRY(open_decoder(decoder));
  read_facts();
  return {};
}

Status AvVideoReader::open_decoder(const AVCodec* decoder) {
  const int size_max = std::max(stream_->codecpar->width, stream_->codecpar->height);
  if (size_max > drivers::kGridSizeMaxPx) {
    return fail(ErrorCode::kBadInput, "{}: pictures of {}x{}; expected at most {} pixels in both directions", path_,
                stream_->codecpar->width, stream_->codecpar->height, drivers::kGridSizeMaxPx);
  }
  codec_ = avcodec_alloc_context3(decoder);
  if (frame_ == nullptr) frame_ = av_frame_alloc();
  if (before_ == nullptr) before_ = av_frame_alloc();
  packet_ = av_packet_alloc();
  FL_TRY(av_check(avcodec_parameters_to_context(codec_, stream_->codecpar), path_, "describing the video",
                  ErrorCode::kBadInput));
  codec_->pkt_timebase = stream_->time_base;
  codec_->thread_count = 1;
  codec_->err_recognition = AV_EF_CAREFUL | AV_EF_CRCCHECK;
  codec_->max_pixels = std::int64_t{drivers::kGridSizeMaxPx} * drivers::kGridSizeMaxPx;
  return av_check(avcodec_open2(codec_, decoder, nullptr), path_, "starting the decoder", ErrorCode::kUnsupported);
}

void AvVideoReader::read_facts() {
  const AVCodecParameters& parameters = *stream_->codecpar;
  facts_.container = format_->iformat->name;
  facts_.codec = avcodec_get_name(parameters.codec_id);
  facts_.pixel_format = text_or_unknown(av_get_pix_fmt_name(static_cast<AVPixelFormat>(parameters.format)));
  facts_.range = text_or_unknown(av_color_range_name(parameters.color_range));
  facts_.matrix = text_or_unknown(av_color_space_name(parameters.color_space));
  facts_.transfer = text_or_unknown(av_color_transfer_name(parameters.color_trc));
  facts_.width = parameters.width;
  facts_.height = parameters.height;
  const AVRational rate = stream_->avg_frame_rate.num > 0 ? stream_->avg_frame_rate : stream_->r_frame_rate;
  if (rate.num > 0 && rate.den > 0) facts_.pictures_hz = av_q2d(rate);
  if (format_->duration > 0) facts_.duration_ns = format_->duration * (kNsPerS / AV_TIME_BASE);
}

void AvVideoReader::send_next_packet() {
  const int read = av_read_frame(format_, packet_);
  if (read == AVERROR(EAGAIN)) return;
  if (read < 0) {
    if (read != AVERROR_EOF || (format_->pb != nullptr && format_->pb->error < 0)) counters_.cut_off = true;
    draining_ = true;
    (void)avcodec_send_packet(codec_, nullptr);
    return;
  }
  if (packet_->stream_index == stream_->index) {
    if ((packet_->flags & AV_PKT_FLAG_CORRUPT) != 0) counters_.cut_off = true;
    if (avcodec_send_packet(codec_, packet_) < 0) {
      ++counters_.damaged;
      wait_for_key_ = true;
    }
  }
  av_packet_unref(packet_);
}

bool AvVideoReader::is_damaged() {
  if (frame_->decode_error_flags != 0 || (frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0) {
    wait_for_key_ = true;
    sought_ = false;
  } else if (frame_->key_frame != 0) {
    wait_for_key_ = sought_ = false;
  }
  return wait_for_key_;
}

Result<drivers::PictureStep> AvVideoReader::next(drivers::Picture& picture, std::optional<DurationNs>& time_ns,
                                                 DurationNs /*wait_ns*/) {
  while (true) {
    const int got = avcodec_receive_frame(codec_, frame_);
    if (got == AVERROR_EOF) return drivers::PictureStep::kEnd;
    if (got == AVERROR(EAGAIN)) {
      if (draining_) return drivers::PictureStep::kEnd;
      send_next_packet();
      continue;
    }
    if (got < 0) {
      ++counters_.damaged;
      wait_for_key_ = true;
      if (draining_) return drivers::PictureStep::kEnd;
      continue;
    }
    if (is_damaged()) {
      if (!sought_) ++counters_.damaged;
      continue;
    }
    FL_TRY(convert(picture));
    ++counters_.pictures;
    std::int64_t pts = ticks_or_none(frame_->best_effort_timestamp);
    if (pts == AV_NOPTS_VALUE) {
      pts = first_pts_ ? std::min(last_pts_ + length_or(frame_->pkt_duration, 1), kTicksMax) : 0;
    }
    if (!first_pts_) first_pts_ = pts;
    last_pts_ = pts;
    time_ns = time_of(pts);
    std::swap(frame_, before_);
    return drivers::PictureStep::kPicture;
  }
}

Status AvVideoReader::open_again() {
  close();
  draining_ = wait_for_key_ = sought_ = false;
  last_pts_ = 0;
  return open();
}

// Packets are in the order of decoding, times in that of showing. Packets without a time follow the one before.
Result<VideoTimes> AvVideoReader::read_times() {
  struct Entry {
    std::int64_t pts;
    std::int64_t length;
    bool key;
  };
  std::vector<Entry> entries;
  const auto usual = facts_.pictures_hz > 0 ? std::llround(1 / (facts_.pictures_hz * av_q2d(stream_->time_base))) : 1;
  while (av_read_frame(format_, packet_) >= 0) {
    if (packet_->stream_index == stream_->index && (packet_->flags & AV_PKT_FLAG_DISCARD) == 0) {
      std::int64_t pts = ticks_or_none(packet_->pts != AV_NOPTS_VALUE ? packet_->pts : packet_->dts);
      if (pts == AV_NOPTS_VALUE) {
        pts = entries.empty() ? 0 : std::min(entries.back().pts + entries.back().length, kTicksMax);
      }
      const std::int64_t length = length_or(packet_->duration, usual);
      entries.push_back({pts, length, (packet_->flags & AV_PKT_FLAG_KEY) != 0});
    }
    av_packet_unref(packet_);
  }
  if (entries.empty()) return fail(ErrorCode::kBadInput, "{}: has no pictures; use another file", path_);
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.pts < b.pts; });
  first_pts_ = entries.front().pts;
  VideoTimes times;
  for (const Entry& entry : entries) {
    const DurationNs start_ns = time_of(entry.pts);
    if (!times.starts_ns.empty() && start_ns <= times.starts_ns.back()) continue;  // fields of one picture
    times.starts_ns.push_back(start_ns);
    times.keys.push_back(entry.key);
  }
  times.end_ns = std::max(time_of(entries.back().pts + entries.back().length), times.starts_ns.back() + kNsPerMs);
  FL_TRY(open_again());
  return times;
}

Status AvVideoReader::seek(DurationNs time_ns) {
  const std::int64_t pts =
      first_pts_.value_or(0) + av_rescale_q(time_ns, AVRational{1, static_cast<int>(kNsPerS)}, stream_->time_base);
  if (time_ns <= 0 || av_seek_frame(format_, stream_->index, pts, AVSEEK_FLAG_BACKWARD) < 0) return open_again();
  avcodec_flush_buffers(codec_);
  draining_ = false;
  wait_for_key_ = sought_ = true;
  return {};
}

std::optional<YuvView> AvVideoReader::planes_of(const AVFrame& frame) const {
  const auto format = static_cast<AVPixelFormat>(frame.format);
  switch (format) {
    case AV_PIX_FMT_YUV420P:
    case AV_PIX_FMT_YUVJ420P:
    case AV_PIX_FMT_YUV422P:
    case AV_PIX_FMT_YUVJ422P:
    case AV_PIX_FMT_YUV444P:
    case AV_PIX_FMT_YUVJ444P: break;
    default: return std::nullopt;
  }
  const AVPixFmtDescriptor* const described = av_pix_fmt_desc_get(format);
  YuvView view;
  for (std::size_t i = 0; i < view.planes.size(); ++i) {
    view.planes[i] = frame.data[i];
    view.strides[i] = frame.linesize[i];
  }
  view.width = frame.width;
  view.height = frame.height;
  view.shift_x = described->log2_chroma_w;
  view.shift_y = described->log2_chroma_h;
  return view;
}

bool AvVideoReader::same_rows(const YuvView& now, const YuvView& before, int first, int last) const {
  for (std::size_t plane = 0; plane < 3; ++plane) {
    const int shift_x = plane == 0 ? 0 : now.shift_x;
    const int shift_y = plane == 0 ? 0 : now.shift_y;
    const auto bytes = static_cast<std::size_t>((now.width + (1 << shift_x) - 1) >> shift_x);
    for (int y = first >> shift_y; y < (last + (1 << shift_y) - 1) >> shift_y; ++y) {
      const std::uint8_t* const a = now.planes[plane] + y * now.strides[plane];
      if (std::memcmp(a, before.planes[plane] + y * before.strides[plane], bytes) != 0) return false;
    }
  }
  return true;
}

Status AvVideoReader::convert(drivers::Picture& picture) {
  const auto view = planes_of(*frame_);
  if (!view) return scale(picture);
  const bool is_jpeg = frame_->format == AV_PIX_FMT_YUVJ420P || frame_->format == AV_PIX_FMT_YUVJ422P ||
                       frame_->format == AV_PIX_FMT_YUVJ444P;
  YuvCoding coding;
  coding.full_range = is_jpeg || frame_->color_range == AVCOL_RANGE_JPEG;
  const bool named_601 = frame_->colorspace == AVCOL_SPC_BT470BG || frame_->colorspace == AVCOL_SPC_SMPTE170M;
  // Players assume BT.601 for small pictures that do not state it.
  const bool small = frame_->colorspace == AVCOL_SPC_UNSPECIFIED && frame_->height < 720;
  if (named_601 || small) coding.matrix = YuvMatrix::kBt601;
  const bool same_form = before_->width == frame_->width && before_->height == frame_->height &&
                         before_->format == frame_->format && to_rgb_.coding() == coding &&
                         picture.width == frame_->width && picture.height == frame_->height;
  if (!(to_rgb_.coding() == coding)) to_rgb_ = YuvToRgb(coding);
  if (!same_form) picture.clear(frame_->width, frame_->height);
  const auto before = same_form ? planes_of(*before_) : std::nullopt;
  for (int first = 0; first < view->height; first += kBandRows) {
    const int last = std::min(first + kBandRows, view->height);
    if (before && same_rows(*view, *before, first, last)) continue;
    to_rgb_.convert(*view, first, last, picture);
  }
  return {};
}

Status AvVideoReader::scale(drivers::Picture& picture) {
  const auto from = static_cast<AVPixelFormat>(frame_->format);
  scaler_ = sws_getCachedContext(scaler_, frame_->width, frame_->height, from, frame_->width, frame_->height,
                                 AV_PIX_FMT_RGB24, SWS_POINT | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT, nullptr, nullptr,
                                 nullptr);
  if (scaler_ == nullptr) {
    return fail(ErrorCode::kUnsupported, "{}: pictures of the format {} cannot be read", path_,
                text_or_unknown(av_get_pix_fmt_name(from)));
  }
  const int full = frame_->color_range == AVCOL_RANGE_JPEG ? 1 : 0;
  const int* const matrix =
      sws_getCoefficients(frame_->colorspace == AVCOL_SPC_UNSPECIFIED ? SWS_CS_ITU709 : frame_->colorspace);
  (void)sws_setColorspaceDetails(scaler_, matrix, full, matrix, 1, 0, 1 << 16, 1 << 16);
  if (picture.width != frame_->width || picture.height != frame_->height) {
    picture.clear(frame_->width, frame_->height);
  }
  std::uint8_t* const rows[] = {picture.rgb.data()};
  const int strides[] = {3 * picture.width};
  sws_scale(scaler_, frame_->data, frame_->linesize, 0, frame_->height, rows, strides);
  return {};
}

}  // namespace

Result<std::unique_ptr<VideoReader>> VideoReader::open(const std::string& path) {
  if (const Status has_libav = drivers::load_libav(); !has_libav) {
    return fail(has_libav.error().code, "{}: {}", path, has_libav.error().message);
  }
  auto reader = std::make_unique<AvVideoReader>(path);
  FL_TRY(reader->open());
  return reader;
}

Result<std::unique_ptr<drivers::PictureInput>> open_video_input(const drivers::PictureTarget& target) {
  if (!target.options.empty()) return drivers::unused_option(target, target.options.front().key);
  auto reader = VideoReader::open(target.name);
  if (!reader) return fail(reader.error().code, "{}: {}", target.endpoint, reader.error().message);
  return std::unique_ptr<drivers::PictureInput>(std::move(*reader));
}

}  // namespace footlight::tools

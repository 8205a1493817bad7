#include "drivers/sound/sound_file.h"

#include <array>
#include <cerrno>
#include <filesystem>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "drivers/av/libav.h"
#include "sim/sound/audio_link.h"

namespace footlight::drivers {
namespace {

constexpr int kDamagedRunMax = 1'000;  // packets after which a file counts as unreadable

std::string av_text(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  return av_strerror(code, text.data(), text.size()) == 0 ? text.data() : "unknown error";
}

template <auto Fn>
struct Frees {
  template <class T>
  void operator()(T* one) const {
    Fn(&one);
  }
};
using Format = std::unique_ptr<AVFormatContext, Frees<avformat_close_input>>;
using Codec = std::unique_ptr<AVCodecContext, Frees<avcodec_free_context>>;
using Packet = std::unique_ptr<AVPacket, Frees<av_packet_free>>;
using Frame = std::unique_ptr<AVFrame, Frees<av_frame_free>>;

template <class T>
void append(const AVFrame& frame, int channels, bool planar, float offset, double scale, std::vector<float>& out) {
  const auto count = static_cast<std::size_t>(channels);
  for (std::size_t i = 0; i < static_cast<std::size_t>(frame.nb_samples); ++i) {
    for (std::size_t channel = 0; channel < count; ++channel) {
      const auto* plane = reinterpret_cast<const T*>(frame.extended_data[planar ? channel : 0]);
      const T sample = planar ? plane[i] : plane[i * count + channel];
      out.push_back(static_cast<float>((static_cast<double>(sample) - offset) * scale));
    }
  }
}

bool append_frame(const AVFrame& frame, int channels, std::vector<float>& out) {
  const auto format = static_cast<AVSampleFormat>(frame.format);
  const bool planar = av_sample_fmt_is_planar(format) != 0;
  switch (av_get_packed_sample_fmt(format)) {
    case AV_SAMPLE_FMT_U8: append<std::uint8_t>(frame, channels, planar, 128, 1.0 / 128, out); return true;
    case AV_SAMPLE_FMT_S16: append<std::int16_t>(frame, channels, planar, 0, 1.0 / 32'768, out); return true;
    case AV_SAMPLE_FMT_S32: append<std::int32_t>(frame, channels, planar, 0, 1.0 / 2'147'483'648.0, out); return true;
    case AV_SAMPLE_FMT_FLT: append<float>(frame, channels, planar, 0, 1, out); return true;
    case AV_SAMPLE_FMT_DBL: append<double>(frame, channels, planar, 0, 1, out); return true;
    default: return false;
  }
}

class AvSoundFile final : public SoundFile {
 public:
  AvSoundFile(std::string path, Format format, Codec codec, int stream, SoundInfo info)
      : path_(std::move(path)),
        format_(std::move(format)),
        codec_(std::move(codec)),
        stream_(stream),
        info_(std::move(info)),
        packet_(av_packet_alloc()),
        frame_(av_frame_alloc()) {}

  [[nodiscard]] const SoundInfo& info() const override { return info_; }
  [[nodiscard]] std::uint64_t damaged_packets() const override { return damaged_; }

  Result<bool> read(std::vector<float>& interleaved) override {
    interleaved.clear();
    while (interleaved.empty()) {
      const int got = avcodec_receive_frame(codec_.get(), frame_.get());
      if (got == AVERROR_EOF) return false;
      if (got == AVERROR(EAGAIN)) {
        FL_TRY(feed());
        continue;
      }
      if (got < 0) {
        FL_TRY(count_damage(got));
        continue;
      }
      if (frame_->sample_rate != info_.rate_hz || frame_->ch_layout.nb_channels != info_.channels) {
        return fail(ErrorCode::kBadInput,
                    "{}: the sound changes from {} Hz and {} channels to {} Hz and {}; convert it", path_,
                    info_.rate_hz, info_.channels, frame_->sample_rate, frame_->ch_layout.nb_channels);
      }
      if (!append_frame(*frame_, info_.channels, interleaved)) {
        return fail(ErrorCode::kUnsupported, "{}: samples of format {} are not read; convert it to FLAC or WAV", path_,
                    frame_->format);
      }
      damaged_run_ = 0;
    }
    return true;
  }

 private:
  Status count_damage(int code) {
    ++damaged_;
    if (++damaged_run_ <= kDamagedRunMax) return {};
    return fail(ErrorCode::kBadInput, "{}: {} damaged packets in a row: {}", path_, damaged_run_, av_text(code));
  }

  // Gives the decoder the next packet of the stream, or the end.
  Status feed() {
    while (true) {
      const int got = av_read_frame(format_.get(), packet_.get());
      if (got < 0) {  // the end; a file that is cut off ends here too
        if (got != AVERROR_EOF) ++damaged_;
        avcodec_send_packet(codec_.get(), nullptr);
        return {};
      }
      const bool ours = packet_->stream_index == stream_;
      const int sent = ours ? avcodec_send_packet(codec_.get(), packet_.get()) : 0;
      av_packet_unref(packet_.get());
      if (!ours) continue;
      if (sent < 0) FL_TRY(count_damage(sent));
      return {};
    }
  }

  std::string path_;
  Format format_;
  Codec codec_;
  int stream_;
  SoundInfo info_;
  Packet packet_;
  Frame frame_;
  std::uint64_t damaged_ = 0;
  int damaged_run_ = 0;
};

Status check_file(const std::string& path) {
  std::error_code trouble;
  const auto status = std::filesystem::status(path, trouble);
  if (!std::filesystem::exists(status)) return fail(ErrorCode::kNotFound, "{}: there is no such file", path);
  // Protocols of libav (http:, concat:) and pipes are not opened.
  if (!std::filesystem::is_regular_file(status)) return fail(ErrorCode::kBadInput, "{}: expected a sound file", path);
  return {};
}

}  // namespace

Result<std::unique_ptr<SoundFile>> SoundFile::open(const std::string& path) {
  FL_TRY(check_file(path));
  if (const Status has_libav = load_libav(); !has_libav) {
    return fail(has_libav.error().code, "{}: {}", path, has_libav.error().message);
  }
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* opened = nullptr;
  const int got = avformat_open_input(&opened, ("file:" + path).c_str(), nullptr, nullptr);
  if (got == AVERROR(EACCES)) return fail(ErrorCode::kPermission, "{}: permission denied", path);
  if (got < 0) {
    return fail(ErrorCode::kBadInput, "{}: expected a sound file, as FLAC, WAV, MP3 or Ogg: {}", path, av_text(got));
  }
  Format format(opened);
  if (const int found = avformat_find_stream_info(format.get(), nullptr); found < 0) {
    return fail(ErrorCode::kBadInput, "{}: cannot be read as a sound file: {}", path, av_text(found));
  }
  const AVCodec* decoder = nullptr;
  const int stream = av_find_best_stream(format.get(), AVMEDIA_TYPE_AUDIO, -1, -1, &decoder, 0);
  if (stream == AVERROR_DECODER_NOT_FOUND) {
    return fail(ErrorCode::kUnsupported, "{}: the installed libavcodec cannot decode its sound; convert it to FLAC",
                path);
  }
  if (stream < 0) return fail(ErrorCode::kBadInput, "{}: contains no sound", path);
  const AVCodecParameters& parameters = *format->streams[stream]->codecpar;
  Codec codec(avcodec_alloc_context3(decoder));
  avcodec_parameters_to_context(codec.get(), &parameters);
  if (const int started = avcodec_open2(codec.get(), decoder, nullptr); started < 0) {
    return fail(ErrorCode::kBadInput, "{}: its sound cannot be decoded: {}", path, av_text(started));
  }
  SoundInfo info{codec->sample_rate, codec->ch_layout.nb_channels, avcodec_get_name(codec->codec_id),
                 format->iformat->name};
  if (info.rate_hz < kSoundRateMinHz || info.rate_hz > kSoundRateMaxHz) {
    return fail(ErrorCode::kBadInput, "{}: has {} samples a second; expected {} to {}", path, info.rate_hz,
                kSoundRateMinHz, kSoundRateMaxHz);
  }
  if (info.channels < 1 || info.channels > kSoundChannelsMax) {
    return fail(ErrorCode::kBadInput, "{}: has {} channels; expected 1 to {}", path, info.channels, kSoundChannelsMax);
  }
  return std::make_unique<AvSoundFile>(path, std::move(format), std::move(codec), stream, std::move(info));
}

}  // namespace footlight::drivers

#include "tools/footlight/sound/texture_stream.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include "drivers/vrsl/picture_port.h"
#include "sim/core/endpoint.h"
#include "sim/sound/audio_texture.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/pictures/numbered_file.h"
#include "tools/footlight/sound/live_sound.h"
#include "tools/footlight/sound/sound_log.h"
#include "tools/footlight/vrsl/open_pictures.h"
#include "tools/footlight/vrsl/png_pictures.h"
#include "tools/footlight/vrsl/v4l2_pictures.h"
#include "tools/footlight/vrsl/video_reader.h"

namespace footlight::tools {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr DurationNs kEveryMinNs = kNsPerS / 240;
constexpr DurationNs kEveryMaxNs = 10 * kNsPerS;
constexpr DurationNs kStopLookNs = 50 * kNsPerMs;
constexpr DurationNs kReadTimeoutNs = 100 * kNsPerMs;
constexpr DurationNs kSilentMaxNs = 3 * kNsPerS;
constexpr int kScaleMax = 16;

Result<drivers::PictureTarget> target_of(const TextureStream& stream) {
  drivers::PictureTarget target;
  target.endpoint = "-o " + stream.target;
  if (stream.every_ns < kEveryMinNs || stream.every_ns > kEveryMaxNs) {
    return fail(ErrorCode::kBadInput, "--every {}: expected 4.2 ms to 10 s", show_duration(stream.every_ns));
  }
  auto endpoint = parse_endpoint("vrsl:1@" + stream.target, {});
  if (!endpoint) {
    return fail(ErrorCode::kBadInput, "{}: expected a target and its options, as in texture.mkv?lossless=yes",
                target.endpoint);
  }
  target.name = endpoint->target;
  target.pictures_hz = static_cast<double>(kNsPerS) / static_cast<double>(stream.every_ns);
  target.width = kAudioTextureWidth * stream.scale;
  target.height = kAudioTextureHeight * stream.scale;
  target.options = std::move(endpoint->options);
  return target;
}

class TextureWriter {
 public:
  TextureWriter(const fixtures::SoundMap& map, const TextureStream& stream, const std::function<bool()>& stopping,
                std::unique_ptr<drivers::PictureOutput> output, bool paced, bool retries)
      : map_(map),
        stream_(stream),
        stopping_(stopping),
        output_(std::move(output)),
        paced_(paced),
        retries_(retries) {}

  // The state at a time is that of the last step at or before it.
  void step(const AudioLinkState& state) {
    while (more() && step_time_ns(state.step) > due_ns_) show();
    before_ = state;
  }
  // The pictures up to the end of the sound.
  void end(DurationNs length_ns) {
    while (more() && due_ns_ <= length_ns) show();
  }
  [[nodiscard]] bool more() const {
    return status_ && !closed_ && !stopping_() && (stream_.length_ns < 0 || due_ns_ < stream_.length_ns);
  }
  [[nodiscard]] Result<std::uint64_t> finish() {
    if (status_ && !closed_) status_ = output_->finish();
    if (!status_) return fail(status_.error().code, "-o {}: {}", stream_.target, status_.error().message);
    return count_;
  }

 private:
  void show() {
    paint_texture(audio_texture(before_, map_.theme), stream_.scale, picture_);
    if (paced_ && !wait()) return;
    const Status shown = output_->show(picture_, due_ns_);
    if (shown) {
      ++count_;
    } else if (shown.error().code == ErrorCode::kDisconnected) {
      closed_ = true;
    } else if (!retries_ || shown.error().code != ErrorCode::kIo) {
      status_ = shown;
    }
    ++number_;
    due_ns_ = number_ * stream_.every_ns;
  }
  // False if it is to stop.
  [[nodiscard]] bool wait() const {
    const auto at = start_ + std::chrono::nanoseconds(due_ns_);
    while (!stopping_()) {
      const auto now = SteadyClock::now();
      if (now >= at) return true;
      std::this_thread::sleep_until(std::min(at, now + std::chrono::nanoseconds(kStopLookNs)));
    }
    return false;
  }

  const fixtures::SoundMap& map_;
  const TextureStream& stream_;
  const std::function<bool()>& stopping_;
  std::unique_ptr<drivers::PictureOutput> output_;
  const bool paced_;    // each picture at its time
  const bool retries_;  // after kIo the next picture is tried
  const SteadyClock::time_point start_ = SteadyClock::now();
  AudioLinkState before_;
  drivers::Picture picture_;
  Status status_;
  bool closed_ = false;
  DurationNs due_ns_ = 0;
  std::int64_t number_ = 0;
  std::uint64_t count_ = 0;
};

Status listen(const fixtures::SoundMap& map, drivers::SoundDevice& device, TextureWriter& writer) {
  AudioLink link(map.link, device.info().rate_hz, device.info().channels);
  const auto start = SteadyClock::now();
  std::vector<float> samples;
  DurationNs silent_ns = 0;
  while (writer.more()) {
    FL_TRY(device.read(samples, kReadTimeoutNs));
    silent_ns = samples.empty() ? silent_ns + kReadTimeoutNs : 0;
    if (silent_ns >= kSilentMaxNs) return fail(ErrorCode::kIo, "{}: the device gives no samples", map.sound);
    link.push(samples, [&](const AudioLinkState& state) { writer.step(state); });
    const std::chrono::nanoseconds elapsed = SteadyClock::now() - start;
    const DurationNs pause_ns = read_pause_ns(link.frames(), device.info().rate_hz, elapsed.count());
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(pause_ns, kStopLookNs)));
  }
  return {};
}

Status play(const fixtures::SoundMap& map, drivers::SoundFile& file, TextureWriter& writer) {
  FL_ASSIGN(const std::uint64_t frames, run_sound_file(
                                            file, map.link, [&](const AudioLinkState& state) { writer.step(state); },
                                            [&](std::span<const float>) { return writer.more(); }));
  writer.end(std::llround(static_cast<double>(frames) / file.info().rate_hz * 1e9));
  return {};
}

}  // namespace

void paint_texture(const std::vector<float>& texture, int scale, drivers::Picture& picture) {
  picture.clear(kAudioTextureWidth * scale, kAudioTextureHeight * scale);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto texel = static_cast<std::size_t>(y / scale * kAudioTextureWidth + x / scale) * 4;
      std::uint8_t* const pixel = picture.at(x, y);
      for (std::size_t i = 0; i < 3; ++i) {
        pixel[i] = static_cast<std::uint8_t>(std::lround(std::clamp(texture[texel + i], 0.0F, 1.0F) * 255));
      }
    }
  }
}

Result<std::uint64_t> write_texture_stream(const fixtures::SoundMap& map, const TextureStream& stream,
                                           const std::function<bool()>& stopping) {
  if (stream.scale < 1 || stream.scale > kScaleMax) {
    return fail(ErrorCode::kBadInput, "--scale {}: expected 1 to {}", stream.scale, kScaleMax);
  }
  FL_ASSIGN(const drivers::PictureTarget target, target_of(stream));
  std::error_code ignored;
  const bool is_pipe = std::filesystem::is_fifo(target.name, ignored);
  const bool is_film = !is_pipe && (is_video_name(target.name) ||
                                    (is_picture_file(target.name) && is_numbered(target.name)));
  // The sound is opened first, so that a missing one leaves no file.
  std::unique_ptr<drivers::SoundDevice> device;
  std::unique_ptr<drivers::SoundFile> file;
  if (is_sound_device(map.sound)) {
    FL_ASSIGN(device, open_sound_device(map.sound));
  } else {
    FL_ASSIGN(file, drivers::SoundFile::open(map.sound));
  }
  FL_ASSIGN(auto output, open_picture_output(target));
  // A pipe may get a reader, and a video device a program, later.
  TextureWriter writer(map, stream, stopping, std::move(output), !is_film && device == nullptr,
                       is_pipe || is_v4l2_target(target.name));
  const Status heard = device ? listen(map, *device, writer) : play(map, *file, writer);
  auto count = writer.finish();  // what came before an error is kept
  FL_TRY(heard);
  return count;
}

}  // namespace footlight::tools

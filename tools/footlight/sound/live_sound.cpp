#include "tools/footlight/sound/live_sound.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>

#include "drivers/fd.h"
#include "drivers/sound/mock_sound.h"
#include "sim/core/endpoint.h"
#include "sim/core/no_signals.h"
#include "tools/footlight/sound/sound_log.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kReadTimeoutNs = 100 * kNsPerMs;  // how long the end of the thread may take
constexpr DurationNs kRetryMinNs = 10 * kNsPerMs;
constexpr DurationNs kRetryMaxNs = kNsPerS;
constexpr DurationNs kSilentMaxNs = 3 * kNsPerS;  // a device without samples for so long counts as gone
constexpr DurationNs kAheadMaxNs = 50 * kNsPerMs;
constexpr DurationNs kFastCardShare = 1'000;  // clocks of cards differ by less than one part in so many

using Levels = std::map<Universe, fixtures::SoundLevels::Slots>;
using Device = std::unique_ptr<drivers::SoundDevice>;

class LiveSound final : public Source {
 public:
  LiveSound(fixtures::SoundLevels levels, OpenSoundDevice open, LiveSoundOptions options, Device device)
      : options_(std::move(options)), open_(std::move(open)), levels_(std::move(levels)) {
    for (const auto& [universe, slots] : levels_.universes()) universes_.push_back(universe);
    state_ = device ? PortState::kWaiting : PortState::kGone;
    if (!device) trouble_ = "not found yet";
    const NoSignals no_signals;
    thread_ = std::jthread(
        [this, held = std::move(device)](const std::stop_token& stop) mutable { run(stop, std::move(held)); });
  }

  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] int poll_fd() const override { return event_.get(); }
  [[nodiscard]] PortState state() const override {
    const std::lock_guard lock(mutex_);
    return state_;
  }
  [[nodiscard]] std::string trouble() const override {
    const std::lock_guard lock(mutex_);
    return trouble_;
  }
  [[nodiscard]] PortCounters counters() const override {
    const std::lock_guard lock(mutex_);
    return counters_;
  }
  [[nodiscard]] std::span<const Universe> universes() const override { return universes_; }

  Status poll(TimeNs now_ns, FrameReceiver& receiver) override {
    event_.clear();
    {
      const std::lock_guard lock(mutex_);
      if (!fresh_) return {};
      fresh_ = false;
      std::swap(taken_, newest_);
      counters_.frames += taken_.size();
    }
    for (const auto& [universe, slots] : taken_) {
      FrameView frame;
      frame.universe = universe;
      frame.stamp_ns = now_ns;
      frame.priority = static_cast<std::uint8_t>(options_.priority);
      frame.slots = slots;
      receiver.receive(frame);
    }
    return {};
  }

 private:
  void run(const std::stop_token& stop, Device device) {
    DurationNs retry_ns = kRetryMinNs;
    while (!stop.stop_requested()) {
      if (device) {
        if (listen(stop, *device)) retry_ns = kRetryMinNs;
        device.reset();
      }
      if (pause(stop, retry_ns)) return;
      retry_ns = std::min(2 * retry_ns, kRetryMaxNs);
      auto opened = open_();
      if (opened) {
        device = std::move(*opened);
        report(PortState::kWaiting, {});
      } else {
        report(PortState::kGone, opened.error().message);
      }
    }
  }

  // Until the device is gone. True if it gave samples.
  bool listen(const std::stop_token& stop, drivers::SoundDevice& device) {
    AudioLink link(options_.link, device.info().rate_hz, device.info().channels);
    std::vector<float> samples;
    DurationNs silent_ns = 0;
    std::uint64_t overruns = 0;
    const auto gave_samples = [&link] { return link.frames() > 0; };
    const auto start = std::chrono::steady_clock::now();
    while (!stop.stop_requested()) {
      if (const Status read = device.read(samples, kReadTimeoutNs); !read) {
        report(PortState::kGone, read.error().message);
        return gave_samples();
      }
      silent_ns = samples.empty() ? silent_ns + kReadTimeoutNs : 0;
      if (silent_ns >= kSilentMaxNs) {
        report(PortState::kGone, "the device gives no samples");
        return gave_samples();
      }
      link.push(samples, [this](const AudioLinkState& state) {
        levels_.step(state);
        offer();
      });
      if (device.overruns() != overruns) {
        const std::lock_guard lock(mutex_);
        counters_.errors += device.overruns() - overruns;
        overruns = device.overruns();
      }
      const std::chrono::nanoseconds elapsed = std::chrono::steady_clock::now() - start;
      const DurationNs wait_ns = read_pause_ns(link.frames(), device.info().rate_hz, elapsed.count());
      if (wait_ns > 0 && pause(stop, wait_ns)) break;
    }
    return gave_samples();
  }

  // True if the thread is to end.
  bool pause(const std::stop_token& stop, DurationNs duration_ns) {
    std::unique_lock lock(pause_mutex_);
    pause_.wait_for(lock, stop, std::chrono::nanoseconds(duration_ns), [] { return false; });
    return stop.stop_requested();
  }

  void offer() {
    {
      const std::lock_guard lock(mutex_);
      if (fresh_) counters_.dropped += universes_.size();
      newest_ = levels_.universes();
      fresh_ = true;
      state_ = PortState::kWorking;
      trouble_.clear();
    }
    event_.signal();
  }

  void report(PortState state, std::string trouble) {
    {
      const std::lock_guard lock(mutex_);
      state_ = state;
      trouble_ = std::move(trouble);
    }
    event_.signal();
  }

  const LiveSoundOptions options_;
  const OpenSoundDevice open_;
  fixtures::SoundLevels levels_;  // of the thread
  std::vector<Universe> universes_;
  drivers::EventFd event_;
  mutable std::mutex mutex_;
  // Guarded by mutex_.
  Levels newest_;
  bool fresh_ = false;
  PortState state_ = PortState::kWaiting;
  std::string trouble_;
  PortCounters counters_;
  Levels taken_;  // of the pump's thread
  std::mutex pause_mutex_;
  std::condition_variable_any pause_;
  std::jthread thread_;  // last member: it ends before the members that it uses
};

}  // namespace

DurationNs read_pause_ns(std::uint64_t frames, int rate_hz, DurationNs elapsed_ns) {
  const auto rate = static_cast<std::uint64_t>(rate_hz);
  const auto ns_per_s = static_cast<std::uint64_t>(kNsPerS);
  const std::uint64_t played_ns = frames / rate * ns_per_s + frames % rate * ns_per_s / rate;  // no product wraps
  const DurationNs ahead_ns = static_cast<DurationNs>(played_ns) - elapsed_ns - elapsed_ns / kFastCardShare;
  return ahead_ns > kAheadMaxNs ? ahead_ns : 0;
}

Result<std::unique_ptr<Source>> make_live_sound(fixtures::SoundLevels levels, OpenSoundDevice open,
                                                const LiveSoundOptions& options) {
  auto device = open();
  if (!device && (!options.wait_for_device || device.error().code == ErrorCode::kUnsupported)) {
    return fail(device.error().code, "{}: {}", options.name, device.error().message);
  }
  return std::make_unique<LiveSound>(std::move(levels), std::move(open), options,
                                     device ? std::move(*device) : nullptr);
}

Result<std::unique_ptr<Source>> open_live_sound(const fixtures::SoundMap& map, const LiveSoundOptions& options) {
  FL_ASSIGN(fixtures::SoundLevels levels, sound_levels_of(map));
  LiveSoundOptions with_link = options;
  with_link.link = map.link;
  return make_live_sound(
      std::move(levels), [sound = map.sound] { return open_sound_device(sound); }, with_link);
}

Result<std::unique_ptr<drivers::SoundDevice>> open_sound_device(const std::string& sound) {
  if (sound == kMockSound) return drivers::make_mock_sound();
  return drivers::SoundDevice::open(sound.starts_with("alsa:") ? sound.substr(5) : "");
}

}  // namespace footlight::tools

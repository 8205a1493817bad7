#include "drivers/sound/mock_sound.h"

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <thread>
#include <utility>

namespace footlight::drivers {
namespace {

constexpr int kMockRateHz = 48'000;
constexpr std::uint64_t kMockReadFrames = 480;
constexpr DurationNs kMockReadNs = 10 * kNsPerMs;
constexpr std::uint64_t kBeatFrames = static_cast<std::uint64_t>(kMockRateHz * 60 / kMockSoundBpm);
constexpr std::uint64_t kBarFrames = 4 * kBeatFrames;

double mock_sine(double hz, std::uint64_t frame) {
  // Whole frequencies repeat each second, so that the phase stays exact.
  return std::sin(2 * std::numbers::pi * hz * static_cast<double>(frame % kMockRateHz) / kMockRateHz);
}

// From -1 to 1, of the frame's number alone.
double mock_noise(std::uint64_t frame) {
  std::uint64_t bits = (frame + 1) * 0x9E3779B97F4A7C15ULL;
  bits ^= bits >> 31;
  bits *= 0xBF58476D1CE4E5B9ULL;
  return static_cast<double>(bits >> 11) / 4'503'599'627'370'496.0 - 1;
}

// Sleeps until a time since its first call.
class SteadyWait {
 public:
  void operator()(DurationNs time_ns) {
    if (!start_) start_ = std::chrono::steady_clock::now();
    std::this_thread::sleep_until(*start_ + std::chrono::nanoseconds(time_ns));
  }

 private:
  std::optional<std::chrono::steady_clock::time_point> start_;
};

class MockSound final : public SoundDevice {
 public:
  explicit MockSound(WaitUntil wait) : wait_(std::move(wait)) {}
  [[nodiscard]] const SoundInfo& info() const override { return info_; }
  [[nodiscard]] std::uint64_t overruns() const override { return 0; }
  Status read(std::vector<float>& interleaved, DurationNs /*timeout_ns*/) override {
    interleaved.clear();
    if (frame_ == 0) wait_(0);
    const std::uint64_t reads = frame_ / kMockReadFrames + 1;
    wait_(static_cast<DurationNs>(reads) * kMockReadNs);
    for (std::uint64_t i = 0; i < kMockReadFrames; ++i, ++frame_) {
      const double since_beat_s = static_cast<double>(frame_ % kBeatFrames) / kMockRateHz;
      const double since_off_beat_s = static_cast<double>((frame_ + kBeatFrames / 2) % kBeatFrames) / kMockRateHz;
      const bool second_chord = frame_ / kBarFrames % 2 == 1;
      const double kick = 0.6 * mock_sine(60, frame_) * std::exp(-since_beat_s / 0.08);
      const double hiss = 0.5 * mock_noise(frame_) * std::exp(-since_off_beat_s / 0.06);
      const double chord =
          0.14 * (mock_sine(second_chord ? 294 : 220, frame_) + mock_sine(second_chord ? 440 : 330, frame_));
      interleaved.push_back(static_cast<float>(kick + chord + hiss));
      interleaved.push_back(static_cast<float>(kick + chord + hiss / 2));
    }
    return {};
  }

 private:
  WaitUntil wait_;
  SoundInfo info_{kMockRateHz, 2, "mock", "mock"};
  std::uint64_t frame_ = 0;
};

}  // namespace

std::unique_ptr<SoundDevice> make_mock_sound(WaitUntil wait) {
  return std::make_unique<MockSound>(wait ? std::move(wait) : WaitUntil(SteadyWait()));
}

}  // namespace footlight::drivers

#include "sim/sound/audio_meter.h"

#include <algorithm>
#include <cmath>

namespace footlight {
namespace {

constexpr float kHeldMaxS = 1;
constexpr float kMarkerHeldMaxS = 0.5;
constexpr double kFilterLeftPerS = 0.046;
constexpr float kSlowPeakLeft = 0.95F;  // a step

}  // namespace

void AudioMeter::step(const LevelAndPeak& now) {
  const auto step_s = static_cast<float>(step_s_);
  for (std::size_t i = 0; i < now.size(); ++i) {
    state_.held_s[i] += step_s;
    if (state_.held[i] >= now[i] && state_.held_s[i] <= kHeldMaxS) continue;
    state_.held[i] = now[i];
    state_.held_s[i] = 0;
  }
  state_.slow_peak = now[1] + (state_.slow_peak - now[1]) * kSlowPeakLeft;
  for (std::size_t i = 0; i < state_.filters.size(); ++i) {
    MeterState::Filter& filter = state_.filters[i];
    const auto left = static_cast<float>(std::pow(kFilterLeftPerS, step_s_ * static_cast<double>(i + 1)));
    filter.level = now[0] + (filter.level - now[0]) * left;
    const float apart = std::abs(filter.marker - filter.held);
    filter.marker += (filter.held - filter.marker) * (0.1F - 0.05F * std::min(apart, 1.0F));
    filter.marker = std::max(filter.level, filter.marker);
    if (filter.level > filter.held || filter.held_s > kMarkerHeldMaxS) {
      filter.held = filter.level;
      filter.held_s = 0;
    } else {
      filter.held_s += step_s;
    }
  }
  std::copy_backward(state_.history.begin(), state_.history.end() - 1, state_.history.end());
  state_.history[0] = (now[0] + now[2]) / 2;
}

}  // namespace footlight

#include "sim/vrsl_compat_time.h"

#include <algorithm>
#include <cmath>

namespace footlight {

namespace {

constexpr float kTurn = 6.2831853f;
constexpr float kClampMost = 1e6f;  // of phases
constexpr double kMovementStartS = 3;
constexpr double kPhaseStartS = 1;

float mix(float a, float b, float share) { return a + (b - a) * share; }

bool is_step(float dt_s) { return dt_s >= 0 && std::isfinite(dt_s); }

// Clamps a raw value to 0 to 1; NaN gives 0.
float value_of(float raw) { return raw > 0 ? std::min(raw, 1.0f) : 0.0f; }

}  // namespace

const VrslValues& VrslMovement::step(const VrslValues& raw, float dt_s) {
  if (!is_step(dt_s)) return out_;
  clock_s_ += static_cast<double>(dt_s);
  for (int i = 0; i < kVrslChannels; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const float target = value_of(raw[at]);
    if (clock_s_ < kMovementStartS) {
      out_[at] = target;
      continue;
    }
    const int speed_at = i / kVrslRow * kVrslRow + kVrslRow - 1;
    const float speed = speed_at < kVrslChannels ? value_of(raw[static_cast<std::size_t>(speed_at)]) : 0;
    const float left = mix(settings_.slowest, settings_.fastest, speed);
    out_[at] = mix(out_[at], target, 1 - std::pow(left, dt_s));
    out_[at] = mix(out_[at], target, 0.1f * speed);
  }
  return out_;
}

const VrslValues& VrslColor::step(const VrslValues& raw, float dt_s) {
  if (!is_step(dt_s)) return out_;
  clock_s_ += static_cast<double>(dt_s);
  const float part = std::clamp(dt_s, 0.0f, 1.0f);
  const float eased = part * part * (3 - 2 * part);
  for (std::size_t i = 0; i < out_.size(); ++i) {
    const float target = value_of(raw[i]);
    out_[i] = clock_s_ < kMovementStartS ? target : mix(mix(out_[i], target, eased), target, settings_.color_smoothing);
  }
  return out_;
}

const VrslValues& VrslStrobe::step(const VrslValues& raw, const VrslValues& color_smoothed, float dt_s) {
  if (!is_step(dt_s)) return gate_;
  clock_s_ += static_cast<double>(dt_s);
  const float part_s = std::min(dt_s, 2.0f);
  for (std::size_t i = 0; i < gate_.size(); ++i) {
    const float value = value_of(raw[i]);
    if (settings_.static_strobe) {
      const float rate = value <= 0.2f   ? settings_.strobe_low_rad_s
                         : value <= 0.5f ? settings_.strobe_medium_rad_s
                                         : settings_.strobe_high_rad_s;
      phase_[i] = static_cast<float>(clock_s_) * rate;
    } else if (clock_s_ < kPhaseStartS) {
      phase_[i] = value;
    } else {
      phase_[i] += part_s * value * settings_.strobe_dynamic_rad_s;
      if (phase_[i] >= kTurn) phase_[i] -= kTurn;
      phase_[i] = std::clamp(phase_[i], 0.0f, kClampMost);
    }
    gate_[i] = std::sin(phase_[i]) > 0 ? 1.0f : 0.0f;
    if (value_of(color_smoothed[i]) <= settings_.strobe_threshold) gate_[i] = 1;
  }
  return gate_;
}

const VrslValues& VrslSpin::step(const VrslValues& raw, float dt_s) {
  if (!is_step(dt_s)) return angle_;
  clock_s_ += static_cast<double>(dt_s);
  for (std::size_t i = 0; i < angle_.size(); ++i) {
    const float value = value_of(raw[i]);
    if (value < 0.01f) {
      if (!holds_) phase_[i] = 0;
    } else if (clock_s_ < kPhaseStartS) {
      phase_[i] = value;
    } else {
      phase_[i] += dt_s * (value <= 0.5f ? value : value - 0.5f);
    }
    angle_[i] = value > 0.5f ? -4 * phase_[i] : 4 * phase_[i];
  }
  return angle_;
}

int vrsl_gobo(std::uint8_t level) { return vrsl_gobo_of(static_cast<float>(level) / 255.0f, false); }

int vrsl_gobo_of(float value, bool legacy) {
  const float place = value_of(value) * 255.0f / (legacy ? 42.5f : 30.0f);
  return std::clamp(static_cast<int>(std::nearbyint(place)), 1, 8);
}

float vrsl_angle_deg(std::uint8_t level, float range_deg) {
  return range_deg * (static_cast<float>(level) / 255.0f) - range_deg / 2;
}

}  // namespace footlight

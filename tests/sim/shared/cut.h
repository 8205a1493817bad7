// Divides the same time into frames of different lengths: the results of exact models must not differ.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include "sim/shared/shared.h"

namespace footlight {

struct Float {
  using Real = float;
  using Axis = f32::Axis;
  using Motor = f32::Motor;
  using MotorLimits = f32::MotorLimits;
  using Flex = f32::Flex;
  using FlexLimits = f32::FlexLimits;
  using Spin = f32::Spin;
  using Shutter = f32::Shutter;
  using ShutterParams = f32::ShutterParams;
};
struct Double {
  using Real = double;
  using Axis = f64::Axis;
  using Motor = f64::Motor;
  using MotorLimits = f64::MotorLimits;
  using Flex = f64::Flex;
  using FlexLimits = f64::FlexLimits;
  using Spin = f64::Spin;
  using Shutter = f64::Shutter;
  using ShutterParams = f64::ShutterParams;
};

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kRateRandom = -1;  // random frame lengths from 1 us to 90 ms
// Frames per second, in thousandths.
constexpr std::int64_t kFrameRates_mHz[] = {15'000, 24'000, 44'100, 60'000, 144'000, 240'000, 1'000'000, kRateRandom};

inline glm::uvec2 words(std::uint64_t value) {
  return {static_cast<std::uint32_t>(value), static_cast<std::uint32_t>(value >> 32)};
}
inline std::uint64_t number(glm::uvec2 value) { return static_cast<std::uint64_t>(value.y) << 32 | value.x; }

// A number in [0, 1), determined by two numbers.
inline double chance(std::uint32_t seed, std::uint32_t index) { return f64::hash_two(seed, index) / 4294967296.0; }

// The number of trials in searches for non-finite values: 1e5, or the value of FOOTLIGHT_HUNT_TRIALS.
inline int hunt_trials() {
  const char* value = std::getenv("FOOTLIGHT_HUNT_TRIALS");
  return value != nullptr ? std::max(std::atoi(value), 1) : 100'000;
}

// A random time from 0 to 60 s: often short, often 0.
inline std::int64_t random_ns(std::mt19937_64& random) {
  const std::int64_t most[] = {1, 1000, 1'000'000, kSecondNs / 40, kSecondNs, 60 * kSecondNs};
  return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(most[random() % 6]));
}

// Runs a model for `length_ns` in frames of `rate_mHz`, also divided where the input changes (every change_ns) and at
// whole seconds. Returns the model's value at each whole second. The model: step(change, dt_ns), value().
template <class Model>
std::vector<double> run_cut(Model model, std::int64_t rate_mHz, std::int64_t change_ns, std::int64_t length_ns) {
  std::mt19937_64 random(99);
  std::vector<double> values;
  std::int64_t now = 0;
  std::int64_t frame = 0;
  std::int64_t frame_end = 0;
  while (now < length_ns) {
    while (frame_end <= now) {
      ++frame;
      frame_end = rate_mHz == kRateRandom ? now + 1000 + static_cast<std::int64_t>(random() % 90'000'000)
                                          : frame * 1000 * kSecondNs / rate_mHz;
    }
    const std::int64_t change = now / change_ns;
    const std::int64_t second_end = (now / kSecondNs + 1) * kSecondNs;
    const std::int64_t next = std::min({frame_end, (change + 1) * change_ns, second_end});
    model.step(static_cast<std::uint32_t>(change), words(static_cast<std::uint64_t>(next - now)));
    now = next;
    if (now == second_end) values.push_back(model.value());
  }
  return values;
}

// Largest difference between frame rates over 60 s.
template <class Model>
double rate_spread(const Model& model, std::int64_t change_ns = kSecondNs / 44) {
  const std::vector<double> first = run_cut(model, kFrameRates_mHz[0], change_ns, 60 * kSecondNs);
  double worst = 0;
  for (const std::int64_t rate : kFrameRates_mHz) {
    const std::vector<double> other = run_cut(model, rate, change_ns, 60 * kSecondNs);
    for (std::size_t i = 0; i < first.size(); ++i) {
      const double difference = std::abs(first[i] - other[i]);
      worst = difference <= worst ? worst : difference;  // a NaN stays
      if (!(difference <= 1e30)) return 1e30;
    }
  }
  return worst;
}

}  // namespace footlight

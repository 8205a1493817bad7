// Synthetic sound for tests.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace footlight {

inline std::vector<float> sine(double hz, double seconds, int rate_hz, double amplitude = 1) {
  std::vector<float> samples(static_cast<std::size_t>(seconds * rate_hz));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<float>(amplitude * std::sin(2 * std::numbers::pi * hz * static_cast<double>(i) / rate_hz));
  }
  return samples;
}

// Bursts of noise that fade within 30 ms, at multiples of 60 / bpm s from `first_s` on.
inline std::vector<float> clicks(double bpm, double seconds, int rate_hz, double first_s = 0) {
  std::vector<float> samples(static_cast<std::size_t>(seconds * rate_hz));
  std::uint32_t noise = 12345;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double since = std::fmod(static_cast<double>(i) / rate_hz - first_s + 600, 60 / bpm);
    noise = noise * 1664525 + 1013904223;
    const double white = static_cast<double>(noise >> 8) / (1 << 23) - 1;
    samples[i] = static_cast<float>(white * 0.8 * std::exp(-since / 0.01));
  }
  return samples;
}

}  // namespace footlight

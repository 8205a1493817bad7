// AudioLink's meters of loudness: peaks that are held, smoothed levels with markers, and their history.
//
// Steps are 1/90 s. Source: AudioLink 2, passes 5, 11 and 13 of its shader. Threads: none; not safe to share.
#pragma once

#include <array>
#include <cstddef>

namespace footlight {

inline constexpr std::size_t kMeterHistory = 2'560;  // steps: 28.4 s
inline constexpr std::size_t kMeterFilters = 4;

// Root mean square and peak of left, then of right, as AudioLink orders them.
using LevelAndPeak = std::array<float, 4>;

struct MeterState {
  LevelAndPeak held{};    // the largest values of the last second
  LevelAndPeak held_s{};  // how long they have been held
  float slow_peak = 0;
  struct Filter {
    float level = 0;   // of the left side, smoothed; the first filter is the slowest
    float marker = 0;  // above it, sinking to `held`
    float held = 0;    // the largest value of the last half second
    float held_s = 0;
  };
  std::array<Filter, kMeterFilters> filters{};
  std::array<float, kMeterHistory> history{};  // mean level of both sides, newest first
};

class AudioMeter {
 public:
  explicit AudioMeter(double step_s) : step_s_(step_s) {}
  void step(const LevelAndPeak& now);
  [[nodiscard]] const MeterState& state() const { return state_; }

 private:
  double step_s_;
  MeterState state_;
};

}  // namespace footlight

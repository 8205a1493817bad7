// How long pictures take.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace footlight::tools {

// The last times, `held_max` of them.
class FrameTimes {
 public:
  explicit FrameTimes(std::size_t held_max = 256) : ring_(held_max) {}

  void add(double ms) { ring_[count_++ % ring_.size()] = ms; }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double quantile_ms(double share) const {
    const std::size_t held = std::min<std::size_t>(static_cast<std::size_t>(count_), ring_.size());
    if (held == 0) return 0;
    std::vector<double> sorted(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(held));
    const auto at = static_cast<std::ptrdiff_t>(std::llround(share * static_cast<double>(held - 1)));
    std::nth_element(sorted.begin(), sorted.begin() + at, sorted.end());
    return sorted[static_cast<std::size_t>(at)];
  }

 private:
  std::vector<double> ring_;
  std::uint64_t count_ = 0;
};

}  // namespace footlight::tools

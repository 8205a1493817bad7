// Counts durations in buckets of equal ratio: 8 per octave, from 1 ns to 2^40 ns (18 minutes).
//
// A quantile is exact to within 1/8 of its value (the upper edge of its bucket), the maximum exact. Fixed size (2.6
// kB), never allocates; recording takes a few instructions. Not safe to share between threads; copy it out.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "sim/core/clock.h"

namespace footlight {

class Histogram {
 public:
  // Durations below 0 count as 0.
  void record(DurationNs duration_ns) {
    const auto value = static_cast<std::uint64_t>(std::max<DurationNs>(duration_ns, 0));
    ++buckets_[bucket_of(value)];
    ++count_;
    sum_ns_ += value;
    max_ns_ = std::max(max_ns_, static_cast<DurationNs>(value));
  }

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] DurationNs max_ns() const { return max_ns_; }  // 0: nothing recorded
  [[nodiscard]] std::uint64_t sum_ns() const { return sum_ns_; }
  // How many were shorter than 2^power ns, exact; `power` from 3 to 39.
  [[nodiscard]] std::uint64_t count_below_power(int power) const {
    const std::size_t end = bucket_of(std::uint64_t{1} << power);
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < end; ++i) seen += buckets_[i];
    return seen;
  }

  // The smallest bucket edge that at least `share` (0 to 1) of the values do not exceed; 0 if nothing was recorded.
  [[nodiscard]] DurationNs quantile_ns(double share) const {
    const double wanted = std::clamp(share, 0.0, 1.0) * static_cast<double>(count_);
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
      seen += buckets_[i];
      if (seen != 0 && static_cast<double>(seen) >= wanted) return std::min(upper_edge(i), max_ns_);
    }
    return max_ns_;
  }

  void clear() { *this = Histogram{}; }

 private:
  static constexpr int kSubBits = 3;  // 2^3 buckets per octave
  static constexpr int kOctaves = 40;
  static constexpr std::size_t kBucketCount = (kOctaves - kSubBits + 1) << kSubBits;

  // Values below 8 have a bucket each. Above, the three bits after the leading one select the bucket within the octave.
  static constexpr std::size_t bucket_of(std::uint64_t value) {
    if (value < (1u << kSubBits)) return static_cast<std::size_t>(value);
    const int shift = static_cast<int>(std::bit_width(value)) - 1 - kSubBits;
    const std::size_t bucket = (static_cast<std::size_t>(shift) << kSubBits) + static_cast<std::size_t>(value >> shift);
    return std::min(bucket, kBucketCount - 1);
  }
  // The largest value that falls into the bucket.
  static constexpr DurationNs upper_edge(std::size_t bucket) {
    if (bucket < (1u << kSubBits)) return static_cast<DurationNs>(bucket);
    const std::size_t shift = (bucket >> kSubBits) - 1;
    const std::uint64_t mantissa = (bucket & ((1u << kSubBits) - 1)) + (1u << kSubBits);
    if (bucket == kBucketCount - 1) return INT64_MAX;
    return static_cast<DurationNs>(((mantissa + 1) << shift) - 1);
  }

  std::array<std::uint64_t, kBucketCount> buckets_{};
  std::uint64_t count_ = 0;
  std::uint64_t sum_ns_ = 0;
  DurationNs max_ns_ = 0;
};

}  // namespace footlight

// Makes samples of a DMX line, as from a logic analyser.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/core/clock.h"

namespace footlight::testing {

struct LineProfile {
  DurationNs break_ns = 100'000;
  DurationNs mab_ns = 12'000;
  DurationNs gap_ns = 0;  // between slots
  double bit_ns = 4'000.0;
  int stop_bits = 2;
};

// Edges are exact; a sample is the level at its time.
class LineSignal {
 public:
  explicit LineSignal(std::uint64_t sample_rate_hz) : rate_hz_(static_cast<double>(sample_rate_hz)) {}

  void mark(double length_ns) { level(true, length_ns); }
  void space(double length_ns) { level(false, length_ns); }
  void slot(std::uint8_t value, const LineProfile& profile = {}) {
    space(profile.bit_ns);
    for (int bit = 0; bit < 8; ++bit) level((value >> bit & 1) != 0, profile.bit_ns);
    mark(profile.stop_bits * profile.bit_ns);
  }
  // Break, mark after break, then these bytes, the start code first.
  void frame(std::span<const std::uint8_t> bytes, const LineProfile& profile = {}) {
    space(static_cast<double>(profile.break_ns));
    mark(static_cast<double>(profile.mab_ns));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (i > 0 && profile.gap_ns > 0) mark(static_cast<double>(profile.gap_ns));
      slot(bytes[i], profile);
    }
  }
  [[nodiscard]] double now_ns() const { return now_ns_; }
  // 0 or 1 each.
  [[nodiscard]] const std::vector<std::uint8_t>& samples() const { return samples_; }
  [[nodiscard]] std::vector<std::uint8_t>& samples() { return samples_; }

 private:
  void level(bool mark, double length_ns) {
    now_ns_ += length_ns;
    while (static_cast<double>(samples_.size()) * 1e9 / rate_hz_ < now_ns_) samples_.push_back(mark ? 1 : 0);
  }

  double rate_hz_;
  double now_ns_ = 0.0;
  std::vector<std::uint8_t> samples_;
};

}  // namespace footlight::testing

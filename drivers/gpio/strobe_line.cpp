#include "drivers/gpio/strobe_line.h"

#include <algorithm>
#include <cmath>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

// A read level may precede the interrupt that reports its edge by about this much.
constexpr DurationNs kReadAheadNs = kNsPerMs;

DurationNs period_of(double hz) { return static_cast<DurationNs>(static_cast<double>(kNsPerS) / hz); }

}  // namespace

StrobeLine::StrobeLine(StrobeConfig config) : config_(std::move(config)), value_(config_.off) {
  FL_CHECK(config_.hold_ns >= 0 && config_.debounce_ns >= 0);
  FL_CHECK(config_.flashes_hz_max >= 0.0 && config_.flashes_hz_max <= kFlashesMaxLimitHz);
  FL_CHECK(config_.mode != StrobeMode::kRate || !config_.rate_points.empty());
  if (config_.flashes_hz_max > 0.0) {
    const double count = std::max(1.0, std::floor(config_.flashes_hz_max));
    flash_count_max_ = static_cast<std::size_t>(count);
    flash_window_ns_ =
        static_cast<DurationNs>(std::ceil(count / config_.flashes_hz_max * static_cast<double>(kNsPerS)));
  }
}

void StrobeLine::start(bool level, TimeNs now_ns) {
  stop(now_ns);
  raw_ = accepted_ = level;
  if (level && config_.mode == StrobeMode::kFollow) rise(now_ns);
}

void StrobeLine::stop(TimeNs now_ns) {
  raw_ = accepted_ = false;
  last_ns_ = read_ns_ = last_rise_ns_ = INT64_MIN;
  settle_ns_ = off_ns_ = pending_ns_ = kTimeNever;
  turn_off(now_ns);
}

void StrobeLine::edge(bool level, TimeNs stamp_ns) {
  ++counters_.edges;
  const TimeNs time_ns = std::max(stamp_ns, last_ns_);
  last_ns_ = time_ns;
  advance(time_ns);
  if (level == raw_) {
    const bool known = read_ns_ != INT64_MIN && stamp_ns < read_ns_ + kReadAheadNs;
    read_ns_ = INT64_MIN;
    if (known) return;  // read_level() has reported it before its interrupt was handled
    ++counters_.lost;
    take(!level, time_ns);
  }
  take(level, time_ns);
}

void StrobeLine::read_level(bool level, TimeNs now_ns) {
  if (level != raw_) {
    ++counters_.repaired;
    read_ns_ = now_ns;
    // Inside a window, and at its end, the level is used at the end.
    if (settle_ns_ == kTimeNever) {
      take(level, now_ns);
    } else {
      raw_ = level;
    }
  }
  advance(now_ns);
}

void StrobeLine::advance(TimeNs now_ns) {
  for (TimeNs due_ns = next_deadline_ns(); due_ns <= now_ns; due_ns = next_deadline_ns()) {
    if (due_ns == off_ns_) {
      off_ns_ = kTimeNever;
      turn_off(due_ns);
    } else if (due_ns == settle_ns_) {
      settle_ns_ = kTimeNever;
      if (raw_ != accepted_) accept(raw_, due_ns);
    } else {
      pending_ns_ = kTimeNever;
      turn_on(due_ns);
    }
  }
}

TimeNs StrobeLine::next_deadline_ns() const { return std::min({settle_ns_, off_ns_, pending_ns_}); }

void StrobeLine::take(bool level, TimeNs time_ns) {
  raw_ = level;
  if (settle_ns_ != kTimeNever) {
    ++counters_.bounces;
  } else if (level != accepted_) {
    accept(level, time_ns);
  }
}

void StrobeLine::accept(bool level, TimeNs time_ns) {
  accepted_ = level;
  if (config_.debounce_ns > 0) settle_ns_ = time_ns + config_.debounce_ns;
  if (level) {
    rise(time_ns);
  } else {
    fall(time_ns);
  }
}

void StrobeLine::rise(TimeNs time_ns) {
  switch (config_.mode) {
    case StrobeMode::kFollow:
      off_ns_ = kTimeNever;
      if (!on_ && !turn_on(time_ns)) pending_ns_ = allowed_ns();
      return;
    case StrobeMode::kOneShot:
      if (on_ && config_.retrigger == Retrigger::kIgnore) return;
      if (on_ || turn_on(time_ns)) off_ns_ = time_ns + config_.hold_ns;
      return;
    case StrobeMode::kToggle:
      if (on_ || pending_ns_ != kTimeNever) {
        pending_ns_ = kTimeNever;
        turn_off(time_ns);
      } else if (!turn_on(time_ns)) {
        pending_ns_ = allowed_ns();
      }
      return;
    case StrobeMode::kRate: return rise_rate(time_ns);
  }
}

void StrobeLine::fall(TimeNs time_ns) {
  if (config_.mode != StrobeMode::kFollow) return;
  pending_ns_ = kTimeNever;
  if (!on_) return;
  const TimeNs off_ns = on_since_ns_ + config_.hold_ns;
  if (off_ns <= time_ns) {
    turn_off(time_ns);
  } else {
    off_ns_ = off_ns;
  }
}

void StrobeLine::rise_rate(TimeNs time_ns) {
  const TimeNs before_ns = last_rise_ns_;
  last_rise_ns_ = time_ns;
  // Written so that the first edge, without a predecessor, cannot overflow.
  const DurationNs slowest_ns = 2 * period_of(config_.rate_points.front().hz);
  if (before_ns == INT64_MIN || time_ns - before_ns > slowest_ns || time_ns == before_ns) return;
  const DurationNs period_ns = time_ns - before_ns;
  double hz = static_cast<double>(kNsPerS) / static_cast<double>(period_ns);
  if (flash_count_max_ != 0 && hz > config_.flashes_hz_max) {
    hz = config_.flashes_hz_max;
    ++counters_.capped;
  }
  if (!on_) ++counters_.flashes;
  on_ = true;
  off_ns_ = time_ns + 2 * period_ns;
  set_value(value_of_hz(hz), time_ns);
}

bool StrobeLine::turn_on(TimeNs time_ns) {
  if (flash_count_max_ != 0) {
    if (time_ns < allowed_ns()) {
      ++counters_.capped;
      return false;
    }
    flashes_ns_[flashes_begun_++ % flash_count_max_] = time_ns;
  }
  ++counters_.flashes;
  on_ = true;
  on_since_ns_ = time_ns;
  set_value(config_.on, time_ns);
  return true;
}

void StrobeLine::turn_off(TimeNs time_ns) {
  on_ = false;
  set_value(config_.off, time_ns);
}

void StrobeLine::set_value(std::uint8_t value, TimeNs time_ns) {
  if (value == value_) return;
  value_ = value;
  changed_ns_ = time_ns;
}

TimeNs StrobeLine::allowed_ns() const {
  if (flash_count_max_ == 0 || flashes_begun_ < flash_count_max_) return INT64_MIN;
  return flashes_ns_[flashes_begun_ % flash_count_max_] + flash_window_ns_;  // the oldest of the ring
}

std::uint8_t StrobeLine::value_of_hz(double hz) const {
  const auto& points = config_.rate_points;
  if (hz <= points.front().hz) return points.front().value;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (hz > points[i].hz) continue;
    const double part = (hz - points[i - 1].hz) / (points[i].hz - points[i - 1].hz);
    // Rounded towards the slower point, so that a capped rate is not rounded up.
    return static_cast<std::uint8_t>(points[i - 1].value +
                                     static_cast<int>(part * (points[i].value - points[i - 1].value)));
  }
  return points.back().value;
}

}  // namespace footlight::drivers

#include "sim/tempo.h"

#include <algorithm>
#include <cmath>

namespace footlight {
namespace {

constexpr double kMinuteNs = 60e9;

}  // namespace

TempoBeat Tempo::beat_at(TimeNs now_ns) const {
  const std::int64_t elapsed_ns = now_ns - anchor_ns_;
  std::int64_t whole = elapsed_ns / beat_ns_;
  if (elapsed_ns % beat_ns_ < 0) --whole;
  const auto rest_ns = static_cast<double>(elapsed_ns - whole * beat_ns_);
  return {anchor_ + whole, rest_ns / static_cast<double>(beat_ns_)};
}

void Tempo::tap(TimeNs now_ns) {
  const std::lock_guard lock(mutex_);
  if (!taps_.empty() && now_ns - taps_.back() < kTapBounceNs) return;
  if (!taps_.empty() && now_ns - taps_.back() > kTapPauseNs) taps_.clear();
  taps_.push_back(now_ns);
  if (taps_.size() > kTapsMax) taps_.pop_front();
  if (taps_.size() < 2) return;
  const TempoBeat before = beat_at(now_ns);
  anchor_ = before.count + (before.share >= 0.5 ? 1 : 0);
  anchor_ns_ = now_ns;
  const auto between = static_cast<std::int64_t>(taps_.size()) - 1;
  beat_ns_ = (taps_.back() - taps_.front() + between / 2) / between;
}

Status Tempo::set(double beats_a_minute, TimeNs now_ns) {
  if (!(beats_a_minute >= kTempoMin && beats_a_minute <= kTempoMax)) {
    return fail(ErrorCode::kBadInput, "expected {} to {} beats a minute, got {}", kTempoMin, kTempoMax, beats_a_minute);
  }
  const std::lock_guard lock(mutex_);
  const TempoBeat now = beat_at(now_ns);
  beat_ns_ = std::llround(kMinuteNs / beats_a_minute);
  anchor_ = now.count;
  anchor_ns_ = now_ns - std::llround(now.share * static_cast<double>(beat_ns_));
  taps_.clear();
  return {};
}

double Tempo::beats_a_minute() const {
  const std::lock_guard lock(mutex_);
  return kMinuteNs / static_cast<double>(beat_ns_);
}

TempoBeat Tempo::at(TimeNs now_ns) const {
  const std::lock_guard lock(mutex_);
  return beat_at(now_ns);
}

}  // namespace footlight

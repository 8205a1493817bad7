#include "sim/sound/beat.h"

#include <algorithm>
#include <cmath>

namespace footlight {
namespace {

constexpr double kWindowS = 6;
constexpr double kFastestBpm = 200;
constexpr double kSlowestBpm = 55;
constexpr double kUsualBpm = 130;
constexpr double kUsualOctaves = 0.9;    // width of the preference for kUsualBpm
constexpr double kConfidenceMin = 0.15;  // below: no tempo
constexpr double kOnsetGain = 20;        // of magnitudes, as shares of the loudest, before the logarithm
constexpr double kLoudestLeft = 0.999;   // a step
constexpr double kLoudestMin = 1e-6;
constexpr double kRiseMin = 0.15;          // of the level: the largest rise of the window; below: no tempo
constexpr double kSameTempo = 1.2;         // preference for the tempo found before
constexpr int kFoldLags = 4;               // multiples of a beat that are compared
constexpr std::uint64_t kEverySteps = 15;  // a search takes many steps' time
constexpr int kPhases = 64;                // places of the beat that are tried
constexpr double kPhaseBeats = 4;
constexpr double kMinGap = 0.6;   // of a period between two beats
constexpr double kRiseSteps = 2;  // from a click to the peak of its onset

}  // namespace

BeatFinder::BeatFinder(double steps_per_s)
    : steps_per_s_(steps_per_s), onsets_(static_cast<std::size_t>(kWindowS * steps_per_s), 0.0) {}

double BeatFinder::onset(std::size_t steps_ago) const {
  return onsets_[(at_ + 2 * onsets_.size() - 1 - steps_ago) % onsets_.size()];
}

double BeatFinder::onset_between(double steps_ago) const {
  if (steps_ago < 0) return 0;
  const double whole = std::floor(steps_ago);
  const auto at = static_cast<std::size_t>(whole);
  if (at + 1 >= onsets_.size()) return 0;
  const double share = steps_ago - whole;
  return onset(at) * (1 - share) + onset(at + 1) * share;
}

// Of the onsets without their mean, for lags from 0; -1 to 1.
std::vector<double> BeatFinder::correlations(std::size_t count) const {
  std::vector<double> sorted(onsets_.size());
  double mean = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) mean += sorted[i] = onset(i);
  mean /= static_cast<double>(sorted.size());
  double power = 0;
  for (double& one : sorted) {
    one -= mean;
    power += one * one;
  }
  std::vector<double> found(count);
  if (power <= 0) return found;
  for (std::size_t lag = 0; lag < count; ++lag) {
    double product = 0;
    for (std::size_t i = 0; i + lag < sorted.size(); ++i) product += sorted[i] * sorted[i + lag];
    const auto overlap = static_cast<double>(sorted.size() - lag);
    found[lag] = product / power * static_cast<double>(sorted.size()) / overlap;
  }
  return found;
}

void BeatFinder::find_tempo() {
  const auto lag_min = static_cast<std::size_t>(60 * steps_per_s_ / kFastestBpm);
  const auto lag_max = static_cast<std::size_t>(60 * steps_per_s_ / kSlowestBpm) + 1;
  const std::vector<double> found = correlations(std::min(kFoldLags * (lag_max + 1), onsets_.size() * 3 / 4) + 2);
  double best_score = 0;
  double best = 0;
  double best_correlation = 0;
  // The multiples of a lag give its fraction: a beat of 40.25 steps has its fourth at 161.
  for (double lag = static_cast<double>(lag_min); lag <= static_cast<double>(lag_max); lag += 0.0625) {
    double sum = 0;
    double weights = 0;
    for (int multiple = 1; multiple <= kFoldLags; ++multiple) {
      const double at = lag * multiple;
      const auto whole = static_cast<std::size_t>(at);
      if (whole + 1 >= found.size()) break;
      const double share = at - static_cast<double>(whole);
      sum += (found[whole] * (1 - share) + found[whole + 1] * share) / multiple;
      weights += 1.0 / multiple;
    }
    const double octaves = std::log2(60 * steps_per_s_ / lag / kUsualBpm) / kUsualOctaves;
    const bool same = period_ > 0 && std::abs(lag / period_ - 1) < 0.03;
    const double score = sum / weights * std::exp(-0.5 * octaves * octaves) * (same ? kSameTempo : 1);
    if (score <= best_score) continue;
    best_score = score;
    best = lag;
    best_correlation = sum / weights;
  }
  beat_.confidence = std::clamp(best_correlation, 0.0, 1.0);
  const double rise = *std::max_element(onsets_.begin(), onsets_.end());
  if (beat_.confidence < kConfidenceMin || rise < kRiseMin) {
    period_ = 0;
    beat_.bpm = 0;
    return;
  }
  period_ = best;
  beat_.bpm = 60 * steps_per_s_ / period_;
}

// The place of the last beat: where a pulse train through the last beats meets the most onsets.
void BeatFinder::find_phase() {
  double best_score = 0;
  double best = -1;
  for (int i = 0; i < kPhases; ++i) {
    const double ago = period_ * i / kPhases;
    double score = 0;
    for (int beat = 0; beat < kPhaseBeats; ++beat) score += onset_between(ago + beat * period_) * (1 - 0.15 * beat);
    if (score <= best_score) continue;
    best_score = score;
    best = ago;
  }
  if (best < 0) return;
  // The nearest phase to the present one, so that a beat is neither skipped nor repeated.
  const double seen = best + kRiseSteps;
  double shift = std::fmod(seen - since_, period_);
  if (shift > period_ / 2) shift -= period_;
  if (shift < -period_ / 2) shift += period_;
  since_ += shift;
}

const Beat& BeatFinder::step(const SpectrumBins& magnitudes) {
  const double loudest = *std::max_element(magnitudes.begin(), magnitudes.end());
  loudest_ = std::max({loudest, loudest_ * kLoudestLeft, kLoudestMin});
  const auto scale = static_cast<float>(kOnsetGain / loudest_);
  double rise = 0;
  double total = 0;
  for (std::size_t bin = 0; bin < magnitudes.size(); ++bin) {
    const float level = std::log1p(scale * magnitudes[bin]);
    rise += std::max(0.0F, level - before_[bin]);
    total += level;
    before_[bin] = level;
  }
  level_ = std::max(total, level_ * kLoudestLeft);
  onsets_[at_] = level_ > 0 ? rise / level_ : 0;
  at_ = (at_ + 1) % onsets_.size();
  ++steps_;
  since_ += 1;
  beat_.is_beat = false;
  if (steps_ % kEverySteps == 0 && steps_ > 2 * static_cast<std::uint64_t>(steps_per_s_)) {
    const double gap = since_;
    find_tempo();
    if (period_ > 0) find_phase();
    // A beat that a correction would repeat.
    if (period_ > 0 && since_ >= period_ && gap < kMinGap * period_) since_ -= period_;
  }
  if (period_ <= 0) {
    since_ = 0;
    beat_.phase = 0;
    return beat_;
  }
  if (since_ >= period_) {
    since_ = std::fmod(since_, period_);
    beat_.is_beat = true;
    ++beat_.count;
  }
  beat_.phase = std::clamp(since_ / period_, 0.0, 1.0);
  return beat_;
}

}  // namespace footlight

#include "sim/sound/audio_link.h"

#include <algorithm>
#include <cmath>

#include "sim/core/check.h"

namespace footlight {
namespace {

constexpr double kStepS = 1.0 / kSoundStepsPerS;
constexpr double kRangeFloor = 0.123;  // of the bins: where the bands begin
constexpr double kLogAttenuation = 0.68 * 0.68 * 0.68 * 0.68;
constexpr double kContrastOffset = 0.62;
constexpr double kSmoothMin = 0.3;  // share of the previous step
constexpr double kSmoothMax = 0.9;
constexpr double kThresholdMin = 0.05;
constexpr double kLevelS = 1024.0 / 24'000;
constexpr double kClampGained = 2;  // AudioLink's limit of a sample after its gain

int band_bin(double crossover) {
  return static_cast<int>(kSpectrumBins * (kRangeFloor + crossover * (1 - kRangeFloor)));
}

int band_end(const AudioLinkSettings& settings, int band) {
  return band + 1 < kSoundBands ? band_bin(settings.crossover[static_cast<std::size_t>(band) + 1]) : kSpectrumBins;
}

// 1 up to 60 Hz, then as loudness and the falling spectrum of music suggest: a polynomial that is within 0.05 of
// AudioLink's table, which rises from 1 to 5.66.
double treble_correction(int bin) {
  const double t = (bin - 51) / 188.0;
  if (t <= 0) return 1;
  return 1 + 5 * std::max(0.0, t * (-0.22992 + t * (6.71196 + t * (-8.82554 + t * 3.24757))));
}

double mixed(double from, double to, double share) { return from + (to - from) * share; }

}  // namespace

BandRange band_range(const AudioLinkSettings& settings, int band) {
  return {spectrum_bin_hz(band_bin(settings.crossover[static_cast<std::size_t>(band)])),
          spectrum_bin_hz(band_end(settings, band))};
}

AudioLink::AudioLink(const AudioLinkSettings& settings, int rate_hz, int channels)
    : settings_(settings),
      rate_hz_(rate_hz),
      channels_(channels),
      spectrum_(rate_hz),
      beat_finder_(kSoundStepsPerS),
      chord_(kStepS),
      meter_(kStepS),
      newest_(static_cast<std::size_t>(kLevelS * rate_hz)) {
  FL_CHECK(rate_hz >= kSoundRateMinHz && rate_hz <= kSoundRateMaxHz);
  FL_CHECK(channels >= 1 && channels <= kSoundChannelsMax);
  for (int bin = 0; bin < kSpectrumBins; ++bin) {
    treble_[static_cast<std::size_t>(bin)] = static_cast<float>(treble_correction(bin));
  }
}

void AudioLink::take_frame(const float* samples) {
  float sum = 0;
  std::array<float, 2> sides{};
  for (int channel = 0; channel < channels_; ++channel) {
    float sample = samples[channel];
    sample = std::isfinite(sample) ? std::clamp(sample, -8.0F, 8.0F) : 0.0F;
    sum += sample;
    if (channel < 2) sides[static_cast<std::size_t>(channel)] = sample;
  }
  if (channels_ == 1) sides[1] = sides[0];
  mono_.push_back(sum / static_cast<float>(channels_));
  newest_[newest_at_] = sides;
  newest_at_ = (newest_at_ + 1) % newest_.size();
}

void AudioLink::push(std::span<const float> interleaved, const OnStep& on_step) {
  const auto channels = static_cast<std::size_t>(channels_);
  FL_CHECK_EQ(interleaved.size() % channels, 0U);
  for (std::size_t at = 0; at < interleaved.size(); at += channels) {
    take_frame(interleaved.data() + at);
    ++frames_;
    if (frames_ < step_frame(state_.step + 1, rate_hz_)) continue;
    spectrum_.push(mono_);
    mono_.clear();
    compute_step();
    if (on_step) on_step(state_);
  }
}

void AudioLink::measure_level(double gain) {
  std::array<double, 2> total{};
  std::array<double, 2> peak{};
  for (const auto& sides : newest_) {
    for (std::size_t side = 0; side < 2; ++side) {
      const double sample = std::clamp(gain * sides[side], -kClampGained, kClampGained);
      total[side] += sample * sample;
      peak[side] = std::max(peak[side], std::abs(sample));
    }
  }
  for (std::size_t side = 0; side < 2; ++side) {
    state_.rms[side] = static_cast<float>(std::sqrt(total[side] / static_cast<double>(newest_.size())));
    state_.peak[side] = static_cast<float>(peak[side]);
  }
  meter_.step({state_.rms[0], state_.peak[0], state_.rms[1], state_.peak[1]});
  state_.meter = meter_.state();
  const double level = state_.autogain_level;
  const double next = peak[0] / (level + settings_.autogain_derate);
  state_.autogain_level = static_cast<float>(mixed(next, level, next > level ? 0.5 : 0.995));
}

double AudioLink::raw_band(int band) const {
  const auto at = static_cast<std::size_t>(band);
  const int begin = band_bin(settings_.crossover[at]);
  const int end = band_end(settings_, band);
  double total = 0;
  for (int bin = begin; bin < end; ++bin) total += state_.equalised[static_cast<std::size_t>(bin)];
  double magnitude = std::min(end > begin ? total / (end - begin) : 0.0, 1.0);
  const double boost = settings_.autolevel ? boost_[at] : 0;
  const double threshold = std::max(settings_.threshold[at] - boost, kThresholdMin);
  magnitude *= std::log(1.1) / std::log(1.1 + kLogAttenuation * (1 - magnitude)) / (threshold * threshold);
  static const double slope = std::tan(1.57 * 0.63);
  return magnitude * (slope + 1) + (kContrastOffset - 1) * slope;
}

void AudioLink::take_band(int band) {
  const auto at = static_cast<std::size_t>(band);
  const double raw = raw_band(band);
  if (raw < 0.5) {
    confidence_[at] -= 0.00003;
    boost_[at] = std::min(mixed(boost_[at] + 0.02, boost_[at], std::clamp(confidence_[at], 0.0, 1.0)), 0.4);
  } else {
    confidence_[at] = 1;
    boost_[at] = std::max(boost_[at] - 0.01, 0.0);
  }
  state_.autolevel[at] = {static_cast<float>(raw), static_cast<float>(boost_[at]), static_cast<float>(confidence_[at]),
                          settings_.autolevel};
  auto& history = state_.bands[at];
  const double lost = std::pow(1 - settings_.fade_length, 3);
  double last = history[0] - lost;
  last = std::clamp(last * (1 + (std::pow(last - 1, 4) - 1) * settings_.fade_exp_falloff), 0.0, 1.0);
  const double level = std::max(last, std::clamp(raw, 0.0, 1.0));
  std::copy_backward(history.begin(), history.end() - 1, history.end());
  history[0] = static_cast<float>(level);
  for (int filter = 0; filter < kSoundFilters; ++filter) {
    float& one = state_.filtered[at][static_cast<std::size_t>(filter)];
    one = static_cast<float>(mixed(level, one, std::pow(0.55, kStepS * (filter + 1))));
  }
}

void AudioLink::compute_step() {
  ++state_.step;
  const double autogain = settings_.autogain ? 1 / (state_.autogain_level + settings_.autogain_derate) : 1;
  SpectrumBins plain;
  spectrum_.read(plain);
  const double left = mixed(kSmoothMin, kSmoothMax, settings_.fade_length);
  for (std::size_t bin = 0; bin < plain.size(); ++bin) {
    const double magnitude = plain[bin] * settings_.gain * autogain * treble_[bin];
    const double smoothed = mixed(magnitude, state_.smoothed[bin], left);
    const double place = static_cast<double>(bin) / kSpectrumBins;
    state_.magnitude[bin] = static_cast<float>(magnitude);
    state_.smoothed[bin] = static_cast<float>(smoothed);
    state_.equalised[bin] = static_cast<float>(smoothed * mixed(settings_.bass, settings_.treble, place));
  }
  measure_level(autogain);
  for (int band = 0; band < kSoundBands; ++band) take_band(band);
  state_.beat = beat_finder_.step(plain);
  chord_.step(state_.smoothed, state_.rms[0] * settings_.gain);
  state_.notes = chord_.notes();
  for (std::size_t i = 0; i < state_.theme.size(); ++i) state_.theme[i] = chord_.note_color(i);
  chord_.lights(state_.lights);
}

}  // namespace footlight

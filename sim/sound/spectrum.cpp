#include "sim/sound/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/core/check.h"

namespace footlight {
namespace {

constexpr double kTau = 2 * std::numbers::pi;
constexpr double kPeriods = 4;  // on each side of the middle of a window
constexpr double kBaseAmplitude = 2.5;
constexpr double kLowMaxHz = 1'500;      // bins below are read from the stream with fewer samples
constexpr double kHighestOfRate = 0.45;  // of the sample rate
constexpr double kInputRateMinHz = 40'000;
constexpr double kLowRateMinHz = 6'000;
constexpr int kTapsPerSide = 8;  // for each sample that is left out
constexpr std::size_t kLanes = 8;

int factor_to(double rate_hz, double rate_min_hz) { return std::max(1, static_cast<int>(rate_hz / rate_min_hz)); }

// In kLanes sums, so that the compiler may use vectors without changing the order of additions.
float dot(const float* a, const float* b, std::size_t count) {
  float sums[kLanes] = {};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) sums[lane] += a[i + lane] * b[i + lane];
  }
  for (; i < count; ++i) sums[0] += a[i] * b[i];
  float sum = 0;
  for (const float one : sums) sum += one;
  return sum;
}

}  // namespace

double spectrum_bin_hz(int bin) {
  return kSpectrumBottomHz * std::exp2(static_cast<double>(bin) / kSpectrumBinsPerOctave);
}

Decimator::Decimator(int factor) : factor_(factor) {
  FL_CHECK(factor >= 1);
  if (factor == 1) return;
  const int side = kTapsPerSide * factor;
  double sum = 0;
  std::vector<double> taps;
  for (int i = -side; i <= side; ++i) {
    const double x = static_cast<double>(i) / factor;
    const double sinc = i == 0 ? 1 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
    const double t = (static_cast<double>(i) + side) / (2.0 * side);
    taps.push_back(sinc * (0.42 - 0.5 * std::cos(kTau * t) + 0.08 * std::cos(2 * kTau * t)));  // Blackman
    sum += taps.back();
  }
  for (const double tap : taps) taps_.push_back(static_cast<float>(tap / sum));
  recent_.assign(2 * taps_.size(), 0.0F);
}

void Decimator::push(std::span<const float> in, std::vector<float>& out) {
  if (factor_ == 1) {
    out.insert(out.end(), in.begin(), in.end());
    return;
  }
  const std::size_t size = taps_.size();
  for (const float sample : in) {
    recent_[at_] = recent_[at_ + size] = sample;
    at_ = (at_ + 1) % size;
    if (until_next_ > 0) {
      --until_next_;
      continue;
    }
    until_next_ = factor_ - 1;
    out.push_back(dot(taps_.data(), recent_.data() + at_, size));
  }
}

void Spectrum::Stream::keep(std::span<const float> added) {
  samples.insert(samples.end(), added.begin(), added.end());
  // Moved seldom: the vector holds up to four windows.
  if (samples.size() <= 4 * length_max) return;
  samples.erase(samples.begin(), samples.end() - static_cast<std::ptrdiff_t>(length_max));
}

Spectrum::Kernel Spectrum::make_kernel(int bin, double rate_hz) {
  Kernel kernel;
  const double hz = spectrum_bin_hz(bin);
  if (hz > kHighestOfRate * rate_hz) return kernel;
  const double half = std::min(kPeriods / hz, kSpectrumWindowMaxS / 2) * rate_hz;
  kernel.length = std::max<std::size_t>(static_cast<std::size_t>(std::floor(2 * half)), 3);
  const double middle = (static_cast<double>(kernel.length) - 1) / 2;
  double total = 0;
  double cosines = 0;
  double sines = 0;
  std::vector<double> window;
  const auto phase_at = [&](std::size_t i) { return kTau * hz / rate_hz * (static_cast<double>(i) - middle); };
  for (std::size_t i = 0; i < kernel.length; ++i) {
    window.push_back(std::max(0.0, half - std::abs(static_cast<double>(i) - middle)));
    total += window.back();
    cosines += window.back() * std::cos(phase_at(i));
    sines += window.back() * std::sin(phase_at(i));
  }
  for (std::size_t i = 0; i < kernel.length; ++i) {
    const double scale = window[i] / total * kBaseAmplitude;
    kernel.cosine.push_back(static_cast<float>(scale * (std::cos(phase_at(i)) - cosines / total)));
    kernel.sine.push_back(static_cast<float>(scale * (std::sin(phase_at(i)) - sines / total)));
  }
  return kernel;
}

Spectrum::Spectrum(double rate_hz)
    : input_(factor_to(rate_hz, kInputRateMinHz)), low_(factor_to(rate_hz / input_.factor(), kLowRateMinHz)) {
  streams_[0].rate_hz = rate_hz / input_.factor();
  streams_[1].rate_hz = streams_[0].rate_hz / low_.factor();
  for (int bin = 0; bin < kSpectrumBins; ++bin) {
    const std::size_t from = spectrum_bin_hz(bin) < kLowMaxHz ? 1 : 0;
    kernels_.push_back(make_kernel(bin, streams_[from].rate_hz));
    kernels_.back().stream = from;
    streams_[from].length_max = std::max(streams_[from].length_max, kernels_.back().length);
  }
  for (Stream& stream : streams_) stream.samples.assign(stream.length_max, 0.0F);
}

void Spectrum::push(std::span<const float> mono) {
  decimated_.clear();
  low_samples_.clear();
  input_.push(mono, decimated_);
  low_.push(decimated_, low_samples_);
  streams_[0].keep(decimated_);
  streams_[1].keep(low_samples_);
}

void Spectrum::read(SpectrumBins& magnitudes) const {
  for (std::size_t bin = 0; bin < kernels_.size(); ++bin) {
    const Kernel& kernel = kernels_[bin];
    const std::vector<float>& samples = streams_[kernel.stream].samples;
    const float* from = samples.data() + samples.size() - kernel.length;
    magnitudes[bin] =
        std::hypot(dot(from, kernel.cosine.data(), kernel.length), dot(from, kernel.sine.data(), kernel.length));
  }
}

}  // namespace footlight

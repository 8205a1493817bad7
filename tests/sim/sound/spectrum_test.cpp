#include "sim/sound/spectrum.h"

#include <doctest/doctest.h>

#include "tests/sim/sound/tones.h"

namespace footlight {
namespace {

SpectrumBins spectrum_of(const std::vector<float>& samples, int rate_hz) {
  Spectrum spectrum(rate_hz);
  spectrum.push(samples);
  SpectrumBins bins;
  spectrum.read(bins);
  return bins;
}

// The definition, term by term in double: the judge of the tables and of the second stream.
double judged(const std::vector<float>& samples, int rate_hz, int bin, double delay_s) {
  const double hz = spectrum_bin_hz(bin);
  const double half = std::min(4 / hz, kSpectrumWindowMaxS / 2);
  const double end = static_cast<double>(samples.size()) / rate_hz - delay_s;
  double re = 0;
  double im = 0;
  double total = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t = static_cast<double>(i) / rate_hz - (end - half);
    const double window = std::max(0.0, half - std::abs(t));
    total += window;
    re += window * samples[i] * std::cos(2 * std::numbers::pi * hz * t);
    im += window * samples[i] * std::sin(2 * std::numbers::pi * hz * t);
  }
  return 2.5 * std::hypot(re, im) / total;
}

TEST_CASE("a sine in the middle of a bin gives 1.25 times its amplitude there, within 2 percent, at every rate") {
  for (const int rate : {8'000, 22'050, 44'100, 48'000, 96'000, 176'400, 192'000}) {
    for (const int bin : {96, 130, 163, 185, 200, 230}) {
      const double hz = spectrum_bin_hz(bin);
      if (hz > 0.4 * rate) continue;
      const SpectrumBins bins = spectrum_of(sine(hz, 0.2, rate, 0.5), rate);
      CAPTURE(rate);
      CAPTURE(bin);
      CHECK(bins[static_cast<std::size_t>(bin)] == doctest::Approx(0.625).epsilon(0.02));
      const auto highest = std::max_element(bins.begin(), bins.end()) - bins.begin();
      CHECK(highest == bin);
    }
  }
}

TEST_CASE("all bins of a sweep equal the correlation in double, within 0.012 of full scale") {
  const int rate = 48'000;
  std::vector<float> samples(rate / 2);
  double phase = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    phase += 2 * std::numbers::pi * 60 * std::pow(200.0, static_cast<double>(i) / static_cast<double>(samples.size())) /
             rate;
    samples[i] = static_cast<float>(std::sin(phase));
  }
  const SpectrumBins bins = spectrum_of(samples, rate);
  for (int bin = 70; bin < kSpectrumBins; ++bin) {
    // The low-pass filter delays by eight samples of the second stream, at 6 kHz.
    const double delay_s = spectrum_bin_hz(bin) < 1'500 ? 8.0 / 6'000 : 0;
    CAPTURE(bin);
    CHECK(std::abs(bins[static_cast<std::size_t>(bin)] - judged(samples, rate, bin, delay_s)) < 0.012);
  }
}

TEST_CASE("a constant and frequencies above a bin's range leave the spectrum at 0") {
  const SpectrumBins constant = spectrum_of(std::vector<float>(24'000, 1.0F), 48'000);
  for (const float one : constant) CHECK(one < 1e-4F);
  // 30 kHz would appear at 18 kHz, and 45 kHz at 3 kHz, without the filter.
  const SpectrumBins high = spectrum_of(sine(45'000, 0.2, 96'000), 96'000);
  for (const float one : high) CHECK(one < 2e-3F);
}

TEST_CASE("bins above the highest frequency of a low rate are 0") {
  const SpectrumBins bins = spectrum_of(sine(1'000, 0.2, 8'000), 8'000);
  for (int bin = 0; bin < kSpectrumBins; ++bin) {
    if (spectrum_bin_hz(bin) > 3'600) CHECK(bins[static_cast<std::size_t>(bin)] == 0.0F);
  }
}

}  // namespace
}  // namespace footlight

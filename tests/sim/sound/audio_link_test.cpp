#include "sim/sound/audio_link.h"

#include <limits>

#include <doctest/doctest.h>

#include "tests/sim/sound/tones.h"

namespace footlight {
namespace {

AudioLinkSettings plain() {
  AudioLinkSettings settings;
  settings.autogain = false;
  settings.autolevel = false;
  return settings;
}

std::vector<AudioLinkState> states_of(const AudioLinkSettings& settings, const std::vector<float>& samples, int rate_hz,
                                      std::size_t chunk = 0, int channels = 1) {
  std::vector<AudioLinkState> states;
  AudioLink link(settings, rate_hz, channels);
  if (chunk == 0) chunk = samples.size();
  for (std::size_t at = 0; at < samples.size(); at += chunk) {
    link.push(std::span(samples).subspan(at, std::min(chunk, samples.size() - at)),
              [&](const AudioLinkState& state) { states.push_back(state); });
  }
  return states;
}

void check_finite(const AudioLinkState& state) {
  bool finite = std::isfinite(state.autogain_level) && std::isfinite(state.beat.bpm);
  for (const auto& band : state.bands) {
    for (const float one : band) finite = finite && one >= 0 && one <= 1;
  }
  for (const auto& band : state.filtered) {
    for (const float one : band) finite = finite && one >= 0 && one <= 1;
  }
  for (const float one : state.equalised) finite = finite && std::isfinite(one);
  for (const SoundColor& one : state.lights) finite = finite && one.r >= 0 && one.r <= 1 && one.g <= 1 && one.b <= 1;
  CHECK(finite);
}

TEST_CASE("a loud tone in the middle of a band raises that band most") {
  for (int band = 0; band < kSoundBands; ++band) {
    const BandRange range = band_range(plain(), band);
    const auto states = states_of(plain(), sine(std::sqrt(range.from_hz * range.to_hz), 0.5, 48'000), 48'000);
    CAPTURE(band);
    const auto level_of = [&](int one) {
      double sum = 0;
      const int end = one + 1 < kSoundBands ? one + 1 : kSoundBands;
      const BandRange own = band_range(plain(), one);
      for (int bin = 0; bin < kSpectrumBins; ++bin) {
        const double hz = spectrum_bin_hz(bin);
        if (hz >= own.from_hz && (hz < own.to_hz || end == kSoundBands)) {
          sum += states.back().equalised[static_cast<std::size_t>(bin)];
        }
      }
      return sum;
    };
    for (int other = 0; other < kSoundBands; ++other) {
      if (other != band) CHECK(level_of(band) > 4 * level_of(other));
    }
  }
}

TEST_CASE("the bands begin and end where AudioLink's do") {
  CHECK(band_range({}, 0).from_hz == doctest::Approx(13.75 * std::exp2(29 / 24.0)));
  CHECK(band_range({}, 1).from_hz == doctest::Approx(13.75 * std::exp2(82 / 24.0)));
  CHECK(band_range({}, 2).from_hz == doctest::Approx(13.75 * std::exp2(134 / 24.0)));
  CHECK(band_range({}, 3).from_hz == doctest::Approx(13.75 * std::exp2(187 / 24.0)));
  CHECK(band_range({}, 3).to_hz == doctest::Approx(14'080));
}

TEST_CASE("states do not depend on how the samples are cut, nor on samples that follow") {
  const std::vector<float> samples = clicks(130, 1.5, 44'100);
  const auto whole = states_of({}, samples, 44'100);
  CHECK(whole.size() == 135);
  for (const std::size_t chunk : {1U, 1'000U}) {
    const auto cut = states_of({}, samples, 44'100, chunk);
    REQUIRE(cut.size() == whole.size());
    bool same = true;
    for (std::size_t i = 0; i < cut.size(); ++i) {
      same = same && cut[i].bands == whole[i].bands && cut[i].magnitude == whole[i].magnitude &&
             cut[i].lights == whole[i].lights && cut[i].beat.phase == whole[i].beat.phase;
    }
    CHECK(same);
  }
  const auto half = states_of({}, {samples.begin(), samples.begin() + 33'075}, 44'100);
  REQUIRE(half.size() == 67);
  CHECK(half.back().bands == whole[66].bands);
}

TEST_CASE("the history moves by one place a step") {
  const auto states = states_of({}, clicks(140, 2, 8'000), 8'000);
  for (std::size_t i = 128; i < states.size(); ++i) {
    for (std::size_t delay = 0; delay < kSoundHistory; delay += 31) {
      CHECK(states[i].bands[0][delay] == states[i - delay].bands[0][0]);
    }
  }
}

TEST_CASE("a threshold lowers and a gain raises a band, and fade keeps it longer") {
  const std::vector<float> burst = [] {
    std::vector<float> samples = sine(100, 0.3, 8'000, 0.25);
    samples.resize(8'000);
    return samples;
  }();
  AudioLinkSettings low = plain();
  low.threshold = {0.3, 0.3, 0.3, 0.3};
  AudioLinkSettings high = plain();
  high.threshold = {0.9, 0.9, 0.9, 0.9};
  AudioLinkSettings gained = plain();
  gained.gain = 2;
  AudioLinkSettings faded = low;
  faded.fade_length = 0.9;
  faded.fade_exp_falloff = 0;
  const auto at_end_of_burst = [&](const AudioLinkSettings& settings) {
    return states_of(settings, burst, 8'000)[26].bands[0][0];
  };
  const auto lit_steps = [&](const AudioLinkSettings& settings) {
    int lit = 0;
    for (const auto& state : states_of(settings, burst, 8'000)) lit += state.bands[0][0] > 0.05F;
    return lit;
  };
  const float at_high = at_end_of_burst(high);
  CHECK(at_end_of_burst(low) > at_high);
  CHECK(at_end_of_burst(gained) > at_end_of_burst(plain()));
  CHECK(lit_steps(faded) > lit_steps(low) + 10);
}

TEST_CASE("autogain brings a quiet sound near a loud one") {
  const auto level = [](double amplitude) {
    return states_of({}, sine(200, 2, 8'000, amplitude), 8'000).back().rms[0];
  };
  const float ratio = level(1) / level(0.01);
  CHECK(ratio < 30);
  CHECK(ratio > 1);
}

TEST_CASE("silence, constants, clipping, noise that is not finite and huge samples leave every value finite") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const auto& samples :
       {std::vector<float>(8'000, 0.0F), std::vector<float>(8'000, 1.0F), std::vector<float>(8'000, nan),
        std::vector<float>(8'000, -inf), std::vector<float>(8'000, 3e38F), sine(300, 1, 8'000, 1e30)}) {
    const auto states = states_of({}, samples, 8'000);
    CHECK(states.size() == 90);
    check_finite(states[10]);
    check_finite(states.back());
  }
  for (const auto& state : states_of({}, std::vector<float>(16'000, 0.0F), 8'000)) {
    for (const auto& band : state.bands) CHECK(band[0] == 0.0F);
  }
}

TEST_CASE("step times and frames do not drift in 24 hours at any rate") {
  for (const int rate : {8'000, 11'025, 44'100, 48'000, 192'000}) {
    const std::uint64_t day = 24ULL * 3'600 * kSoundStepsPerS;
    CHECK(step_frame(day, rate) == 24ULL * 3'600 * static_cast<std::uint64_t>(rate));
    CHECK(step_time_ns(day) == 24 * 3'600 * kNsPerS);
    for (const std::uint64_t step : {day - 1, day / 2 + 1, std::uint64_t{7}}) {
      const double apart_s =
          static_cast<double>(step_frame(step, rate)) / rate - static_cast<double>(step_time_ns(step)) * 1e-9;
      CHECK(std::abs(apart_s) <= 1.0 / rate + 1e-9);
    }
  }
}

TEST_CASE("channels are mixed, and left and right are the first two") {
  const std::vector<float> left = sine(440, 0.5, 8'000);
  std::vector<float> eight(left.size() * 8);
  for (std::size_t i = 0; i < left.size(); ++i) eight[i * 8] = left[i];
  const auto states = states_of(plain(), eight, 8'000, 0, 8);
  const auto mono = states_of(plain(), left, 8'000);
  CHECK(states.back().rms[0] == doctest::Approx(mono.back().rms[0]));
  CHECK(states.back().rms[1] == 0.0F);
  CHECK(states.back().magnitude[120] == doctest::Approx(mono.back().magnitude[120] / 8).epsilon(1e-4));
}

TEST_CASE("a note has AudioLink's hue, and a chord lights in the shares of its notes") {
  const auto states = states_of({}, sine(440, 1, 8'000, 0.8), 8'000);  // an A: bin 0 of an octave
  const ChordNote& note = states.back().notes[0];
  const double off = std::min(note.bin, 24 - note.bin);
  CHECK(note.slow > 0);
  CHECK(off < 0.25);
  const SoundColor yellow_to_red = chord_color(0, 1.1);
  CHECK(yellow_to_red.r == doctest::Approx(1));
  CHECK(yellow_to_red.b == doctest::Approx(0));
  for (const SoundColor& light : states.back().lights) CHECK(light == states.back().lights[0]);
}

}  // namespace
}  // namespace footlight

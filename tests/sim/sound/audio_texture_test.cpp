#include "sim/sound/audio_texture.h"

#include <cmath>
#include <numbers>
#include <set>

#include <doctest/doctest.h>
#include <fmt/ranges.h>

#include "tests/sim/sound/tones.h"

namespace footlight {
namespace {

std::array<float, 4> at(const std::vector<float>& texture, int x, int y) {
  const auto first = static_cast<std::size_t>(y * kAudioTextureWidth + x) * 4;
  return {texture[first], texture[first + 1], texture[first + 2], texture[first + 3]};
}

// With thresholds so low that every band is lit.
AudioLinkState state_after(const std::vector<float>& interleaved, int rate_hz, int channels) {
  AudioLinkSettings settings;
  settings.threshold = {0.05, 0.05, 0.05, 0.05};
  AudioLink link(settings, rate_hz, channels);
  link.push(interleaved, {});
  return link.state();
}

TEST_CASE("the meter holds peaks for a second, and its history moves by one place a step") {
  AudioMeter meter(1.0 / 90);
  meter.step({0.5F, 0.8F, 0.1F, 0.2F});
  for (int i = 0; i < 89; ++i) meter.step({0.25F, 0.3F, 0.05F, 0.1F});
  CHECK(meter.state().held == LevelAndPeak{0.5F, 0.8F, 0.1F, 0.2F});
  CHECK(meter.state().held_s[1] == doctest::Approx(89.0 / 90).epsilon(1e-4));
  for (int i = 0; i < 3; ++i) meter.step({0.25F, 0.3F, 0.05F, 0.1F});
  CHECK(meter.state().held == LevelAndPeak{0.25F, 0.3F, 0.05F, 0.1F});
  CHECK(meter.state().history[0] == doctest::Approx(0.15));
  CHECK(meter.state().history[92] == doctest::Approx(0.3));
  CHECK(meter.state().history[93] == 0);
}

TEST_CASE("filtered levels close 95.4 percent of a gap in a second, and half a second, a third and a quarter of one") {
  AudioMeter meter(1.0 / 90);
  for (int i = 0; i < 90; ++i) meter.step({1, 1, 0, 0});
  for (std::size_t i = 0; i < kMeterFilters; ++i) {
    const MeterState::Filter& filter = meter.state().filters[i];
    CHECK(filter.level == doctest::Approx(1 - std::pow(0.046, static_cast<double>(i + 1))).epsilon(1e-4));
    CHECK(filter.marker >= filter.level);
    CHECK(filter.held == filter.level);
  }
  // The marker stays above a level that falls, and sinks to what was held.
  float last = 1;
  for (int i = 0; i < 300; ++i) {
    meter.step({0, 0, 0, 0});
    const MeterState::Filter& filter = meter.state().filters[0];
    CHECK(filter.marker >= filter.level);
    CHECK(filter.marker <= last);
    last = filter.marker;
  }
  CHECK(last < 0.01F);
}

TEST_CASE("the history of levels runs through the colours of a row, then through the next row") {
  AudioLinkState state;
  for (std::size_t i = 0; i < kMeterHistory; ++i) state.meter.history[i] = static_cast<float>(i) / kMeterHistory;
  const std::vector<float> texture = audio_texture(state);
  for (const std::size_t steps : {std::size_t{0}, std::size_t{1}, std::size_t{127}, std::size_t{128}, std::size_t{511},
                                  std::size_t{512}, std::size_t{2'559}}) {
    const int row = 32 + static_cast<int>(steps / 512);
    const std::size_t color = steps % 512 / 128;
    CHECK(at(texture, static_cast<int>(steps % 128), row)[color] == static_cast<float>(steps) / kMeterHistory);
  }
}

TEST_CASE("the correlation is the sum of the cosines of its bins, largest at no lag, and periodic for one bin") {
  SpectrumBins one{};
  one[48] = 0.5F;  // 55 Hz
  CHECK(audio_autocorrelation(one, 0, false) == doctest::Approx(0.25));
  for (const int position : {1, 40, 127}) {
    const double turns = 55.0 * position * 15 / 48'000;
    CHECK(audio_autocorrelation(one, position, false) ==
          doctest::Approx(0.25 * std::cos(2 * std::numbers::pi * turns)).epsilon(1e-9));
  }
  SpectrumBins all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = 0.1F + 0.001F * static_cast<float>(i);
  double squares = 0;
  for (std::size_t i = 0; i < 120; ++i) squares += double{all[i]} * double{all[i]};
  CHECK(audio_autocorrelation(all, 0, false) == doctest::Approx(squares));
  for (int position = 1; position < 128; ++position) CHECK(audio_autocorrelation(all, position, false) < squares);
  one[48] = 0;
  one[50] = 0.5F;  // the third of its four: it has no part in the other sum
  CHECK(audio_autocorrelation(one, 7, true) == 0);
}

TEST_CASE("the strip shows the notes of a chord by their frequency, each in its share") {
  AudioLinkState state;
  for (ChordNote& note : state.notes) note = {};
  state.notes[0] = {6, 0, 1, 2, 3};    // bin 6: a quarter of the power
  state.notes[1] = {2, 0, 1, 3, 9};    // three quarters; its bin comes after that of note 0, one octave round
  state.notes[4] = {10, 0, -1, 3, 9};  // free
  const std::vector<float> texture = audio_texture(state);
  const auto color = [&](int x) { return at(texture, x, 24); };
  const SoundColor first = chord_color(6, 0.6), second = chord_color(2, 0.9);
  CHECK(color(0) == std::array<float, 4>{first.r, first.g, first.b, 1});
  CHECK(color(31) == color(0));
  CHECK(color(32) == std::array<float, 4>{second.r, second.g, second.b, 1});
  CHECK(color(127) == color(32));
  // AudioLink's cells of note colours begin with note 1.
  const SoundColor note = chord_color(2, 0.4);
  CHECK(at(texture, 25, 22) == std::array<float, 4>{note.r, note.g, note.b, 1});
}

TEST_CASE("every texel of a sound is finite, and exactly the stated places are filled") {
  constexpr int kRateHz = 44'100;
  std::vector<float> samples = sine(110, 3, kRateHz, 0.7);
  for (const std::vector<float>& more : {sine(440, 3, kRateHz, 0.3), clicks(120, 3, kRateHz)}) {
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i] += more[i];
  }
  const std::vector<float> texture = audio_texture(state_after(samples, kRateHz, 1));
  std::set<int> rows;
  for (int y = 0; y < kAudioTextureHeight; ++y) {
    for (int x = 0; x < kAudioTextureWidth; ++x) {
      const auto texel = at(texture, x, y);
      for (const float value : texel) REQUIRE(std::isfinite(value));
      if (texel[0] != 0 || texel[1] != 0 || texel[2] != 0) rows.insert(y);
    }
  }
  // Of the history 270 steps, which fit into its first row.
  CHECK(fmt::format("{}", fmt::join(rows, " ")) == "0 1 2 3 4 5 22 23 24 25 27 28 29 30 31 32");
  for (int x = 16; x < 24; ++x) CHECK(at(texture, x, 28) == std::array<float, 4>{});           // chronotensity
  CHECK(at(texture, 9, 22)[1] >= at(texture, 8, 22)[1]);
  CHECK(at(texture, 32, 28)[1] == 1);  // autolevel is on
}

}  // namespace
}  // namespace footlight

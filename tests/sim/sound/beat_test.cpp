#include "sim/sound/beat.h"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "sim/sound/audio_link.h"
#include "tests/sim/sound/tones.h"
#include "tests/support/long_tests.h"

namespace footlight {
namespace {

struct Found {
  double bpm = 0;
  int beats = 0;
  double worst_s = 0;  // from a beat to the nearest click
};

// Counts beats after the first 8 s; clicks are at multiples of 60 / bpm from first_s on.
void count_beat(Found& found, const Beat& beat, std::uint64_t step, double bpm, double first_s) {
  found.bpm = beat.bpm;
  const double t = static_cast<double>(step) / kSoundStepsPerS;
  if (t < 8 || !beat.is_beat) return;
  ++found.beats;
  const double period = 60 / bpm;
  const double off = std::fmod(t - first_s + 100 * period, period);
  found.worst_s = std::max(found.worst_s, std::min(off, period - off));
}

void check_beats(const Found& found, double bpm, double seconds) {
  MESSAGE(fmt::format("{} bpm: found {:.2f}, {} beats in {} s, worst {:.1f} ms", bpm, found.bpm, found.beats, seconds,
                      found.worst_s * 1e3));
  CHECK(found.bpm == doctest::Approx(bpm).epsilon(0.01));
  CHECK(std::abs(found.beats - seconds * bpm / 60) <= 1.01);
  CHECK(found.worst_s < 0.035);
}

TEST_CASE("clicks at 128 per minute give their tempo within 1 percent and their beats within 35 ms") {
  Found found;
  AudioLink link({}, 8'000, 1);
  link.push(clicks(128, 11, 8'000, 0.13),
            [&](const AudioLinkState& state) { count_beat(found, state.beat, state.step, 128, 0.13); });
  check_beats(found, 128, 3);
}

TEST_CASE("spectra that rise 62 to 178 times a minute give that tempo within 1 percent and beats within 35 ms") {
  for (const double bpm : {62.0, 96.0, 120.0, 140.0, 178.0}) {
    Found found;
    BeatFinder finder(kSoundStepsPerS);
    for (std::uint64_t step = 1; step <= 28 * kSoundStepsPerS; ++step) {
      const double t = static_cast<double>(step) / kSoundStepsPerS;
      const double since = std::fmod(t - 0.13 + 60, 60 / bpm);
      SpectrumBins bins;
      bins.fill(static_cast<float>(std::min(since / 0.03, 1.0) * std::exp(-since / 0.05)));
      count_beat(found, finder.step(bins), step, bpm, 0.13);
    }
    check_beats(found, bpm, 20);
  }
}

TEST_CASE("beats are within 35 ms of a click track after three minutes of play, and with --long after 24 hours") {
  const double bpm = 128;
  const int rate_hz = 8'000;
  const double seconds = testing::runs_long_tests() ? 24 * 3'600 : 180;
  AudioLink link({}, rate_hz, 1);
  // 15 s hold 32 clicks, so the pieces continue each other.
  const std::vector<float> piece = clicks(bpm, 15, rate_hz);
  double worst_s = 0;
  int beats = 0;
  const double counted_from_s = seconds - 30;
  for (double at_s = 0; at_s < seconds; at_s += 15) {
    link.push(piece, [&](const AudioLinkState& state) {
      const double t = static_cast<double>(state.step) / kSoundStepsPerS;
      if (t < counted_from_s || !state.beat.is_beat) return;
      ++beats;
      const double off = std::fmod(t, 60 / bpm);
      worst_s = std::max(worst_s, std::min(off, 60 / bpm - off));
    });
  }
  CHECK(link.frames() == static_cast<std::uint64_t>(seconds * rate_hz));
  CHECK(std::abs(beats - 64) <= 1);
  CHECK(worst_s < 0.035);
}

TEST_CASE("silence and a steady tone have no tempo and no beats") {
  for (const double amplitude : {0.0, 0.5}) {
    int beats = 0;
    AudioLink link({}, 8'000, 1);
    link.push(sine(440, 4, 8'000, amplitude), [&](const AudioLinkState& state) { beats += state.beat.is_beat; });
    CHECK(beats == 0);
    CHECK(link.state().beat.bpm == 0);
  }
}

}  // namespace
}  // namespace footlight

// AudioLink's signals from samples: four bands with their history, filtered bands, level, gain, notes and beats.
//
//   AudioLink link({}, 48'000, 2);
//   link.push(samples, [&](const AudioLinkState& state) { ... });  // once every 1/90 s of sound
//
// Step k is computed from the samples before frame floor(k * rate / 90), counted from the start: no drift, and the same
// result for any sizes of push(). Nothing in a state is ever infinite or NaN: samples that are not finite count as 0.
// AudioLink computes a step for each picture of its world; the steps here are those of a world with 90 pictures a
// second. Further differences: docs/sound.md. Threads: none; not safe to share.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sim/core/clock.h"
#include "sim/sound/audio_meter.h"
#include "sim/sound/beat.h"
#include "sim/sound/color_chord.h"
#include "sim/sound/spectrum.h"

namespace footlight {

inline constexpr int kSoundBands = 4;  // bass, low mids, high mids, treble
inline constexpr int kSoundHistory = 128;
inline constexpr int kSoundStepsPerS = 90;
inline constexpr int kSoundFilters = 16;
inline constexpr int kSoundRateMinHz = 8'000;
inline constexpr int kSoundRateMaxHz = 192'000;
inline constexpr int kSoundChannelsMax = 8;

// AudioLink's names, ranges and defaults.
struct AudioLinkSettings {
  double gain = 1;               // 0 to 2
  double bass = 1;               // 0 to 4: of the lowest bin; between them in proportion to the bin
  double treble = 1;             // 0 to 4: of the highest bin
  bool autogain = true;          // brings quiet and loud sound nearer to each other
  double autogain_derate = 0.1;  // 0.001 to 0.5
  bool autolevel = true;         // lowers the threshold of a band that stays below a half
  std::array<double, kSoundBands> crossover = {0, 0.25, 0.5, 0.75};      // lower ends of the bands, 0 to 1 of the range
  std::array<double, kSoundBands> threshold = {0.45, 0.45, 0.45, 0.45};  // 0.05 to 1: a lower one is more sensitive
  double fade_length = 0.25;                                             // 0 to 1
  double fade_exp_falloff = 0.75;                                        // 0 to 1
  friend bool operator==(const AudioLinkSettings&, const AudioLinkSettings&) = default;
};

// The frequencies between which a band is summed.
struct BandRange {
  double from_hz = 0;
  double to_hz = 0;
};
[[nodiscard]] BandRange band_range(const AudioLinkSettings& settings, int band);

struct AudioLinkState {
  std::uint64_t step = 0;                                                // from 1: its time is step / 90 s
  std::array<std::array<float, kSoundHistory>, kSoundBands> bands{};     // [band][steps ago], 0 to 1
  std::array<std::array<float, kSoundFilters>, kSoundBands> filtered{};  // [band][filter]; the first is the slowest
  SpectrumBins magnitude{};                                              // with gain and treble correction
  SpectrumBins equalised{};                                              // smoothed, with bass and treble
  SpectrumBins smoothed{};
  std::array<float, 2> rms{};  // left and right, over 43 ms, with autogain
  std::array<float, 2> peak{};
  float autogain_level = 0;  // the running level that autogain divides by
  MeterState meter;
  struct Autolevel {
    float magnitude = 0;  // of the band of this step, with threshold and contrast; may be below 0 and above 1
    float boost = 0;      // what its threshold is lowered by
    float confidence = 0;
    bool on = false;
  };
  std::array<Autolevel, kSoundBands> autolevel{};
  Beat beat;
  std::array<ChordNote, kChordNotes> notes{};
  std::array<SoundColor, 4> theme{};
  std::array<SoundColor, kChordLights> lights{};
};

class AudioLink {
 public:
  using OnStep = std::function<void(const AudioLinkState&)>;

  // rate_hz: kSoundRateMinHz to kSoundRateMaxHz; channels: 1 to kSoundChannelsMax.
  AudioLink(const AudioLinkSettings& settings, int rate_hz, int channels);
  // Whole frames of interleaved samples; 1 is full scale. Bands are of the mean of all channels; left and right are the
  // first two.
  void push(std::span<const float> interleaved, const OnStep& on_step);
  [[nodiscard]] const AudioLinkState& state() const { return state_; }
  [[nodiscard]] std::uint64_t frames() const { return frames_; }

 private:
  void take_frame(const float* samples);
  void compute_step();
  void measure_level(double gain);
  void take_band(int band);
  [[nodiscard]] double raw_band(int band) const;

  AudioLinkSettings settings_;
  int rate_hz_;
  int channels_;
  Spectrum spectrum_;
  BeatFinder beat_finder_;
  ColorChord chord_;
  AudioMeter meter_;
  SpectrumBins treble_;  // correction of each bin
  AudioLinkState state_;
  std::uint64_t frames_ = 0;
  std::vector<float> mono_;                   // of the step that is being filled
  std::vector<std::array<float, 2>> newest_;  // a ring of left and right, for the level
  std::size_t newest_at_ = 0;
  std::array<double, kSoundBands> boost_{};  // of autolevel
  std::array<double, kSoundBands> confidence_{};
};

// The time of a step, and the number of frames before it.
[[nodiscard]] constexpr TimeNs step_time_ns(std::uint64_t step) {
  return static_cast<TimeNs>(step / kSoundStepsPerS) * kNsPerS +
         static_cast<TimeNs>(step % kSoundStepsPerS) * kNsPerS / kSoundStepsPerS;
}
[[nodiscard]] constexpr std::uint64_t step_frame(std::uint64_t step, int rate_hz) {
  return step * static_cast<std::uint64_t>(rate_hz) / kSoundStepsPerS;
}

}  // namespace footlight

// Tempo and beats from the spectrum, step by step: onsets, their autocorrelation over 6 s, and the phase of a pulse
// train. Uses earlier steps only, so a beat is predicted from those before it.
//
// Error on synthetic clicks at 60 to 180 per minute: tests/sim/sound/beat_test.cpp, docs/sound.md.
// Threads: none; not safe to share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/sound/spectrum.h"

namespace footlight {

struct Beat {
  bool is_beat = false;     // a beat falls into this step
  double bpm = 0;           // 0: no tempo found
  double confidence = 0;    // 0 to 1: the correlation of the onsets with themselves a beat ago
  double phase = 0;         // share of the beat that has passed, 0 to 1
  std::uint64_t count = 0;  // beats so far
};

class BeatFinder {
 public:
  explicit BeatFinder(double steps_per_s);
  // One step: the spectrum, unsmoothed.
  const Beat& step(const SpectrumBins& magnitudes);

 private:
  void find_tempo();
  void find_phase();
  [[nodiscard]] double onset(std::size_t steps_ago) const;
  [[nodiscard]] double onset_between(double steps_ago) const;
  [[nodiscard]] std::vector<double> correlations(std::size_t count) const;

  double steps_per_s_;
  std::vector<double> onsets_;  // a ring
  std::size_t at_ = 0;
  std::uint64_t steps_ = 0;
  SpectrumBins before_{};
  double loudest_ = 0;  // running largest magnitude
  double level_ = 0;    // running sum of levels
  double period_ = 0;   // steps
  double since_ = 0;    // steps since the last beat
  Beat beat_;
};

}  // namespace footlight

// Notes and their colours: peaks of the spectrum, folded into one octave, followed over time. AudioLink's ColorChord.
//
// Steps are 1/90 s. Source: AudioLink 2. Lights take notes by fixed places instead of random ones, so that the same
// sound gives the same colours. Threads: none; not safe to share.
#pragma once

#include <array>
#include <cstddef>

#include "sim/sound/spectrum.h"

namespace footlight {

inline constexpr int kChordNotes = 10;
inline constexpr int kChordLights = 128;

struct SoundColor {
  float r = 0;
  float g = 0;
  float b = 0;
  friend bool operator==(const SoundColor&, const SoundColor&) = default;
};

// The colour of a bin of an octave (0 to 24) and an intensity; black up to 0.1, full from 1.1.
[[nodiscard]] SoundColor chord_color(double bin, double intensity);

struct ChordNote {
  double bin = 0;       // 0 to 24
  double incoming = 0;  // of this step
  double slow = -1;     // smoothed; below 0: the note is free
  double quick = 0;     // smoothed less
  double power = 0;     // its share of the lights, before they are summed
};

class ColorChord {
 public:
  explicit ColorChord(double step_s) : step_s_(step_s) {}
  // `smoothed`: the spectrum with AudioLink's filter; `loudness`: the root mean square of the sound.
  void step(const SpectrumBins& smoothed, double loudness);
  [[nodiscard]] const std::array<ChordNote, kChordNotes>& notes() const { return notes_; }
  // The colour of a note of notes(); black if it is free.
  [[nodiscard]] SoundColor note_color(std::size_t note) const;
  // The lights, each with the colour of one note, in shares of the notes' power. Light 0 has the strongest note.
  void lights(std::array<SoundColor, kChordLights>& colors) const;

 private:
  void take_peak(double bin, double amplitude);
  void join_notes();

  double step_s_;
  std::array<ChordNote, kChordNotes> notes_{};
};

}  // namespace footlight

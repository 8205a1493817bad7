#include "sim/sound/color_chord.h"

#include <algorithm>
#include <cmath>

namespace footlight {
namespace {

constexpr double kBins = kSpectrumBinsPerOctave;
constexpr int kPeakBinMax = 192;  // peaks above are overtones
constexpr double kClosest = 3;    // bins within which two peaks are one note
constexpr double kNewNoteGain = 8;
constexpr double kSlowLeftPerS = 0.0018;
constexpr double kQuickLeftPerS = 5.822e-5;
constexpr double kSlowLossPerS = 0.6;

double wrapped(double bin) { return bin - kBins * std::floor(bin / kBins); }

// From a to b, the short way round, -12 to 12.
double way(double a, double b) {
  const double up = wrapped(b - a);
  return up > kBins / 2 ? up - kBins : up;
}

SoundColor full_color(double hue, double value) {
  const auto part = [&](double offset) {
    const double k = std::fmod(offset + hue * 6, 6);
    return static_cast<float>(value * (1 - std::clamp(std::min(k, 4 - k), 0.0, 1.0)));
  };
  return {part(5), part(3), part(1)};
}

}  // namespace

SoundColor chord_color(double bin, double intensity) {
  double note = 4 - wrapped(bin) / 2;  // of 12 in an octave
  note -= 12 * std::floor(note / 12);
  // Yellow to red, red to blue, blue to yellow.
  const double hue = note < 4 ? note / 24 : note < 8 ? (note - 2) / 12 : (note - 4) / 8;
  return full_color(hue - std::floor(hue), std::clamp(intensity - 0.1, 0.0, 1.0));
}

void ColorChord::take_peak(double bin, double amplitude) {
  ChordNote* closest = nullptr;
  ChordNote* free = nullptr;
  double distance = kClosest;
  for (ChordNote& note : notes_) {
    if (note.slow <= 0) {
      if (free == nullptr) free = &note;
    } else if (const double apart = std::abs(way(note.bin, bin)); apart < distance) {
      distance = apart;
      closest = &note;
    }
  }
  const double intensity = amplitude * kNewNoteGain;
  if (closest != nullptr) {
    closest->bin += way(closest->bin, bin) * 0.05;
    closest->incoming = std::max(closest->incoming, intensity) + intensity * 0.3;
  } else if (free != nullptr) {
    *free = {bin, intensity, intensity, intensity, 0};
  }
}

void ColorChord::join_notes() {
  for (std::size_t i = 0; i < notes_.size(); ++i) {
    for (std::size_t j = i + 1; j < notes_.size(); ++j) {
      if (notes_[i].slow <= 0 || notes_[j].slow <= 0) continue;
      if (std::abs(way(notes_[i].bin, notes_[j].bin)) >= kClosest) continue;
      notes_[i].bin += way(notes_[i].bin, notes_[j].bin) * 0.5;
      notes_[j] = {};
    }
  }
}

void ColorChord::step(const SpectrumBins& smoothed, double loudness) {
  const double least = 0.1 * loudness;
  for (ChordNote& note : notes_) note.incoming = 0;
  for (int i = kSpectrumBinsPerOctave + 1; i + 1 < kPeakBinMax; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double here = smoothed[at];
    const double below = here - smoothed[at - 1];
    const double above = here - smoothed[at + 1];
    if (below <= 0 || above <= 0 || here <= least) continue;
    // The top of a parabola through the three.
    take_peak(wrapped(i + 0.5 * (below - above) / (below + above)), here);
  }
  join_notes();
  const double slow_left = std::pow(kSlowLeftPerS, step_s_);
  const double quick_left = std::pow(kQuickLeftPerS, step_s_);
  for (ChordNote& note : notes_) {
    if (note.slow < 0) continue;
    note.bin = wrapped(note.bin);
    note.slow = note.incoming + (note.slow - note.incoming) * slow_left - kSlowLossPerS * step_s_;
    note.quick = note.incoming + (note.quick - note.incoming) * quick_left;
    if (note.slow < least || note.slow <= 0) {
      note = {};
      continue;
    }
    note.power = std::pow(std::max(note.slow - least * 10, 0.0), 1.5);
  }
}

SoundColor ColorChord::note_color(std::size_t note) const {
  return notes_[note].slow < 0 ? SoundColor{} : chord_color(notes_[note].bin, notes_[note].slow * 0.4);
}

void ColorChord::lights(std::array<SoundColor, kChordLights>& colors) const {
  std::array<std::size_t, kChordNotes> order{};
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return notes_[a].power > notes_[b].power; });
  double total = 0;
  for (const ChordNote& note : notes_) total += std::max(note.power, 0.0);
  for (std::size_t light = 0; light < colors.size(); ++light) {
    colors[light] = {};
    if (total <= 0) continue;
    const double golden = static_cast<double>(light) * 0.6180339887498949;
    const double place = (golden - std::floor(golden)) * total;
    double sum = 0;
    for (const std::size_t note : order) {
      sum += std::max(notes_[note].power, 0.0);
      if (sum <= place) continue;
      colors[light] = chord_color(notes_[note].bin, notes_[note].quick / 3);
      break;
    }
  }
}

}  // namespace footlight

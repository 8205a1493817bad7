#include "sim/sound/audio_texture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace footlight {
namespace {

constexpr int kSpectrumRow = 4;
constexpr int kLevelRow = 22;
constexpr int kThemeRow = 23;
constexpr int kStripRow = 24;
constexpr int kLightsRow = 25;
constexpr int kCorrelationRow = 27;
constexpr int kFilteredRow = 28;
constexpr int kHistoryRow = 32;
constexpr int kNoteColorsX = 25;  // of note 1; AudioLink leaves out that of note 0
constexpr int kNoteColors = 9;
constexpr int kFilteredLevelsX = 24;
constexpr int kAutolevelX = 32;
constexpr double kNoteBrightness = 0.4;
constexpr double kStripBrightness = 0.3;
constexpr int kCorrelationBins = 120;
constexpr double kCorrelationStep = 15;  // samples of kCorrelationRateHz
constexpr double kCorrelationRateHz = 48'000;

class Texture {
 public:
  Texture() : values_(std::size_t{kAudioTextureWidth} * kAudioTextureHeight * 4) {}
  void set(int x, int y, std::array<float, 4> rgba) {
    const std::size_t at = (static_cast<std::size_t>(y) * kAudioTextureWidth + static_cast<std::size_t>(x)) * 4;
    for (std::size_t i = 0; i < 4; ++i) values_[at + i] = rgba[i];
  }
  void set(int x, int y, float grey) { set(x, y, {grey, grey, grey, 1}); }
  void set(int x, int y, const SoundColor& color) { set(x, y, {color.r, color.g, color.b, 1}); }
  std::vector<float> take() { return std::move(values_); }

 private:
  std::vector<float> values_;
};

// Notes in the order of their frequency, counted from half a bin below note 0. Each has its share of the strip.
void write_strip(const AudioLinkState& state, Texture& texture) {
  std::array<const ChordNote*, kChordNotes> order{};
  double total = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = &state.notes[i];
    if (order[i]->slow > 0) total += std::max(order[i]->power, 0.0);
  }
  const auto place = [&](const ChordNote& note) {
    const double bin = note.bin - state.notes[0].bin + 0.5;
    return bin - kSpectrumBinsPerOctave * std::floor(bin / kSpectrumBinsPerOctave);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](const ChordNote* a, const ChordNote* b) { return place(*a) < place(*b); });
  for (int x = 0; x < kAudioTextureWidth; ++x) {
    SoundColor color;
    double sum = 0;
    for (const ChordNote* note : order) {
      if (note->slow <= 0 || note->power <= 0) continue;
      sum += note->power / total;
      if (sum < (x + 0.5) / kAudioTextureWidth) continue;
      color = chord_color(note->bin, note->quick * kStripBrightness);
      break;
    }
    texture.set(x, kStripRow, color);
  }
}

// A shift register through the four colours of a row, then of the next one.
void write_history(const MeterState& meter, Texture& texture) {
  constexpr std::size_t kWidth = kAudioTextureWidth;
  for (std::size_t row = 0; row < kMeterHistory / (4 * kWidth); ++row) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const auto at = [&](std::size_t color) { return meter.history[(row * 4 + color) * kWidth + x]; };
      texture.set(static_cast<int>(x), kHistoryRow + static_cast<int>(row), {at(0), at(1), at(2), at(3)});
    }
  }
}

void write_levels(const AudioLinkState& state, Texture& texture) {
  texture.set(8, kLevelRow, {state.rms[0], state.peak[0], state.rms[1], state.peak[1]});
  texture.set(9, kLevelRow, state.meter.held);
  texture.set(10, kLevelRow, state.meter.held_s);
  texture.set(11, kLevelRow, {state.autogain_level, state.meter.slow_peak, 0, 0});
  for (std::size_t i = 0; i < kMeterFilters; ++i) {
    const MeterState::Filter& filter = state.meter.filters[i];
    int row = kFilteredRow;
    for (const float value : {filter.level, filter.marker, filter.held, filter.held_s}) {
      texture.set(kFilteredLevelsX + static_cast<int>(i), row++, {value, value, value, value});
    }
  }
}

}  // namespace

double audio_autocorrelation(const SpectrumBins& smoothed, int position, bool uncorrelated) {
  double sum = 0;
  for (int bin = 0; bin < kCorrelationBins; ++bin) {
    if (uncorrelated && bin % 4 > 1) continue;
    const double turn = 2 * std::numbers::pi * kSpectrumBottomHz *
                        std::exp2(static_cast<double>(bin) / kSpectrumBinsPerOctave) / kCorrelationRateHz;
    const double amplitude = smoothed[static_cast<std::size_t>(bin)];
    const double phase = turn * position * kCorrelationStep + (uncorrelated ? 0.32 * bin : 0.0);
    sum += (uncorrelated ? 4 : 1) * amplitude * amplitude * std::cos(phase);
  }
  return sum;
}

std::vector<float> audio_texture(const AudioLinkState& state, const std::optional<std::array<SoundColor, 4>>& theme) {
  Texture texture;
  for (int band = 0; band < kSoundBands; ++band) {
    const auto row = static_cast<std::size_t>(band);
    for (int x = 0; x < kSoundHistory; ++x) texture.set(x, band, state.bands[row][static_cast<std::size_t>(x)]);
    for (int x = 0; x < kSoundFilters; ++x) {
      texture.set(x, kFilteredRow + band, state.filtered[row][static_cast<std::size_t>(x)]);
    }
    const AudioLinkState::Autolevel& level = state.autolevel[row];
    texture.set(kAutolevelX, kFilteredRow + band,
                {level.magnitude, level.on ? 1.0F : 0.0F, level.boost, level.confidence});
  }
  for (int bin = 0; bin < kSpectrumBins; ++bin) {
    const auto at = static_cast<std::size_t>(bin);
    texture.set(bin % kAudioTextureWidth, kSpectrumRow + bin / kAudioTextureWidth,
                {state.magnitude[at], state.equalised[at], state.smoothed[at], 1});
  }
  write_levels(state, texture);
  write_history(state.meter, texture);
  write_strip(state, texture);
  for (int x = 0; x < kAudioTextureWidth; ++x) {
    texture.set(x, kCorrelationRow,
                {static_cast<float>(audio_autocorrelation(state.smoothed, x, false)),
                 static_cast<float>(audio_autocorrelation(state.smoothed, x, true)), 0, 1});
  }
  for (int i = 0; i < kNoteColors; ++i) {
    const ChordNote& note = state.notes[static_cast<std::size_t>(i) + 1];
    const SoundColor color = note.slow < 0 ? SoundColor{} : chord_color(note.bin, note.slow * kNoteBrightness);
    texture.set(kNoteColorsX + i, kLevelRow, color);
  }
  const auto& colors = theme ? *theme : state.theme;
  for (std::size_t i = 0; i < colors.size(); ++i) texture.set(static_cast<int>(i), kThemeRow, colors[i]);
  for (std::size_t i = 0; i < state.lights.size(); ++i) texture.set(static_cast<int>(i), kLightsRow, state.lights[i]);
  return texture.take();
}

}  // namespace footlight

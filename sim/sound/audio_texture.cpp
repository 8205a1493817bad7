#include "sim/sound/audio_texture.h"

namespace footlight {
namespace {

constexpr int kSpectrumRow = 4;
constexpr int kLevelRow = 22;
constexpr int kThemeRow = 23;
constexpr int kLightsRow = 25;
constexpr int kFilteredRow = 28;

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

}  // namespace

std::vector<float> audio_texture(const AudioLinkState& state, const std::optional<std::array<SoundColor, 4>>& theme) {
  Texture texture;
  for (int band = 0; band < kSoundBands; ++band) {
    const auto row = static_cast<std::size_t>(band);
    for (int x = 0; x < kSoundHistory; ++x) texture.set(x, band, state.bands[row][static_cast<std::size_t>(x)]);
    for (int x = 0; x < kSoundFilters; ++x) {
      texture.set(x, kFilteredRow + band, state.filtered[row][static_cast<std::size_t>(x)]);
    }
  }
  for (int bin = 0; bin < kSpectrumBins; ++bin) {
    const auto at = static_cast<std::size_t>(bin);
    texture.set(bin % kAudioTextureWidth, kSpectrumRow + bin / kAudioTextureWidth,
                {state.magnitude[at], state.equalised[at], state.smoothed[at], 1});
  }
  texture.set(8, kLevelRow, {state.rms[0], state.peak[0], state.rms[1], state.peak[1]});
  texture.set(11, kLevelRow, {state.autogain_level, 0, 0, 0});
  const auto& colors = theme ? *theme : state.theme;
  for (std::size_t i = 0; i < colors.size(); ++i) texture.set(static_cast<int>(i), kThemeRow, colors[i]);
  for (std::size_t i = 0; i < state.lights.size(); ++i) texture.set(static_cast<int>(i), kLightsRow, state.lights[i]);
  return texture.take();
}

}  // namespace footlight

// The texture in which AudioLink offers its signals to worlds and avatars: 128 x 64 pixels of four floats.
//
// Row 0 is the first row. Filled is what numbers from 0 to 1 can hold, and what a sound alone determines: bands and
// their history (rows 0 to 3), spectrum (4 and 5), level, held peaks and gain (8 to 11 of row 22), colours of notes (25
// to 33 of row 22), theme (0 to 3 of row 23), strip and lights of the chord (24, 25), autocorrelation (27), filtered
// bands (rows 28 to 31), filtered levels and autolevel beside them, history of levels (32 to 36). Everything else is 0:
// docs/sound.md lists it. Source of the layout: AudioLink 2, AudioLink.cginc and AudioLink.shader.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sim/sound/audio_link.h"

namespace footlight {

inline constexpr int kAudioTextureWidth = 128;
inline constexpr int kAudioTextureHeight = 64;

// `theme`: instead of the notes' colours. Returns width x height x 4 values, row by row.
[[nodiscard]] std::vector<float> audio_texture(const AudioLinkState& state,
                                               const std::optional<std::array<SoundColor, 4>>& theme = {});

// The sum of 120 cosines of the spectrum's lower bins, at a lag of `position` times 15 samples of 48 kHz: a correlation
// of the sound with itself, without its phases. `uncorrelated`: of one bin in two, each shifted by its number.
[[nodiscard]] double audio_autocorrelation(const SpectrumBins& smoothed, int position, bool uncorrelated);

}  // namespace footlight

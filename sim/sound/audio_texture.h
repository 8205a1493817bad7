// The texture in which AudioLink offers its signals to worlds and avatars: 128 x 64 pixels of four floats.
//
// Row 0 is the first row. Filled: bands and their history (rows 0 to 3), spectrum (4 and 5), level and gain (8 and 11
// of row 22), theme colours (0 to 3 of row 23), lights of the chord (row 25), filtered bands (rows 28 to 31).
// Everything else is 0: docs/sound.md lists it. Source of the layout: AudioLink 2, AudioLink.cginc.
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

}  // namespace footlight

// From a colour to the channels that mix it, and back. No Dear ImGui.
//
// Colours are linear RGB of Rec. 709, 0 to 1. Emitters whose colours the file states are mixed by these, so that the
// light is the colour that was picked; of others red, green and blue are taken as those of the screen, and so are the
// filters cyan, magenta and yellow. White, amber and all other emitters are then dark.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/model/fixture_type.h"

namespace footlight::tools {

struct ChannelRaw {
  int channel = 0;  // index into Mode::channels
  std::uint32_t raw = 0;
};

// Of every channel that mixes colours; empty: the mode mixes none. Shares that are out of reach are 0 or 1.
[[nodiscard]] std::vector<ChannelRaw> channels_of_colour(const fixtures::FixtureType& type, const fixtures::Mode& mode,
                                                         const glm::dvec3& rgb);
// What the first three emitters or filters mix; nothing: the mode mixes no colours. raw_of: the raw value of a channel.
[[nodiscard]] std::optional<glm::dvec3> colour_of_channels(const fixtures::FixtureType& type,
                                                           const fixtures::Mode& mode,
                                                           const std::function<std::uint32_t(int)>& raw_of);

// One part, 0 to 1, to the screen's (sRGB) and back.
[[nodiscard]] double linear_of_screen(double value);
[[nodiscard]] double screen_of_linear(double value);

}  // namespace footlight::tools

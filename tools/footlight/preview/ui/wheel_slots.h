// The wheels of a fixture as choices: each slot with what it looks like, and the raw value that selects it. No Dear
// ImGui.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/model/fixture_type.h"
#include "fixtures/model/rig.h"
#include "tools/footlight/preview/ui/picture_shelf.h"

namespace footlight::tools {

struct WheelChoice {
  struct Slot {
    int number = 0;  // in its wheel, from 1
    std::string name;
    std::uint32_t raw = 0;       // that selects it: the middle of its range
    std::uint32_t raw_from = 0;  // its range
    std::uint32_t raw_to = 0;
    glm::dvec3 screen_rgb{1};                    // of white light behind it, sRGB, 0 to 1
    bool coloured = false;                       // it is not white
    bool open = false;                           // nothing is in the beam
    std::size_t facets = 0;                      // of a prism
    std::optional<fixtures::ImageSource> image;  // of a gobo
  };
  int channel = 0;
  std::string name;  // "Gobo", or "Gobo: shake" where the channel has several functions on the wheel
  std::vector<Slot> slots;
};

// Of all channels that select slots, in their order; a function without any is not there.
[[nodiscard]] std::vector<WheelChoice> wheel_choices(const fixtures::FixtureType& type, const fixtures::Mode& mode);

// The picture of a gobo, white on black; within its disc. Errors are those of gobo_texels().
[[nodiscard]] Result<ShelfPicture> gobo_picture(const fixtures::ImageSource& image);

}  // namespace footlight::tools

// Pictures in the style of another system: lists of passes in which its formulas stand for light in the haze and on
// surfaces. They have no unit and no stated error (docs/decisions/0179). The formulas, and what is left out of them:
// docs/vrsl.md, "In the picture".
#pragma once

#include <string_view>

#include "render/plan.h"
#include "sim/core/result.h"

namespace footlight::render {

enum class PictureStyle {
  kPhysical,  // the product's light
  kVrsl,      // VR Stage Lighting's standard mover: cones with added walls, and a projected spot that falls as 1 / d^3
  kCard,      // a flat fan of light for each beam, turned to the camera
};
// "physical", "vrsl" or "card". kBadInput lists them.
[[nodiscard]] Result<PictureStyle> picture_style_of(std::string_view word);
[[nodiscard]] const char* word_of(PictureStyle style);
// Owned by this; lives as long as the program.
[[nodiscard]] const PassList& passes_of(PictureStyle style);
// Without what a style has no place for: bounced light, mirrors, shadows and sums over tiles.
[[nodiscard]] FrameSettings settings_of(PictureStyle style, FrameSettings settings);

}  // namespace footlight::render

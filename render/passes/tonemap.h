// Radiance to the screen: the meter of the automatic exposure, and the tone map. Its push constants from the frame are
// the share of the old exposure that stays, a float.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kTonemapPass;
}  // namespace footlight::render

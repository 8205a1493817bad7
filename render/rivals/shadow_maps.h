#pragma once

#include "render/rivals/rivals.h"

namespace footlight::render {

// The knob is the number of steps in the beam.
extern const PassEntry kShadowMapsSmallPass;  // 256 texels a side
extern const PassEntry kShadowMapsPass;       // 1024
extern const Rival kShadowMapsSmall;
extern const Rival kShadowMaps;

}  // namespace footlight::render

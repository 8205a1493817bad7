// Radiance to the screen: the meter of the automatic exposure, and the tone map. Its push constants from the frame are
// the share of the old exposure that stays, a float.
#pragma once

#include "render/pass.h"
#include "render/resources.h"

namespace footlight::render {
extern const PassEntry kTonemapPass;

// The automatic exposure begins anew: the next picture has the one that suits it.
void forget_exposure(VkCommandBuffer commands, const Resources& resources);
}  // namespace footlight::render

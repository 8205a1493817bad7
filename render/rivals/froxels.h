#pragma once

#include "render/rivals/rivals.h"

namespace footlight::render {

// The knob is the number of froxels across the picture.
extern const PassEntry kFroxelsPass;
extern const PassEntry kFroxelsSampledPass;
extern const Rival kFroxels;         // one sample in the middle of each
extern const Rival kFroxelsSampled;  // eight in each: what eight frames that are averaged over time have at rest

}  // namespace footlight::render

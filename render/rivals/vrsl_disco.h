// VR Stage Lighting's disco ball as a style of pictures: a cube map thrown on all surfaces around it, in place of the
// spots of its beams (docs/vrsl.md, "In the picture").
#pragma once

#include "render/pass.h"

namespace footlight::render {

extern const PassEntry kVrslDiscoPass;

}  // namespace footlight::render

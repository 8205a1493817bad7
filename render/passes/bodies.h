// Raster of fixture bodies, instanced, and of the scene's objects into the visibility buffer, by one indirect draw
// each.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kBodiesPass;
}  // namespace footlight::render

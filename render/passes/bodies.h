// Raster of fixture bodies into the visibility buffer, instanced, by one indirect draw.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kBodiesPass;
}  // namespace footlight::render

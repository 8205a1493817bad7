// Raster of everything solid into the visibility buffer: stage boxes and fixture bodies.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kSolidsPass;
}  // namespace footlight::render

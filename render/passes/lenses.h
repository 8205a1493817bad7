// Lenses whose images are smaller than some pixels: all of their light, wherever they fall on the pixels.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kLensesPass;
}  // namespace footlight::render

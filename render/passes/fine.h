// Beams that are smooth over 32 x 32 pixels, or smooth but for their rim, as polynomials.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kFinePass;
}  // namespace footlight::render

// Beams that are smooth over a supertile but for their rim, as polynomials.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kRimsPass;
}  // namespace footlight::render

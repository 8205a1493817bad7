// Floors that mirror: a share of their light becomes that of the mirrored camera's picture (render/mirror.h).
#pragma once

#include "render/pass.h"

namespace footlight::render {
// Frame::record() leaves it out where no floor that mirrors is in the picture.
extern const PassEntry kGlossPass;
}  // namespace footlight::render

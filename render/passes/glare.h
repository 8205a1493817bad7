// Light that the camera's lens scatters.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kGlarePass;
}  // namespace footlight::render

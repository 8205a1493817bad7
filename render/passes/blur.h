// Depth of field: blurs the light by its distance, before the camera's lens scatters it.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kBlurPass;
}

// Radiance to the screen.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kTonemapPass;
}  // namespace footlight::render

// Light of the beams on everything solid, and shining lenses.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kSurfacesPass;
}  // namespace footlight::render

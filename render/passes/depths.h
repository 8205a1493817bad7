// What each tile shows: distances, and whether it is one plane.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kDepthsPass;
}  // namespace footlight::render

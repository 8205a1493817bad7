// Finds which bodies hide light of which beams: boxes, scenery, and the bodies of fixtures.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kShadowsPass;
}

// Subtracts what is dark of beams that were taken together, where that is smooth over 32 x 32 pixels.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kShadePass;
}

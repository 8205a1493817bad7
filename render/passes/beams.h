// Light of the beams in the haze.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kBeamsPass;
}  // namespace footlight::render

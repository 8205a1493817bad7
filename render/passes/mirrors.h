// Beams that the mirrors of mirror balls send.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kMirrorsPass;
}  // namespace footlight::render

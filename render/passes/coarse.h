// Beams that are smooth over a supertile, summed as one polynomial; the tolerance there.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kCoarsePass;
}  // namespace footlight::render

// Which beams can touch which supertile: one bit each.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kCoarsePass;
}  // namespace footlight::render

// Dark culling and compaction: lit fixtures become beam rows in patch order.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kGatherPass;
}  // namespace footlight::render

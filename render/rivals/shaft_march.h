// A rival: shafts of sunlight behind panes by a march through the box of each.
#pragma once

#include "render/rivals/rivals.h"

namespace footlight::render {

extern const Rival kShaftMarch;

}  // namespace footlight::render

// Light that surfaces reflect to others.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kBouncePass;
}  // namespace footlight::render

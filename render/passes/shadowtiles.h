// Finds which shadows of each beam reach what each supertile shows of it in the haze.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kShadowtilesPass;
}

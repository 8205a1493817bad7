#pragma once

#include "render/rivals/rivals.h"

namespace footlight::render {

extern const PassEntry kBeamCardPass;
extern const Rival kBeamCard;

}  // namespace footlight::render

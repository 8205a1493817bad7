#pragma once

#include "render/rivals/rivals.h"

namespace footlight::render {

extern const PassEntry kRaymarchPass;
extern const Rival kRaymarch;

}  // namespace footlight::render

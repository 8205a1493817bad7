#pragma once

#include "render/rivals/rivals.h"

namespace footlight::render {

extern const PassEntry kConeMeshPass;
extern const Rival kConeMesh;

}  // namespace footlight::render

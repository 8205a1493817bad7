// The pass of displays that are thin in the picture, such as strips (strips.comp): their pixels, after the edges.
#pragma once

#include "render/pass.h"

namespace footlight::render {

extern const PassEntry kStripsPass;

}  // namespace footlight::render

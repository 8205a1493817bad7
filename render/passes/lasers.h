// The pass of scanned lasers: sheets of light from the states of the heads (laserrows.comp), the supertiles that they
// touch (lasermasks.comp), and their light in the air and on surfaces (lasers.comp).
#pragma once

#include "render/pass.h"

namespace footlight::render {

extern const PassEntry kLasersPass;

}  // namespace footlight::render

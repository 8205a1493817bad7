// The pass of displays: the cells of their pixels (displaycells.comp), of images once, of films with new pixels, of
// pixel maps each frame; and the displays themselves, and their light in the air and on surfaces (displays.comp).
#pragma once

#include "render/pass.h"

namespace footlight::render {

extern const PassEntry kDisplaysPass;

}  // namespace footlight::render

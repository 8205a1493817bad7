// The pass of shafts: which occluders reach into the light behind each pane (shaftmasks.comp), and the light of the sun
// in the air and on surfaces, and the panes themselves (shafts.comp).
#pragma once

#include "render/pass.h"

namespace footlight::render {

extern const PassEntry kShaftsPass;

}  // namespace footlight::render

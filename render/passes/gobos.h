// Tables of gobos for light in the haze (render/shaders/lib/gobo_chord.glsl): each is built in the first frame in which
// a lit beam shows its image. Before them the images of gates (render/shaders/gates.comp).
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kGobosPass;
}  // namespace footlight::render

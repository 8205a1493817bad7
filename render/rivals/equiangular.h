#pragma once

#include "render/rivals/rivals.h"

namespace footlight::render {

extern const Rival kEquiangular;         // random places in strata of the part of the ray in the beam
extern const Rival kEquiangularMiddles;  // the middles of the strata
extern const Rival kEquiangularWhole;    // random places in strata of the whole ray, as published
extern const PassEntry kEquiangularPass;
extern const PassEntry kEquiangularMiddlesPass;
extern const PassEntry kEquiangularWholePass;

}  // namespace footlight::render

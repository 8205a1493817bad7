// The tables of bodies and objects.
#pragma once

#include <vector>

#include "fixtures/bodies/solids.h"
#include "render/resources.h"
#include "render/sheen_tables.h"

namespace footlight::render {

// Fills the members of `r` for bodies: one mesh buffer for the levels of the bodies of all types and for the objects,
// heads sorted by type. Adds what is wrong with models to the diagnostics. `object_solids`, if not null, receives what
// stands for the objects where light is blocked. `sheens` gets the materials of both.
Status make_bodies(vk::Device& device, const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                   fixtures::Diagnostics& diagnostics, RigTables& r, std::vector<fixtures::SolidBox>* object_solids,
                   SheenTable& sheens);

}  // namespace footlight::render

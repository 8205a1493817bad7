// The tables of bodies and objects.
#pragma once

#include "render/resources.h"

namespace footlight::render {

// Fills the members of `r` for bodies: one mesh buffer for the levels of the bodies of all types and for the objects,
// heads sorted by type. Adds what is wrong with models to the diagnostics.
Status make_bodies(vk::Device& device, const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                   fixtures::Diagnostics& diagnostics, RigTables& r);

}  // namespace footlight::render

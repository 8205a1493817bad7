// Reflection probes: what surfaces with sheen mirror of the stage (docs/decisions/0171).
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/model/diagnostic.h"
#include "render/resources.h"

namespace footlight::render {

// The probes of the file. A rig without one that has something shiny (Needs::probes) gets one in the box of its lamps
// and scenery, out to the floors, walls and ceilings around them. All have a position. Pure.
[[nodiscard]] std::vector<fixtures::ReflectionProbe> scene_probes(const fixtures::Rig& rig);

// Bytes of the buffer at one of FL_BINDING_PROBE...; 0 at any other.
[[nodiscard]] std::uint64_t probe_bytes(std::uint32_t binding, const MemoryShape& shape);

// Makes the buffers; of one row each where there are no probes. Warns of probes inside something solid.
Status make_probe_tables(vk::Device& device, const MemoryShape& shape, fixtures::Diagnostics& diagnostics,
                         RigTables& r);

}  // namespace footlight::render

// Light that surfaces reflect: patches on the stage boxes and the solids of built-in scenery, probes between them, and
// how much of the light of each patch reaches each patch and each probe (docs/decisions/0113).
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/bodies/tree.h"
#include "render/resources.h"

namespace footlight::render {

// The still parts of a stage as light meets them.
struct BounceScene {
  std::vector<BounceSolidRow> solids;  // the stage boxes first, in the order of the rig
  std::vector<std::uint32_t> order;    // solids as the leaves of the tree number them
  std::vector<fixtures::TreeNode> tree;
  std::vector<BouncePatchRow> patches;  // at most FL_BOUNCE_PATCHES_MAX
  BounceGrid grid{};
  std::vector<BounceProbeRow> probes;  // x first; at most FL_BOUNCE_PROBES_MAX
};

// Patches are about square and as small as their number allows. A face without anything in front of it, and one that is
// thin against a patch, has none. Probes fill what scenery, objects and fixtures fill. `objects`: what the scene's
// meshes fill. with_scenery: else there are only stage boxes. Pure.
[[nodiscard]] BounceScene bounce_scene(const fixtures::Rig& rig, const Extent& objects, bool with_scenery);

// Numbers of a source in the buffer of forms: a multiple of 4.
[[nodiscard]] constexpr std::uint32_t bounce_row(std::uint32_t receivers) { return (receivers + 3) / 4 * 4; }

// Bytes of the buffer at one of FL_BINDING_BOUNCE_...; at most, for those whose length follows from the scene.
[[nodiscard]] std::uint64_t bounce_bytes(std::uint32_t binding, const MemoryShape& shape);

// Makes the buffers; of one row each where no light is reflected.
Status make_bounce_tables(vk::Device& device, const MemoryShape& shape, RigTables& r);

}  // namespace footlight::render

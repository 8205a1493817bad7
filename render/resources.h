// The buffers and images that the passes of a frame share. Made once for a rig and a size; what the rig does not need
// is not allocated.
#pragma once

#include <cstdint>

#include "fixtures/rig.h"
#include "render/frame_io.h"
#include "render/settings.h"
#include "render/vk/memory.h"
#include "render/vk/pipeline.h"

namespace footlight::render {

struct Resources {
  [[nodiscard]] static Result<Resources> create(vk::Device& device, const fixtures::Rig& rig,
                                                const fixtures::CompiledRig& compiled, const FrameSettings& settings);

  // Rig tables, written once. Rows of fixtures/shared/tables.h.
  vk::Buffer types, channels, functions, fixtures;
  vk::Buffer boxes;                                // BoxRow
  vk::Buffer instances, vertices, indices, draws;  // bodies: fixture indices by type; one draw command a type
  vk::Image gobos;                                 // one layer a gobo

  // Per frame.
  vk::Buffer params;  // FrameParams
  vk::Buffer levels;  // universes x 512 bytes
  vk::Buffer states;  // FixtureState, carried from frame to frame
  vk::Buffer beams;   // BeamRow, live ones first
  vk::Buffer counts;  // CountsRow, then live beams of each group of FL_GROUP_FIXTURES
  vk::Buffer masks;   // supertiles x mask_words
  vk::Image surface_id, depth, radiance, screen;

  vk::BindingSet bindings;
  std::uint32_t fixture_count = 0;
  std::uint32_t fixture_groups = 0;
  std::uint32_t box_count = 0;
  std::uint32_t draw_count = 0;
  std::uint32_t supertiles_x = 0;
  std::uint32_t supertiles_y = 0;
  std::uint32_t mask_words = 0;
  std::uint64_t levels_bytes = 0;
  std::uint64_t total_bytes = 0;  // GPU memory, for the report
};

// Gobo images: texels a side, and the width of their edges in units of the gate's radius. Edges are three texels wide,
// so that interpolation between texels follows them.
inline constexpr int kGoboSizePx = 512;
inline constexpr double kGoboEdge = 3.0 * 2.0 / kGoboSizePx;

// Bytes of a FixtureState on the GPU.
inline constexpr std::uint64_t kStateBytes = 64;

}  // namespace footlight::render

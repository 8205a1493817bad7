// Which gobos of a rig have tables for light in the haze, and how large these are (passes/gobos.h builds them).
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/model/rig.h"
#include "render/frame_io.h"

namespace footlight::render {

// Texels of a table of a gobo.
inline constexpr std::uint32_t kGoboWholeRows = FL_GOBO_ANGLES + 1;
inline constexpr std::uint32_t kGoboLinesRows = FL_GOBO_DIRECTIONS * FL_GOBO_NODES;
inline constexpr std::uint64_t kGoboWholeBytes = std::uint64_t{FL_GOBO_CHORDS} * kGoboWholeRows * 8;
inline constexpr std::uint64_t kGoboLinesBytes = std::uint64_t{FL_GOBO_LINES} * kGoboLinesRows * 4;

// GPU memory that tables of gobos in haze may take. Gobos past it are sampled.
inline constexpr std::uint64_t kGoboTableBytesMax = std::uint64_t{256} << 20;

// Which gobos have which tables. Pure.
struct GoboTablePlan {
  std::vector<GoboTableRow> rows;  // one an image
  std::uint32_t whole_layers = 0;
  std::uint32_t lines_layers = 0;
};
// planes: of each image, 1 or 3. Sums along lines for all images of gobo wheels first, in the order of the images, then
// whole chords for each profile that a type with the image has.
[[nodiscard]] GoboTablePlan plan_gobo_tables(const fixtures::CompiledRig& compiled,
                                             const std::vector<std::uint32_t>& planes);

}  // namespace footlight::render

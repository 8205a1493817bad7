// Which gobos of a rig have tables for light in the haze, how many gates have images with tables of their own, and how
// large these are (passes/gobos.h builds them).
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

inline constexpr std::uint64_t kGoboBlurBytes = std::uint64_t{FL_GOBO_BLUR_COLUMNS} * FL_GOBO_BLUR_PX * 8;

// GPU memory that tables of gobos in haze may take. Gobos past it are sampled.
inline constexpr std::uint64_t kGoboTableBytesMax = std::uint64_t{256} << 20;

// Texels of the image of a gate, and of it with its tables, each of one colour.
inline constexpr std::uint64_t kGateImageBytes = std::uint64_t{FL_GATE_PX} * FL_GATE_PX * 2;
inline constexpr std::uint64_t kGateBytes = kGateImageBytes + kGoboWholeBytes + kGoboLinesBytes;

// GPU memory that gates may take.
inline constexpr std::uint64_t kGateBytesMax = std::uint64_t{256} << 20;
// Gates of a rig with only one gobo wheel in each beam: they are in use while a wheel is between two slots.
inline constexpr std::uint32_t kGatesBetweenSlots = 4;

// Which gobos have which tables. Pure. Images that change have none: building takes longer than sampling.
struct GoboTablePlan {
  std::vector<GoboTableRow> rows;  // one an image, then one a gate
  std::uint32_t whole_layers = 0;  // of images
  std::uint32_t lines_layers = 0;
  std::uint32_t blur_layers = 0;  // none where no mode has a focus
  std::uint32_t gates = 0;
  std::uint32_t gate_planes = 1;  // layers of each gate in each texture, behind those of images
};
// planes: of each image, 1 or 3. Sums along lines for all images of gobo wheels first, in the order of the images, then
// blurred copies, then whole chords for each profile that a type with the image has. gates: at most so many.
[[nodiscard]] GoboTablePlan plan_gobo_tables(const fixtures::CompiledRig& compiled,
                                             const std::vector<std::uint32_t>& planes, std::uint32_t gates);

}  // namespace footlight::render

#include "render/resources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <future>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "render/body_tables.h"
#include "render/bounce_tables.h"
#include "render/display_tables.h"
#include "render/glare.h"
#include "render/gobo_tables.h"
#include "render/gobo_textures.h"
#include "render/haze.h"
#include "render/mirror.h"
#include "render/pane_groups.h"
#include "render/pane_tables.h"
#include "render/pass.h"
#include "render/probe_tables.h"
#include "render/shadow_tables.h"
#include "render/sheen_tables.h"
#include "sim/core/no_signals.h"

namespace footlight::render {
namespace {

Result<vk::Buffer> zeroed(vk::Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage = 0) {
  FL_ASSIGN(vk::Buffer buffer,
            vk::Buffer::device_local(device, (bytes + 3) / 4 * 4, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | usage));
  FL_TRY(device.run_once(
      [&](VkCommandBuffer commands) { vkCmdFillBuffer(commands, buffer.handle, 0, VK_WHOLE_SIZE, 0); }));
  return buffer;
}

using fixtures::CompiledRig;

template <auto Member>
std::span<const std::byte> rows_of(const CompiledRig& compiled) {
  return std::as_bytes(std::span(compiled.*Member));
}

std::uint64_t groups_of(const CompiledRig& compiled) {
  return (compiled.heads.size() + FL_GROUP_HEADS - 1) / FL_GROUP_HEADS;
}

// A buffer that follows from the compiled rig: filled with rows, or zero at first.
struct TableEntry {
  std::uint32_t binding;
  vk::Buffer RigTables::*buffer;
  std::span<const std::byte> (*rows)(const CompiledRig& compiled) = nullptr;
  std::uint64_t (*zeros)(const CompiledRig& compiled) = nullptr;
  VkBufferUsageFlags usage = 0;
};

using R = RigTables;
using C = CompiledRig;

constexpr TableEntry kTables[] = {
    {FL_BINDING_TYPES, &R::types, rows_of<&C::types>},
    {FL_BINDING_CHANNELS, &R::channels, rows_of<&C::channels>},
    {FL_BINDING_FUNCTIONS, &R::functions, rows_of<&C::functions>},
    {FL_BINDING_MASTERS, &R::masters, rows_of<&C::masters>},
    {FL_BINDING_MOTORS, &R::motors, rows_of<&C::motors>},
    {FL_BINDING_SPINS, &R::spins, rows_of<&C::spins>},
    {FL_BINDING_JOINTS, &R::joints, rows_of<&C::joints>},
    {FL_BINDING_WHEELS, &R::wheels, rows_of<&C::wheels>},
    {FL_BINDING_FACETS, &R::facets, rows_of<&C::facets>},
    {FL_BINDING_LIGHTS, &R::lights, rows_of<&C::lights>},
    {FL_BINDING_WHEEL_SLOTS, &R::wheel_slots, rows_of<&C::wheel_slots>},
    {FL_BINDING_DEFAULTS, &R::defaults, rows_of<&C::defaults>},
    {FL_BINDING_COLORS, &R::colors, rows_of<&C::colors>},
    {FL_BINDING_HEADS, &R::heads, rows_of<&C::heads>},
    {FL_BINDING_PARAMS, &R::params, nullptr, [](const C&) -> std::uint64_t { return sizeof(FrameParams); },
     VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT},
    {FL_BINDING_METER, &R::meter, nullptr, [](const C&) -> std::uint64_t { return sizeof(MeterRow); }},
    {FL_BINDING_LENSES, &R::lenses, nullptr,
     [](const C& c) { return sizeof(LensesHead) + c.heads.size() * sizeof(LensRow); },
     VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT},
    {FL_BINDING_LEVELS, &R::levels, nullptr,
     [](const C& c) { return std::uint64_t{c.universes.size() * kSlotCountMax}; }},
    {FL_BINDING_STATES, &R::states, nullptr, [](const C& c) { return c.heads.size() * kStateBytes; }},
    {FL_BINDING_MOTOR_STATES, &R::motor_states, nullptr, [](const C& c) { return c.motor_count * kMotorStateBytes; }},
    {FL_BINDING_SPIN_STATES, &R::spin_states, nullptr, [](const C& c) { return c.spin_count * kSpinStateBytes; }},
    {FL_BINDING_SHUTTER_STATES, &R::shutter_states, nullptr,
     [](const C& c) { return c.strobe_count * kShutterStateBytes; }},
    {FL_BINDING_OPTICS_STATES, &R::optics_states, nullptr,
     [](const C& c) { return c.optics_count * kOpticsStateBytes; }},
    {FL_BINDING_DOWSER_STATES, &R::dowser_states, nullptr,
     [](const C& c) { return c.dowser_count * kDowserStateBytes; }},
    {FL_BINDING_SMOOTH_STATES, &R::smooth_states, nullptr,
     [](const C& c) { return (c.flex_count + c.smooth_count) * kSmoothStateBytes; }},
    {FL_BINDING_LASER_STATES, &R::laser_states, nullptr, [](const C& c) { return c.laser_count * kLaserStateBytes; }},
    {FL_BINDING_LASER_SEGMENTS, &R::laser_segments, rows_of<&C::laser_segments>},
    {FL_BINDING_LASERS, &R::lasers, nullptr, [](const C& c) { return c.laser_rows * std::uint64_t{sizeof(LaserRow)}; }},
    {FL_BINDING_MIRROR_BALLS, &R::mirror_balls, rows_of<&C::mirror_balls>},
    {FL_BINDING_MIRROR_PAIRS, &R::mirror_pairs, rows_of<&C::mirror_pairs>},
    {FL_BINDING_MIRROR_NORMALS, &R::mirror_normals, rows_of<&C::mirror_normals>},
    {FL_BINDING_MIRROR_PICKS, &R::mirror_picks, nullptr,
     [](const C& c) { return (1 + c.mirror_pairs.size() + c.mirror_rows) * std::uint64_t{4}; }},
    {FL_BINDING_BEAMS, &R::beams, nullptr, [](const C& c) { return c.beams_max * std::uint64_t{sizeof(BeamRow)}; }},
    {FL_BINDING_COUNTS, &R::counts, nullptr, [](const C& c) { return sizeof(CountsRow) + groups_of(c) * 8; },
     VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT},
};

// Those of the other buffers that stand in RigTables: their rows do not lie in the compiled rig.
constexpr std::pair<std::uint32_t, vk::Buffer RigTables::*> kOtherBuffers[] = {
    {FL_BINDING_BLADES, &R::blades},
    {FL_BINDING_BOXES, &R::boxes},
    {FL_BINDING_OCCLUDERS, &R::occluders},
    {FL_BINDING_BODY_BOXES, &R::body_boxes},
    {FL_BINDING_SHADOW_LISTS, &R::shadow_lists},
    {FL_BINDING_SHADOWS, &R::shadows},
    {FL_BINDING_BEAM_MAPS, &R::shadow_maps},
    {FL_BINDING_BOUNCE_SOLIDS, &R::bounce_solids},
    {FL_BINDING_BOUNCE_TREE, &R::bounce_tree},
    {FL_BINDING_BOUNCE_PATCHES, &R::bounce_patch_rows},
    {FL_BINDING_BOUNCE_GRID, &R::bounce_grid},
    {FL_BINDING_BOUNCE_FORMS, &R::bounce_forms},
    {FL_BINDING_BOUNCE_FLUX, &R::bounce_flux},
    {FL_BINDING_BOUNCE_LIGHT, &R::bounce_light},
    {FL_BINDING_PROBES, &R::probes},
    {FL_BINDING_PROBE_LIGHT, &R::probe_light},
    {FL_BINDING_GLOSS, &R::gloss},
    {FL_BINDING_HAZE, &R::haze},
    {FL_BINDING_PANES, &R::panes},
    {FL_BINDING_PANE_TEXELS, &R::pane_texels},
    {FL_BINDING_PANE_MASKS, &R::pane_masks},
    {FL_BINDING_PANE_GROUPS, &R::pane_groups},
    {FL_BINDING_GROUP_PANES, &R::group_panes},
    {FL_BINDING_PANE_GRIDS, &R::pane_grids},
    {FL_BINDING_PANE_FANS, &R::pane_fans},
    {FL_BINDING_PANE_LINES, &R::pane_lines},
    {FL_BINDING_DISPLAYS, &R::displays},
    {FL_BINDING_DISPLAY_LEVELS, &R::display_levels},
    {FL_BINDING_DISPLAY_CELLS, &R::display_cells},
    {FL_BINDING_DISPLAY_PIXELS, &R::display_pixels},
    {FL_BINDING_DISPLAY_JOBS, &R::display_jobs},
    {FL_BINDING_INSTANCES, &R::slots},
    {FL_BINDING_BODY_MESHES, &R::meshes},
    {FL_BINDING_BODY_LEVELS, &R::body_levels},
    {FL_BINDING_BODY_VERTICES, &R::vertices},
    {FL_BINDING_BODY_INDICES, &R::indices},
    {FL_BINDING_BODY_CHOICES, &R::choices},
    {FL_BINDING_BODY_SPACES, &R::body_spaces},
    {FL_BINDING_BODY_ROUNDS, &R::body_rounds},
    {FL_BINDING_OBJECT_SHELLS, &R::object_shells},
    {FL_BINDING_BODY_DRAWN, &R::drawn},
    {FL_BINDING_BODY_DRAWS, &R::draws},
    {FL_BINDING_TEXTURES, &R::textures},
    {FL_BINDING_TEXTURE_TEXELS, &R::texture_texels},
    {FL_BINDING_OBJECT_UVS, &R::object_uvs},
    {FL_BINDING_SHEENS, &R::sheens},
    {FL_BINDING_GOBO_TABLES, &R::gobo_tables},
    {FL_BINDING_GOBO_QUEUE, &R::gobo_queue},
    {FL_BINDING_GATES, &R::gates}};

// Beams in one place that lavapipe adds up. Mesa ends the loops of a thread after 65,535 rounds of all of them together
// (LP_MAX_TGSI_LOOP_ITERATIONS). A gobo takes about a round a sample.
std::uint32_t lavapipe_beams_max(const MemoryShape& shape) {
  constexpr std::uint32_t kRounds = 65'535;
  // 1,024 with 8 nodes and without shadows; 2,000 were too many. A shadow takes two rounds or more in each of the eight
  // pixels of a thread of the surface pass; few beams have more than 24.
  std::uint32_t plain = 1024;
  if (has_shadows(shape.needs, shape.settings)) {
    const auto occluders =
        static_cast<std::uint32_t>(std::min<std::uint64_t>(occluder_bytes(shape) / sizeof(OccluderRow), 24));
    const std::uint32_t points = shape.settings.penumbra;
    plain = std::min(plain, kRounds / (16 + 16 * occluders * points * (points > 1 ? 2 : 1)));  // soft ones take twice
  }
  return shape.needs.gobo ? std::min(plain, kRounds / std::max(shape.settings.gobo_taps, 1u)) : plain;
}

// A ray through the light of a display nearby takes some 2,400 rounds.
constexpr std::size_t kLavapipeDisplays = 24;

std::uint64_t haze_bytes(const fixtures::Needs& needs) {
  const std::uint64_t plumes = sizeof(f32::HazePlumes) + FL_PUFFS_MAX * sizeof(f32::HazePuff);
  return uneven_haze(needs) ? sizeof(f32::HazeField) + (needs.plumes ? plumes : 0) : 0;
}
std::uint64_t haze_table_bytes(const fixtures::Needs& needs) {
  const std::uint64_t texel = needs.plumes ? 16 : 8;
  return uneven_haze(needs) ? texel * FL_HAZE_X * FL_HAZE_Y * FL_HAZE_SLICES : 0;
}

// Words of a supertile's mask. They come in pairs, as one group of the tile pass writes them.
std::uint32_t mask_words_of(const CompiledRig& compiled) {
  return (compiled.beams_max + FL_GROUP_MASK - 1) / FL_GROUP_MASK * (FL_GROUP_MASK / 32);
}

// Cells of `cell_px` pixels that cover a side of the picture.
std::uint32_t cells(int pixels, std::uint32_t cell_px) {
  return (static_cast<std::uint32_t>(pixels) + cell_px - 1) / cell_px;
}
std::uint32_t supertiles(int pixels) { return cells(pixels, FL_SUPERTILE_PX); }

std::uint64_t mask_bytes(const FrameSettings& settings, std::uint32_t mask_words) {
  return std::uint64_t{4} * supertiles(settings.width) * supertiles(settings.height) * mask_words;
}

std::uint64_t laser_mask_bytes(const FrameSettings& settings, std::uint32_t laser_rows) {
  return std::max<std::uint64_t>(mask_bytes(settings, (laser_rows + 31) / 32), 4);
}

std::uint64_t laser_strip_bytes(const FrameSettings& settings, std::uint32_t laser_rows) {
  if (laser_rows == 0) return sizeof(LaserStripRow);
  return std::uint64_t{supertiles(settings.width)} * supertiles(settings.height) * FL_LASER_STRIPS *
         sizeof(LaserStripRow);
}

std::uint64_t laser_list_bytes(const FrameSettings& settings, std::uint32_t laser_rows) {
  if (laser_rows == 0) return sizeof(LaserListRow);
  return std::uint64_t{supertiles(settings.width)} * supertiles(settings.height) * sizeof(LaserListRow);
}

std::uint64_t display_tile_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  if (!has_displays(needs, settings)) return sizeof(DisplayTileRow);
  return std::uint64_t{cells(settings.width, FL_TILE_PX)} * cells(settings.height, FL_TILE_PX) * sizeof(DisplayTileRow);
}

// No more rows than a device may have workgroups in a line.
std::uint64_t display_record_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  if (!has_display_records(needs, settings)) return sizeof(DisplayListsHead) + sizeof(DisplayRecordRow);
  const std::uint64_t squares = std::uint64_t{supertiles(settings.width)} * supertiles(settings.height);
  return sizeof(DisplayListsHead) +
         std::min<std::uint64_t>(FL_DISPLAY_RECORDS * (squares + 32), 65'535) * sizeof(DisplayRecordRow);
}

std::uint32_t laser_rows_of(const MemoryShape& shape) { return shape.needs.laser ? shape.compiled.laser_rows : 0; }

std::uint64_t tile_depth_bytes(const FrameSettings& settings, bool used) {
  if (!used) return sizeof(TileDepthRow);
  return std::uint64_t{cells(settings.width, FL_TILE_PX)} * cells(settings.height, FL_TILE_PX) * sizeof(TileDepthRow);
}

std::uint64_t coarse_bytes(const FrameSettings& settings, bool used) {
  if (!used) return sizeof(CoarseRow);
  return std::uint64_t{supertiles(settings.width)} * supertiles(settings.height) * sizeof(CoarseRow);
}

// Rows of the RimRow or the CutRow table that a supertile has. What is beyond is left to the fine pass, which takes
// longer.
struct RecordShape {
  std::uint32_t least;
  std::uint32_t most;
  std::uint32_t share;  // one row for so many beams of the rig
  std::uint32_t row_bytes;
};
constexpr RecordShape kRims{FL_RIMS_MIN, FL_RIMS_MAX, FL_RIMS_SHARE, sizeof(RimRow)};
constexpr RecordShape kCuts{FL_CUTS_MIN, FL_CUTS_MAX, FL_CUTS_SHARE, sizeof(CutRow)};

std::uint64_t supertile_count(const FrameSettings& settings) {
  return std::uint64_t{supertiles(settings.width)} * supertiles(settings.height);
}
// A table has at most FL_RECORD_BYTES_MAX, which every device allows.
std::uint32_t record_rows(const RecordShape& shape, const FrameSettings& settings, std::uint32_t mask_words,
                          bool used) {
  if (!used) return 0;
  const std::uint32_t rows = std::clamp(mask_words * 32 / shape.share, shape.least, shape.most);
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(rows, FL_RECORD_BYTES_MAX / shape.row_bytes / supertile_count(settings)));
}
std::uint64_t record_bytes(const RecordShape& shape, const FrameSettings& settings, std::uint32_t rows) {
  return std::max<std::uint64_t>(supertile_count(settings) * rows, 1) * shape.row_bytes;
}

std::uint64_t shadow_word_bytes(const FrameSettings& settings, std::uint32_t mask_words, bool used) {
  return used ? mask_bytes(settings, mask_words) / 4 * sizeof(ShadowWordRow) : sizeof(ShadowWordRow);
}
// The words of all supertiles together, and the number of those in use.
std::uint64_t shadow_pick_bytes(const FrameSettings& settings, std::uint32_t mask_words, bool used) {
  if (!used) return 12;
  const std::uint64_t words =
      std::max<std::uint64_t>(std::uint64_t{mask_words} * 32 * FL_PICKS_A_BEAM, FL_PICKS_MIN) * settings.penumbra;
  return std::min<std::uint64_t>(8 + supertile_count(settings) * words * 4, FL_PICKS_BYTES_MAX);
}

std::uint64_t fine_mask_bytes(const FrameSettings& settings, std::uint32_t mask_words, bool used) {
  if (!used) return 4;
  return std::uint64_t{4} * cells(settings.width, FL_FINE_PX) * cells(settings.height, FL_FINE_PX) * mask_words;
}

std::uint64_t shade_word_bytes(const FrameSettings& settings, std::uint32_t mask_words, bool used) {
  return used ? fine_mask_bytes(settings, mask_words, true) / 4 * sizeof(ShadowWordRow) : sizeof(ShadowWordRow);
}

std::uint64_t blur_tile_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  if (!has_depth_of_field(needs, settings)) return 0;
  return sizeof(float) * std::uint64_t{cells(settings.width, FL_TILE_PX)} * cells(settings.height, FL_TILE_PX);
}

std::uint64_t pixel_words(const FrameSettings& settings) {
  return std::uint64_t{4} * static_cast<std::uint64_t>(settings.width) * static_cast<std::uint64_t>(settings.height);
}

std::uint64_t screen_pixels(const FrameSettings& settings) {
  const auto side = static_cast<std::uint64_t>(settings.supersample);
  return pixel_words(settings) / 4 / (side * side);
}

std::uint64_t computed_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_computed_triangles(needs, settings) ? pixel_words(settings) : 4;
}

std::uint64_t pixel_box_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.surfaces ? pixel_words(settings) : 4;
}

std::uint64_t pixel_key_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_joined_words(needs, settings) ? 2 * pixel_words(settings) : computed_bytes(needs, settings);
}

std::uint64_t draw_block_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  const bool draws = has_computed_triangles(needs, settings) ||
                     (has_smooth_edges(needs, settings) && has_bodies(needs, settings));
  return sizeof(DrawBlocksHead) + (draws ? FL_BLOCKS_MAX : 1) * sizeof(DrawBlockRow);
}

std::uint64_t edge_id_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_smooth_edges(needs, settings) ? 2 * pixel_words(settings) : 8;
}

std::uint64_t edge_sample_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  if (!has_smooth_edges(needs, settings)) return 4;
  return std::uint64_t{4} * settings.edge_samples * edge_room(settings);
}

std::uint64_t edge_mask_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  if (!has_smooth_edges(needs, settings)) return 4;
  return std::uint64_t{4} * FL_EDGE_WORDS * cells(settings.width, FL_TILE_PX) * cells(settings.height, FL_TILE_PX);
}

std::uint64_t edge_part_bytes(const fixtures::Needs& needs, const FrameSettings& settings) {
  return sizeof(EdgePartRow) * (has_smooth_edges(needs, settings) ? cells(settings.height, FL_TILE_PX) : 1);
}

std::uint64_t edge_bytes(std::uint32_t binding, const fixtures::Needs& needs, const FrameSettings& settings) {
  switch (binding) {
    case FL_BINDING_EDGES: return has_smooth_edges(needs, settings) ? 4 * pixel_words(settings) : 16;
    case FL_BINDING_EDGE_IDS: return edge_id_bytes(needs, settings);
    case FL_BINDING_EDGE_SAMPLES: return edge_sample_bytes(needs, settings);
    case FL_BINDING_EDGE_MASKS: return edge_mask_bytes(needs, settings);
    default: return edge_part_bytes(needs, settings);
  }
}

// With all levels of detail.
std::uint64_t image_bytes(int size_px) {
  std::uint64_t texels = 0;
  for (auto size = static_cast<std::uint64_t>(size_px); size > 0; size /= 2) texels += size * size;
  return texels * 4;
}

std::uint64_t gobo_bytes(const MemoryShape& shape) {
  const std::size_t images = shape.compiled.images.size();
  return images == 0 ? 4 : images * image_bytes(gobo_size_px(shape.settings, images, false));
}

// What is known before the images are read: built-in gobos are grey, others may have colours.
GoboTablePlan largest_gobo_tables(const MemoryShape& shape) {
  if (!has_gobo_tables(shape.needs, shape.settings)) return {};
  std::vector<std::uint32_t> planes;
  for (const fixtures::ImageSource& image : shape.compiled.images) {
    planes.push_back(image.name.starts_with(fixtures::kBuiltinImage) ? 1 : 3);
  }
  return plan_gobo_tables(shape.compiled, planes, shape.settings.gobo_gates);
}

// Tables of each kind that a frame may build.
std::uint64_t gobo_jobs_max(const CompiledRig& compiled) {
  return std::uint64_t{FL_GOBO_PROFILES} * compiled.images.size() + FL_GATES_MAX;
}
std::uint64_t gobo_queue_bytes(const CompiledRig& compiled) {
  return sizeof(GoboQueue) + 8 * gobo_jobs_max(compiled) + 4 * (FL_GATES_MAX + compiled.images.size());
}
std::uint64_t gates_bytes(const GoboTablePlan& plan) {
  return plan.gates > 0 ? sizeof(GatesHead) + std::uint64_t{2} * plan.gates * sizeof(GateRow) : 0;
}

std::uint64_t gobo_table_bytes(std::uint32_t binding, const GoboTablePlan& plan) {
  const std::uint64_t gate_layers = std::uint64_t{plan.gates} * plan.gate_planes;
  switch (binding) {
    case FL_BINDING_GOBO_WHOLE_OUT: return (plan.whole_layers + gate_layers) * kGoboWholeBytes;
    case FL_BINDING_GOBO_LINES_OUT: return (plan.lines_layers + gate_layers) * kGoboLinesBytes;
    case FL_BINDING_GOBO_BLURS_OUT: return plan.blur_layers * kGoboBlurBytes;
    case FL_BINDING_GATE_IMAGES_OUT: return gate_layers * kGateImageBytes;
    default: return gates_bytes(plan);
  }
}

// A table in an image and, where there is none, a texel, since shaders name it.
Result<vk::Image> table_image(vk::Device& device, std::uint32_t columns, std::uint32_t rows, std::uint32_t layers,
                              VkFormat format) {
  return vk::Image::create(device, layers > 0 ? columns : 1, layers > 0 ? rows : 1, format,
                           VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT, std::max(layers, 1u));
}

Status make_gobo_tables(vk::Device& device, const CompiledRig& compiled, const GoboTablePlan& plan, RigTables& r) {
  r.gobo_queue_empty = {
      .whole_groups = {FL_GOBO_CHORDS / FL_GROUP_GOBOS, FL_GOBO_ANGLES + 1, 0, 0},
      .lines_groups = {FL_GOBO_LINES / FL_GROUP_GOBOS, FL_GOBO_DIRECTIONS, 0, 0},
      .gate_groups = {FL_GATE_PX / FL_GROUP_GATE_PX, FL_GATE_PX / FL_GROUP_GATE_PX, 0, 0},
      .blur_groups = {FL_GOBO_BLUR_COLUMNS / FL_GROUP_GOBOS, FL_GOBO_BLUR_PX, 0, 0},
      .capacity = static_cast<std::uint32_t>(gobo_jobs_max(compiled)),
      .gates = plan.gates,
      .gate_builds = 0,
      .gate_planes = plan.gate_planes,
      .gate_row = static_cast<std::uint32_t>(compiled.images.size()),
      .gate_whole_layer = plan.whole_layers,
      .gate_lines_layer = plan.lines_layers,
      .pad = 0,
  };
  const std::uint32_t gate_layers = plan.gates * plan.gate_planes;
  FL_ASSIGN(r.gobo_tables, vk::Buffer::table(device, plan.rows));
  FL_ASSIGN(r.gobo_queue, zeroed(device, gobo_queue_bytes(compiled), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
  FL_ASSIGN(r.gobo_whole, table_image(device, FL_GOBO_CHORDS, kGoboWholeRows, plan.whole_layers + gate_layers,
                                      VK_FORMAT_R16G16B16A16_SFLOAT));
  FL_ASSIGN(r.gobo_lines, table_image(device, FL_GOBO_LINES, kGoboLinesRows, plan.lines_layers + gate_layers,
                                      VK_FORMAT_R16G16_UNORM));
  FL_ASSIGN(r.gobo_blurs, table_image(device, FL_GOBO_BLUR_COLUMNS, FL_GOBO_BLUR_PX, plan.blur_layers,
                                      VK_FORMAT_R16G16B16A16_SFLOAT));
  FL_ASSIGN(r.gates, zeroed(device, std::max<std::uint64_t>(gates_bytes(plan), 16)));
  FL_ASSIGN(r.gate_images, table_image(device, FL_GATE_PX, FL_GATE_PX, gate_layers, VK_FORMAT_R16_SFLOAT));
  return device.run_once([&](VkCommandBuffer commands) {
    for (const vk::Image* image : {&r.gobo_whole, &r.gobo_lines, &r.gobo_blurs, &r.gate_images}) {
      vk::change_layout(commands, *image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    }
  });
}

// They are read beside the other tables, which take as long.
Result<std::future<GoboTexels>> begin_gobos(const vk::Device& device, const MemoryShape& shape, bool used) {
  if (!used) return std::future<GoboTexels>();
  const std::vector<fixtures::ImageSource>& images = shape.compiled.images;
  FL_TRY(check_gobos(device, images.size()));
  const int size_px = gobo_size_px(shape.settings, images.size(), device.is_software());
  const NoSignals no_signals;
  return std::async(std::launch::async, [&images, size_px] { return read_gobos(images, size_px); });
}

// States of all lamps of a kind, by its number in FL_LAMPS.
std::uint64_t lamp_bytes(const CompiledRig& compiled, std::uint32_t lamp) {
  return compiled.lamp_counts[lamp] * kLampStateBytes;
}

// What lavapipe leaves out of a picture without an error.
void add_lavapipe_limits(const vk::Device& device, const MemoryShape& shape, fixtures::Diagnostics& diagnostics) {
  const std::uint32_t beams_max = lavapipe_beams_max(shape);
  if (shape.compiled.beams_max > beams_max) {
    diagnostics.add({fixtures::Severity::kWarning,
                     "many-beams",
                     {},
                     fmt::format("{} beams: {} ends the loops of a shader after 65,535 rounds, so where more than {} "
                                 "beams meet, light may be missing; a GPU has no such limit",
                                 shape.compiled.beams_max, device.name(), beams_max),
                     ""});
  }
  if (shape.rig.displays.size() > kLavapipeDisplays) {
    diagnostics.add({fixtures::Severity::kWarning,
                     "many-displays",
                     {},
                     fmt::format("{} displays: {} ends the loops of a shader after 65,535 rounds, so light of the last "
                                 "may be missing where more than {} are near; a GPU has no such limit",
                                 shape.rig.displays.size(), device.name(), kLavapipeDisplays),
                     ""});
  }
}

}  // namespace

int gobo_size_px(const FrameSettings& settings, std::size_t images, bool cpu) {
  if (settings.gobo_px > 0) return settings.gobo_px;
  return cpu || images * image_bytes(kGoboFineSizePx) > kGoboFineBytesMax ? kGoboSizePx : kGoboFineSizePx;
}

std::uint64_t binding_bytes(std::uint32_t binding, const MemoryShape& shape) {
  for (const TableEntry& table : kTables) {
    if (table.binding != binding) continue;
    return table.rows != nullptr ? table.rows(shape.compiled).size() : table.zeros(shape.compiled);
  }
  for (std::uint32_t lamp = 1; lamp <= FL_LAMP_COUNT; ++lamp) {
    if (binding == FL_BINDING_LAMP(lamp)) return lamp_bytes(shape.compiled, lamp);
  }
  const FrameSettings& settings = shape.settings;
  const std::uint64_t pixels = pixel_words(settings) / 4;
  const std::uint64_t solid_pixels = has_bodies(shape.needs, settings) ? pixels : 1;
  switch (binding) {
    case FL_BINDING_BLADES: return shape.needs.blades ? shape.compiled.beams_max * std::uint64_t{sizeof(BladesRow)} : 0;
    case FL_BINDING_OCCLUDERS: return occluder_bytes(shape);
    case FL_BINDING_SHADOW_LISTS: return shadow_list_bytes(shape);
    case FL_BINDING_SHADOWS: return shadow_bytes(shape);
    case FL_BINDING_BEAM_MAPS: return shadow_map_bytes(shape);
    case FL_BINDING_BOUNCE_SOLIDS:
    case FL_BINDING_BOUNCE_TREE:
    case FL_BINDING_BOUNCE_PATCHES:
    case FL_BINDING_BOUNCE_GRID:
    case FL_BINDING_BOUNCE_FORMS:
    case FL_BINDING_BOUNCE_FLUX:
    case FL_BINDING_BOUNCE_LIGHT: return bounce_bytes(binding, shape);
    case FL_BINDING_PANES: return shape.rig.panes.size() * sizeof(PaneRow);
    case FL_BINDING_PANE_TEXELS: return pane_texel_bytes(shape.rig);
    case FL_BINDING_PANE_MASKS: return pane_mask_bytes(shape.rig, occluder_bytes(shape) / sizeof(OccluderRow));
    case FL_BINDING_PANE_GROUPS:
    case FL_BINDING_GROUP_PANES:
    case FL_BINDING_PANE_GRIDS:
    case FL_BINDING_PANE_FANS:
    case FL_BINDING_PANE_LINES: return pane_group_bytes(binding, shape.rig, has_pane_sums(shape.needs));
    case FL_BINDING_DISPLAYS:
    case FL_BINDING_DISPLAY_LEVELS:
    case FL_BINDING_DISPLAY_CELLS:
    case FL_BINDING_DISPLAY_PIXELS:
    case FL_BINDING_DISPLAY_JOBS: return display_bytes(binding, shape);
    case FL_BINDING_HAZE: return haze_bytes(shape.needs);
    case FL_BINDING_HAZE_TABLE_OUT: return haze_table_bytes(shape.needs);
    case FL_BINDING_BOXES: return shape.rig.boxes.size() * sizeof(BoxRow);
    case FL_BINDING_GOBOS: return gobo_bytes(shape);
    case FL_BINDING_GOBO_TABLES: return largest_gobo_tables(shape).rows.size() * sizeof(GoboTableRow);
    case FL_BINDING_GOBO_QUEUE: return gobo_queue_bytes(shape.compiled);
    case FL_BINDING_GOBO_WHOLE_OUT:
    case FL_BINDING_GOBO_LINES_OUT:
    case FL_BINDING_GOBO_BLURS_OUT:
    case FL_BINDING_GATES:
    case FL_BINDING_GATE_IMAGES_OUT: return gobo_table_bytes(binding, largest_gobo_tables(shape));
    case FL_BINDING_MASKS: return mask_bytes(settings, mask_words_of(shape.compiled));
    case FL_BINDING_LASER_MASKS: return laser_mask_bytes(settings, laser_rows_of(shape));
    case FL_BINDING_LASER_STRIPS: return laser_strip_bytes(settings, laser_rows_of(shape));
    case FL_BINDING_LASER_LISTS: return laser_list_bytes(settings, laser_rows_of(shape));
    case FL_BINDING_DISPLAY_TILES: return display_tile_bytes(shape.needs, settings);
    case FL_BINDING_DISPLAY_RECORDS: return display_record_bytes(shape.needs, settings);
    case FL_BINDING_TILE_DEPTHS: return tile_depth_bytes(settings, has_tile_depths(shape.needs, settings));
    case FL_BINDING_SHADOW_WORDS:
      return shadow_word_bytes(settings, mask_words_of(shape.compiled), has_shadows_in_air(shape.needs, settings));
    case FL_BINDING_SHADOW_PICKS:
      return shadow_pick_bytes(settings, mask_words_of(shape.compiled),
                               has_shadows_in_air(shape.needs, settings) && shadow_map_bytes(shape) <= 4);
    case FL_BINDING_FINE_MASKS:
      return fine_mask_bytes(settings, mask_words_of(shape.compiled), has_tile_classes(shape.needs, settings));
    case FL_BINDING_SHADE_WORDS:
      return shade_word_bytes(settings, mask_words_of(shape.compiled),
                              has_tile_classes(shape.needs, settings) && has_shadows(shape.needs, settings));
    case FL_BINDING_COARSE: return coarse_bytes(settings, has_tile_classes(shape.needs, settings));
    case FL_BINDING_RIMS:
    case FL_BINDING_CUTS: {
      const RecordShape& records = binding == FL_BINDING_RIMS ? kRims : kCuts;
      const bool classes = has_tile_classes(shape.needs, settings);
      return record_bytes(records, settings, record_rows(records, settings, mask_words_of(shape.compiled), classes));
    }
    case FL_BINDING_PIXEL_DEPTHS: return computed_bytes(shape.needs, settings);
    case FL_BINDING_PIXEL_BOXES: return pixel_box_bytes(shape.needs, settings);
    case FL_BINDING_PIXEL_KEYS: return pixel_key_bytes(shape.needs, settings);
    case FL_BINDING_DRAW_BLOCKS: return draw_block_bytes(shape.needs, settings);
    case FL_BINDING_EDGES:
    case FL_BINDING_EDGE_IDS:
    case FL_BINDING_EDGE_SAMPLES:
    case FL_BINDING_EDGE_MASKS:
    case FL_BINDING_EDGE_PARTS: return edge_bytes(binding, shape.needs, settings);
    case FL_BINDING_SHEENS: return shape.needs.sheen ? FL_SHEENS_MAX * sizeof(SheenRow) : 0;
    case FL_BINDING_GLOSS: return gloss_rows(shape.rig).size() * sizeof(GlossRow);
    case FL_BINDING_MIRROR: return mirror_bytes(shape);
    case FL_BINDING_BLURRED: return has_depth_of_field(shape.needs, settings) ? pixels * 16 : 0;
    case FL_BINDING_BLURS: return blur_tile_bytes(shape.needs, settings);
    case FL_BINDING_GLARE: return has_glare(shape.needs, settings) ? glare_shape(settings).bytes() : 0;
    case FL_BINDING_SURFACE_ID: return solid_pixels * 8;
    case FL_BINDING_DEPTH: return (has_computed_triangles(shape.needs, settings) ? 1 : solid_pixels) * 4;
    case FL_BINDING_RADIANCE: return pixels * 16;
    case FL_BINDING_SCREEN: return screen_pixels(settings) * 4;
    default: return probe_bytes(binding, shape);
  }
}

namespace {

Result<vk::Buffer> make_boxes(vk::Device& device, const fixtures::Rig& rig, SheenTable& sheens) {
  std::vector<BoxRow> boxes;
  for (const fixtures::StageBox& box : rig.boxes) {
    boxes.push_back({vec4(box.min_m, 0), vec4(box.max_m, 0), vec4(box.albedo, sheens.number(box.sheen))});
  }
  return vk::Buffer::table(device, boxes);
}

Status make_sheens(vk::Device& device, const fixtures::Rig& rig, const SheenTable& sheens, bool used,
                   fixtures::Diagnostics& diagnostics, RigTables& r) {
  r.sheen_count = static_cast<std::uint32_t>(sheens.rows().size()) - 1;
  if (auto warning = sheens.warning(rig.name)) diagnostics.add(std::move(*warning));
  if (used) {
    FL_ASSIGN(r.sheens, vk::Buffer::table(device, sheens.rows()));
  }
  return {};
}

}  // namespace

Result<RigTables> RigTables::create(vk::Device& device, const MemoryShape& shape, const std::vector<bool>& used) {
  const CompiledRig& compiled = shape.compiled;
  RigTables r;
  r.head_count = static_cast<std::uint32_t>(compiled.heads.size());
  r.head_groups = static_cast<std::uint32_t>(groups_of(compiled));
  r.motor_count = compiled.motor_count;
  r.spin_count = compiled.spin_count;
  r.shutter_count = compiled.strobe_count;
  r.optics_count = compiled.optics_count;
  r.lamp_counts = compiled.lamp_counts;
  r.dowser_count = compiled.dowser_count;
  r.smooth_count = compiled.flex_count + compiled.smooth_count;
  r.box_count = static_cast<std::uint32_t>(shape.rig.boxes.size());
  r.laser_count = compiled.laser_count;
  r.laser_rows = compiled.laser_rows;
  r.mirror_pair_count = static_cast<std::uint32_t>(compiled.mirror_pairs.size());
  r.beams_max = compiled.beams_max;
  r.mask_words = mask_words_of(compiled);
  r.levels_bytes = compiled.universes.size() * kSlotCountMax;

  for (const TableEntry& entry : kTables) {
    if (!used[entry.binding]) continue;
    if (entry.rows != nullptr) {
      FL_ASSIGN(r.*entry.buffer,
                vk::Buffer::filled(device, entry.rows(compiled), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | entry.usage));
    } else {
      FL_ASSIGN(r.*entry.buffer, zeroed(device, entry.zeros(compiled), entry.usage));
    }
  }
  for (std::uint32_t lamp = 1; lamp <= FL_LAMP_COUNT; ++lamp) {
    if (!used[FL_BINDING_LAMP(lamp)]) continue;
    FL_ASSIGN(r.lamp_states[lamp], zeroed(device, lamp_bytes(compiled, lamp)));
  }
  if (r.levels_bytes > kUpdateBytesMax) {
    FL_ASSIGN(r.staged_levels, vk::Buffer::host_visible(device, r.levels_bytes, 0));
  }
  if (used[FL_BINDING_BLADES]) {
    FL_ASSIGN(r.blades, zeroed(device, binding_bytes(FL_BINDING_BLADES, shape)));
  }
  if (used[FL_BINDING_HAZE]) {
    FL_ASSIGN(r.haze, zeroed(device, binding_bytes(FL_BINDING_HAZE, shape)));
    const std::uint32_t slices = uneven_haze(shape.needs) ? FL_HAZE_SLICES : 0;
    const VkFormat format = shape.needs.plumes ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R32G32_SFLOAT;
    FL_ASSIGN(r.haze_table, table_image(device, FL_HAZE_X, FL_HAZE_Y, slices, format));
    FL_TRY(device.run_once([&](VkCommandBuffer commands) {
      vk::change_layout(commands, r.haze_table, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    }));
  }
  if (used[FL_BINDING_GLOSS]) {
    const std::vector<GlossRow> rows = gloss_rows(shape.rig);
    r.gloss_count = static_cast<std::uint32_t>(rows.size());
    FL_ASSIGN(r.gloss, vk::Buffer::table(device, rows));
  }
  SheenTable sheens;
  if (used[FL_BINDING_BOXES]) {
    FL_ASSIGN(r.boxes, make_boxes(device, shape.rig, sheens));
  }
  FL_ASSIGN(std::future<GoboTexels> reading_gobos, begin_gobos(device, shape, used[FL_BINDING_GOBOS]));
  fixtures::Diagnostics diagnostics;
  if (device.name().find("llvmpipe") != std::string::npos) add_lavapipe_limits(device, shape, diagnostics);
  r.has_bodies = render::has_bodies(shape.needs, shape.settings);
  r.has_shadows = render::has_shadows(shape.needs, shape.settings);
  r.has_occluders = render::has_occluders(shape.needs, shape.settings);
  std::vector<fixtures::SolidBox> object_solids;
  if (r.has_bodies) {
    FL_TRY(
        make_bodies(device, shape.rig, compiled, diagnostics, r, r.has_occluders ? &object_solids : nullptr, sheens));
  }
  FL_TRY(make_sheens(device, shape.rig, sheens, used[FL_BINDING_SHEENS], diagnostics, r));
  if (used[FL_BINDING_SHADOWS] || used[FL_BINDING_OCCLUDERS]) {  // the former also where there are maps
    FL_TRY(make_shadow_tables(device, shape, object_solids, r));
  }
  if (used[FL_BINDING_PANES]) FL_TRY(make_pane_tables(device, shape.rig, has_pane_sums(shape.needs), r));
  if (used[FL_BINDING_DISPLAYS]) FL_TRY(make_display_tables(device, shape, r));
  r.disco_balls = render::disco_balls(shape.rig, shape.compiled);
  if (used[FL_BINDING_BOUNCE_LIGHT]) FL_TRY(make_bounce_tables(device, shape, r));
  if (used[FL_BINDING_PROBE_LIGHT]) FL_TRY(make_probe_tables(device, shape, diagnostics, r));
  std::vector<std::uint32_t> gobo_planes;
  if (reading_gobos.valid()) {
    GoboTexels gobos = reading_gobos.get();
    FL_ASSIGN(r.gobos, make_gobos(device, gobos));
    r.gobo_px = gobos.size_px;
    gobo_planes = std::move(gobos.planes);
    for (fixtures::Diagnostic& trouble : gobos.troubles) diagnostics.add(std::move(trouble));
  }
  if (used[FL_BINDING_GOBO_TABLES]) {
    gobo_planes.resize(compiled.images.size(), 1);
    GoboTablePlan plan;
    if (has_gobo_tables(shape.needs, shape.settings))
      plan = plan_gobo_tables(compiled, gobo_planes, shape.settings.gobo_gates);
    if (device.limits().maxImageDimension2D < kGoboLinesRows) {  // 4096 is guaranteed: it samples all gobos
      for (GoboTableRow& row : plan.rows) row = {.planes = row.planes};
      plan.lines_layers = plan.blur_layers = plan.whole_layers = plan.gates = 0;
    }
    FL_TRY(make_gobo_tables(device, compiled, plan, r));
  }
  diagnostics.finish();
  r.diagnostics = diagnostics.take();
  return r;
}

Result<PictureImages> PictureImages::create(vk::Device& device, const fixtures::Needs& needs,
                                            const FrameSettings& settings, std::uint32_t mask_words,
                                            std::uint32_t laser_rows) {
  const bool bodies = render::has_bodies(needs, settings);
  const bool classes = has_tile_classes(needs, settings);
  const auto width = static_cast<std::uint32_t>(settings.width);
  const auto height = static_cast<std::uint32_t>(settings.height);
  PictureImages p;
  p.supertiles_x = supertiles(settings.width);
  p.supertiles_y = supertiles(settings.height);
  FL_ASSIGN(p.masks, zeroed(device, mask_bytes(settings, mask_words)));
  const std::uint64_t laser_bytes = laser_mask_bytes(settings, laser_rows);
  if (laser_bytes > device.limits().maxStorageBufferRange) {
    return fail(ErrorCode::kUnsupported,
                "{}: maxStorageBufferRange is {}, needed: {} bytes for the masks of lasers; use figures with fewer "
                "points or a smaller picture",
                device.name(), device.limits().maxStorageBufferRange, laser_bytes);
  }
  FL_ASSIGN(p.laser_masks, zeroed(device, laser_bytes));
  // Rows without room are drawn tile by tile.
  const std::uint64_t strips = laser_strip_bytes(settings, laser_rows) / sizeof(LaserStripRow);
  const std::uint64_t most = device.limits().maxStorageBufferRange / sizeof(LaserStripRow);
  FL_ASSIGN(p.laser_strips, zeroed(device, std::min(strips, most) * sizeof(LaserStripRow)));
  FL_ASSIGN(p.laser_lists, zeroed(device, laser_list_bytes(settings, laser_rows)));
  FL_ASSIGN(p.display_tiles, zeroed(device, display_tile_bytes(needs, settings)));
  FL_ASSIGN(p.display_records,
            zeroed(device, display_record_bytes(needs, settings), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
  FL_ASSIGN(p.tile_depths, zeroed(device, tile_depth_bytes(settings, has_tile_depths(needs, settings))));
  const std::uint64_t fine_bytes = fine_mask_bytes(settings, mask_words, classes);
  const std::uint64_t shade_bytes =
      shade_word_bytes(settings, mask_words, has_shadows_in_air(needs, settings) && classes);
  if (std::max(fine_bytes, shade_bytes) > device.limits().maxStorageBufferRange) {
    return fail(ErrorCode::kUnsupported,
                "{}: maxStorageBufferRange is {}, needed: {} bytes for the masks of tiles; use --tile-error 0 or a "
                "smaller picture",
                device.name(), device.limits().maxStorageBufferRange, std::max(fine_bytes, shade_bytes));
  }
  const bool shadows = has_shadows_in_air(needs, settings);
  FL_ASSIGN(p.shadow_words, zeroed(device, shadow_word_bytes(settings, mask_words, shadows)));
  // With less room no list may be read, which is slow; nothing is lost.
  const std::uint64_t pick_bytes =
      shadow_pick_bytes(settings, mask_words, shadows && shadow_map_px(needs, settings) == 0);
  FL_ASSIGN(p.shadow_picks, zeroed(device, std::min<std::uint64_t>(pick_bytes, device.limits().maxStorageBufferRange)));
  FL_ASSIGN(p.shade_words, zeroed(device, shade_bytes));
  FL_ASSIGN(p.fine_masks, zeroed(device, fine_bytes));
  FL_ASSIGN(p.coarse, zeroed(device, coarse_bytes(settings, classes)));
  p.rims_max = record_rows(kRims, settings, mask_words, classes);
  p.cuts_max = record_rows(kCuts, settings, mask_words, classes);
  FL_ASSIGN(p.rims, zeroed(device, record_bytes(kRims, settings, p.rims_max)));
  FL_ASSIGN(p.cuts, zeroed(device, record_bytes(kCuts, settings, p.cuts_max)));
  FL_ASSIGN(p.pixel_depths, zeroed(device, computed_bytes(needs, settings)));
  FL_ASSIGN(p.pixel_boxes, zeroed(device, pixel_box_bytes(needs, settings)));
  FL_ASSIGN(p.pixel_keys, zeroed(device, pixel_key_bytes(needs, settings)));
  FL_ASSIGN(p.draw_blocks, zeroed(device, draw_block_bytes(needs, settings), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
  FL_ASSIGN(p.edge_ids, zeroed(device, edge_id_bytes(needs, settings)));
  FL_ASSIGN(p.edge_samples, zeroed(device, edge_sample_bytes(needs, settings)));
  const std::uint32_t solid_width = bodies ? width : 1;
  const std::uint32_t solid_height = bodies ? height : 1;
  FL_ASSIGN(p.surface_id, vk::Image::create(device, solid_width, solid_height, VK_FORMAT_R32G32_UINT,
                                            VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_STORAGE_BIT));
  const bool computed = has_computed_triangles(needs, settings);
  FL_ASSIGN(p.depth, vk::Image::create(device, computed ? 1 : solid_width, computed ? 1 : solid_height,
                                       VK_FORMAT_D32_SFLOAT,
                                       VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT));
  const bool edges = has_smooth_edges(needs, settings);
  FL_ASSIGN(p.edge_masks, zeroed(device, edge_mask_bytes(needs, settings)));
  FL_ASSIGN(p.edge_parts, zeroed(device, edge_part_bytes(needs, settings), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
  FL_ASSIGN(p.edges, vk::Image::create(device, edges ? width : 1, edges ? height : 1, VK_FORMAT_R32G32B32A32_SFLOAT,
                                       VK_IMAGE_USAGE_STORAGE_BIT));
  FL_ASSIGN(p.blurs, zeroed(device, blur_tile_bytes(needs, settings)));
  if (has_depth_of_field(needs, settings)) {
    FL_ASSIGN(p.blurred, vk::Image::create(device, width, height, VK_FORMAT_R32G32B32A32_SFLOAT,
                                           VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT));
  }
  if (has_glare(needs, settings)) {
    FL_ASSIGN(p.glare, make_glare_image(device, glare_shape(settings)));
  }
  if (has_gloss(needs, settings)) {
    FL_ASSIGN(p.mirror, make_mirror_image(device, mirror_shape(settings)));
  }
  constexpr VkImageUsageFlags kPicture =
      VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  FL_ASSIGN(p.radiance, vk::Image::create(device, width, height, VK_FORMAT_R32G32B32A32_SFLOAT, kPicture));
  const auto side = static_cast<std::uint32_t>(settings.supersample);
  FL_ASSIGN(p.screen, vk::Image::create(device, width / side, height / side, VK_FORMAT_R8G8B8A8_UNORM, kPicture));
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    for (const vk::Image* image : {&p.surface_id, &p.depth, &p.edges, &p.radiance, &p.screen}) {
      vk::change_layout(commands, *image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    }
    if (p.blurred.handle != VK_NULL_HANDLE) {
      vk::change_layout(commands, p.blurred, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    }
    const VkClearColorValue black{{0, 0, 0, 1}};  // opaque: what a picture without a pass shows
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(commands, p.radiance.handle, VK_IMAGE_LAYOUT_GENERAL, &black, 1, &range);
    vkCmdClearColorImage(commands, p.screen.handle, VK_IMAGE_LAYOUT_GENERAL, &black, 1, &range);
  }));
  return p;
}

void Resources::bind_all() {
  bindings = {};
  total_bytes = 0;
  const auto bind = [&](std::uint32_t binding, const vk::Buffer& buffer) {
    if (buffer.handle == VK_NULL_HANDLE) return;
    bindings.set_buffer(binding, buffer);
    total_bytes += buffer.size_bytes;
  };
  for (const TableEntry& entry : kTables) bind(entry.binding, rig.*entry.buffer);
  for (std::uint32_t lamp = 1; lamp <= FL_LAMP_COUNT; ++lamp) bind(FL_BINDING_LAMP(lamp), rig.lamp_states[lamp]);
  for (const auto& [binding, buffer] : kOtherBuffers) bind(binding, rig.*buffer);
  std::uint64_t rig_bytes = total_bytes;
  bind(FL_BINDING_MASKS, picture.masks);
  bind(FL_BINDING_LASER_MASKS, picture.laser_masks);
  bind(FL_BINDING_LASER_STRIPS, picture.laser_strips);
  bind(FL_BINDING_LASER_LISTS, picture.laser_lists);
  bind(FL_BINDING_DISPLAY_TILES, picture.display_tiles);
  bind(FL_BINDING_DISPLAY_RECORDS, picture.display_records);
  bind(FL_BINDING_TILE_DEPTHS, picture.tile_depths);
  bind(FL_BINDING_COARSE, picture.coarse);
  bind(FL_BINDING_RIMS, picture.rims);
  bind(FL_BINDING_CUTS, picture.cuts);
  bind(FL_BINDING_SHADOW_WORDS, picture.shadow_words);
  bind(FL_BINDING_SHADOW_PICKS, picture.shadow_picks);
  bind(FL_BINDING_SHADE_WORDS, picture.shade_words);
  bind(FL_BINDING_FINE_MASKS, picture.fine_masks);
  bind(FL_BINDING_PIXEL_DEPTHS, picture.pixel_depths);
  bind(FL_BINDING_PIXEL_BOXES, picture.pixel_boxes);
  bind(FL_BINDING_PIXEL_KEYS, picture.pixel_keys);
  bind(FL_BINDING_DRAW_BLOCKS, picture.draw_blocks);
  bind(FL_BINDING_EDGE_MASKS, picture.edge_masks);
  bind(FL_BINDING_EDGE_PARTS, picture.edge_parts);
  bind(FL_BINDING_EDGE_IDS, picture.edge_ids);
  bind(FL_BINDING_EDGE_SAMPLES, picture.edge_samples);
  bind(FL_BINDING_BLURS, picture.blurs);
  if (rig.gobos.handle != VK_NULL_HANDLE) {
    bindings.set_image(FL_BINDING_GOBOS, rig.gobos, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }
  if (rig.gobo_whole.handle != VK_NULL_HANDLE) {
    bindings.set_image(FL_BINDING_GOBO_WHOLE, rig.gobo_whole);
    bindings.set_image(FL_BINDING_GOBO_WHOLE_OUT, rig.gobo_whole);
    bindings.set_image(FL_BINDING_GOBO_LINES, rig.gobo_lines);
    bindings.set_image(FL_BINDING_GOBO_LINES_OUT, rig.gobo_lines);
    bindings.set_image(FL_BINDING_GOBO_BLURS, rig.gobo_blurs);
    bindings.set_image(FL_BINDING_GOBO_BLURS_OUT, rig.gobo_blurs);
    bindings.set_image(FL_BINDING_GATE_IMAGES, rig.gate_images);
    bindings.set_image(FL_BINDING_GATE_IMAGES_OUT, rig.gate_images);
  }
  if (rig.haze_table.handle != VK_NULL_HANDLE) {
    bindings.set_image(FL_BINDING_HAZE_TABLE, rig.haze_table);
    bindings.set_image(FL_BINDING_HAZE_TABLE_OUT, rig.haze_table);
  }
  bindings.set_image(FL_BINDING_SURFACE_ID, picture.surface_id);
  bindings.set_image(FL_BINDING_DEPTH, picture.depth);
  bindings.set_image(FL_BINDING_EDGES, picture.edges);
  bindings.set_image(FL_BINDING_RADIANCE, picture.radiance);
  if (picture.blurred.handle != VK_NULL_HANDLE) bindings.set_image(FL_BINDING_BLURRED, picture.blurred);
  if (picture.glare.handle != VK_NULL_HANDLE) bindings.set_image(FL_BINDING_GLARE, picture.glare);
  if (picture.mirror.handle != VK_NULL_HANDLE) bindings.set_image(FL_BINDING_MIRROR, picture.mirror);
  bindings.set_image(FL_BINDING_SCREEN, picture.screen);
  for (const vk::Image* image :
       {&rig.gobos, &rig.gobo_whole, &rig.gobo_lines, &rig.gobo_blurs, &rig.gate_images, &rig.haze_table,
        &picture.surface_id,
        &picture.depth, &picture.edges, &picture.blurred, &picture.glare, &picture.mirror, &picture.radiance,
        &picture.screen}) {
    total_bytes += image->size_bytes;
  }
  for (const vk::Image* image : {&rig.gobos, &rig.gobo_whole, &rig.gobo_lines, &rig.gobo_blurs, &rig.gate_images,
                                 &rig.haze_table}) {
    rig_bytes += image->size_bytes;
  }
  picture_bytes = total_bytes - rig_bytes;
}

std::uint64_t Resources::body_bytes() const {
  if (!rig.has_bodies) return 0;
  std::uint64_t bytes = picture.surface_id.size_bytes + picture.depth.size_bytes;
  const vk::Buffer* const buffers[] = {
      &rig.slots,   &rig.meshes, &rig.body_boxes, &rig.body_levels,   &rig.vertices,
      &rig.indices, &rig.draws,  &rig.choices,    &rig.drawn, &picture.pixel_depths, &picture.pixel_keys,
      &picture.draw_blocks, &rig.body_spaces, &rig.body_rounds, &rig.object_shells, &rig.textures,
      &rig.texture_texels, &rig.object_uvs};
  for (const vk::Buffer* buffer : buffers) bytes += buffer->size_bytes;
  return bytes;
}

void forget_states(VkCommandBuffer commands, const Resources& resources) {
  vk::full_barrier(commands);
  for (const vk::Buffer* buffer : resources.rig.all_states()) {
    if (buffer->handle != VK_NULL_HANDLE) vkCmdFillBuffer(commands, buffer->handle, 0, VK_WHOLE_SIZE, 0);
  }
  vk::full_barrier(commands);
}

}  // namespace footlight::render

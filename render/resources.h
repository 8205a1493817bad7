// The buffers and images that the passes of a frame share, in two owners: what follows from the rig, and what follows
// from the size of the picture. What no pass in use reads is not allocated.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "fixtures/model/diagnostic.h"
#include "fixtures/model/rig.h"
#include "render/frame_io.h"
#include "render/image.h"
#include "render/settings.h"
#include "render/vk/memory.h"
#include "render/vk/pipeline.h"

namespace footlight::render {

constexpr VkDeviceSize kUpdateBytesMax = 65536;  // of one vkCmdUpdateBuffer

// Everything that memory follows from.
struct MemoryShape {
  const fixtures::Rig& rig;
  const fixtures::CompiledRig& compiled;
  fixtures::Needs needs;
  FrameSettings settings;
};

// Bytes of the buffer or image at a binding; of an image, those of its texels. 0 for the meshes of bodies, whose length
// is known when the models are read.
[[nodiscard]] std::uint64_t binding_bytes(std::uint32_t binding, const MemoryShape& shape);

// Workgroups that compute the cells of displays: rows of the DisplayJobRow table, one range a level, the lowest first.
struct DisplayJobRange {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};
using DisplayJobs = std::vector<DisplayJobRange>;

// The push constants of displayposes.comp: a display behind a joint of a head, or with its light.
struct DisplayMove {
  float middle_m[3];  // in the space behind the joint
  float right[3];     // unit
  float up[3];        // unit
  std::uint32_t display;
  std::uint32_t head;
  std::uint32_t depth;  // joints before it; 0: it stands
  float light[3];       // cd/m^2 where the head's light is 1
  std::uint32_t lit;    // 0: its light is not the head's
};
static_assert(sizeof(DisplayMove) == 64);

// A disco ball of VR Stage Lighting, whose spots its style draws by other formulas.
struct DiscoBall {
  std::uint32_t head_first = 0;  // heads of its spots
  std::uint32_t head_count = 0;
  float spot_cd = 0;  // mean luminous intensity of a spot
};
[[nodiscard]] std::vector<DiscoBall> disco_balls(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);

// Tables, models, gobo images and states of a rig. Made once; reading models and images is slow.
struct RigTables {
  // `used`: the bindings of all passes that may be in use; the others are not allocated.
  [[nodiscard]] static Result<RigTables> create(vk::Device& device, const MemoryShape& shape,
                                                const std::vector<bool>& used);

  // Written once. Rows of fixtures/shared/tables.h.
  vk::Buffer types, channels, functions, masters, motors, spins, joints, wheels, wheel_slots, facets, lights, defaults,
      colors, heads;
  vk::Buffer boxes;  // BoxRow
  // Bodies: BodySlotRow, BodyMeshRow, BodyLevelRow, BodyVertexRow; one draw command a level, and one for all objects of
  // the scene, whose vertices and indices are behind those of the bodies.
  vk::Buffer slots, meshes, body_levels, vertices, indices, draws;
  vk::Buffer occluders;   // OccluderRow: those that do not move, then FL_BODY_BOXES of each body
  vk::Buffer body_boxes;  // BodyBoxRow, FL_BODY_BOXES a mesh
  vk::Image gobos;        // one layer a gobo
  int gobo_px = 1;        // a side of them
  // Tables of gobos in haze, filled as lit beams show them: GoboTableRow, GoboQueue, and the kinds of tables.
  vk::Buffer gobo_tables, gobo_queue;
  vk::Image gobo_whole, gobo_lines, gobo_blurs;
  // Gates (render/shaders/gates.comp): GatesHead with GateRow, and their images.
  vk::Buffer gates;
  vk::Image gate_images;

  // Per frame.
  vk::Buffer params;         // FrameParams
  vk::Buffer lenses;         // LensesHead, then LensRow, one a head
  vk::Buffer meter;          // MeterRow; its luminance is carried from frame to frame
  vk::Buffer levels;         // universes x 512 bytes
  vk::Buffer staged_levels;  // the same, where the host writes them; only for more than kUpdateBytesMax
  vk::Buffer beams;          // BeamRow, live ones first
  vk::Buffer blades;         // BladesRow, one a beam
  vk::Buffer laser_segments;  // LaserSegmentRow
  vk::Buffer lasers;          // LaserRow
  vk::Buffer mirror_balls, mirror_pairs, mirror_normals, mirror_picks;  // mirrors.comp
  vk::Buffer panes, pane_texels;  // PaneRow; two words of half floats a texel
  vk::Buffer pane_masks;          // bits of the occluders that reach into each shaft, or into those of each group
  vk::Buffer pane_groups, group_panes, pane_grids;  // PaneGroupRow, GroupPaneRow, words
  vk::Buffer pane_fans, pane_lines;                 // PaneFansRow; sums of the glass along lines
  vk::Buffer displays, display_levels, display_jobs;  // DisplayRow, DisplayLevelRow, DisplayJobRow
  vk::Buffer display_pixels;                          // of displays, three floats each
  vk::Buffer display_cells;                           // those of displays that are stored, on all their levels
  vk::Buffer gloss;          // GlossRow
  vk::Buffer textures, texture_texels, object_uvs;  // texture_tables.h
  vk::Buffer sheens;                                // SheenRow
  vk::Buffer shadow_lists;   // ShadowListRow, one a beam
  vk::Buffer shadows;        // ShadowRow
  vk::Buffer shadow_maps;    // lib/shadow_map.glsl
  // Light that surfaces reflect (render/bounce_tables.h). The forms are computed by the first frame that reads them.
  vk::Buffer bounce_solids, bounce_tree, bounce_patch_rows, bounce_grid, bounce_forms, bounce_flux, bounce_light;
  vk::Buffer probes, probe_light;  // render/probe_tables.h
  vk::Buffer haze;               // HazeField
  vk::Image haze_table;          // of haze that is not even; a texel where it is even
  vk::Buffer body_spaces, body_rounds;  // BodySpaceRow; BodyRoundsHead, then BodyRoundRow
  vk::Buffer object_shells;             // ObjectShellsRow
  vk::Buffer choices, drawn;     // one word a body: its level; heads that the rasteriser draws, by mesh and level
  vk::Buffer counts;             // CountsRow, then beams and lit heads of each group of FL_GROUP_HEADS

  // Carried from frame to frame: HeadState, and Motor, Spin, Shutter, OpticsState, Filament, Led, Discharge, Slew,
  // Flex and Smooth for what has a motor, spins, strobes, shapes its beam, glows, has a driver, an arc or a dowser,
  // hangs on a motor, is smoothed. `counts` goes with them: the step pass leaves the lit heads of each group in it.
  vk::Buffer states, motor_states, spin_states, shutter_states, optics_states, dowser_states, smooth_states,
      laser_states;
  std::array<vk::Buffer, FL_LAMP_COUNT + 1> lamp_states;  // by kLamp...; the first stays empty
  [[nodiscard]] std::vector<const vk::Buffer*> all_states() const {
    std::vector<const vk::Buffer*> all = {&states,        &motor_states,  &spin_states,   &shutter_states,
                                          &optics_states, &dowser_states, &smooth_states, &laser_states, &counts};
    for (std::size_t lamp = 1; lamp < lamp_states.size(); ++lamp) all.push_back(&lamp_states[lamp]);
    return all;
  }

  std::uint32_t head_count = 0;
  std::uint32_t head_groups = 0;
  std::uint32_t motor_count = 0;  // states of all heads; 0: the rig has none of these
  std::uint32_t spin_count = 0;
  std::uint32_t shutter_count = 0;
  std::uint32_t optics_count = 0;
  std::array<std::uint32_t, FL_LAMP_COUNT + 1> lamp_counts{};
  std::uint32_t dowser_count = 0;
  std::uint32_t smooth_count = 0;  // Flexes, then Smooths
  std::uint32_t laser_count = 0;
  std::uint32_t laser_rows = 0;
  std::uint32_t mirror_pair_count = 0;
  std::uint32_t pane_count = 0;
  std::uint32_t pane_group_count = 0;
  std::uint32_t pane_lines_most = 0;  // of a group
  std::uint32_t gloss_count = 0;
  std::uint32_t occluder_words = 0;  // of a pane's bits
  std::vector<DisplayMove> display_moves;  // of displays that pan and tilt, and of tubes: each picture
  std::vector<DiscoBall> disco_balls;
  DisplayJobs display_still;         // of images: once
  DisplayJobs display_live;          // of pixel maps: each frame
  DisplayJobs display_film;          // of films: with new pixels (render/display_films.h)
  bool display_cells_fresh = false;  // those of this frame are computed
  bool display_films_new = false;    // there are some that the pass of displays has not seen
  std::uint32_t beams_max = 0;
  GoboQueue gobo_queue_empty{};  // as a frame begins
  std::uint32_t box_count = 0;
  std::uint32_t slot_count = 0;         // bodies
  std::uint32_t mesh_count = 0;         // of bodies
  std::uint32_t draw_count = 0;         // of bodies: levels of all meshes
  std::uint32_t object_draw_count = 0;  // of the scene's objects, behind them: 0 or 1
  std::uint32_t texture_count = 0;      // of objects: those with textures or sheen
  std::uint32_t sheen_count = 0;        // materials with sheen
  std::uint32_t mask_words = 0;
  std::uint64_t levels_bytes = 0;
  bool has_bodies = false;        // the models were read
  bool has_shadows = false;       // there is what shadows of beams need
  std::uint32_t shadow_map_px = 0;  // texels a side of shadow maps; 0: shadows are cut exactly
  std::uint32_t lens_points = 1;    // most points of a lens from which exact shadows have room
  bool has_occluders = false;     // it is known what hides light
  bool has_bounce = false;        // there is what reflected light needs
  bool has_bounce_forms = false;  // they were computed
  std::uint32_t bounce_patches = 0;
  std::uint32_t bounce_probes = 0;
  bool has_probes = false;         // there is what reflection probes need
  std::uint32_t probe_count = 0;
  std::uint32_t probe_next = 0;    // texel of each probe, in their order, that is computed next
  bool has_probe_light = false;    // all texels were computed once
  std::vector<std::uint32_t> level_triangles;  // of each BodyLevelRow
  std::uint64_t body_triangles = 0;            // of the whole meshes of all bodies
  std::uint64_t object_triangles = 0;
  Extent objects;  // what the scene's objects fill
  // Models that were not there or not readable, and what stands in for them.
  std::vector<fixtures::Diagnostic> diagnostics;
};

// What is as large as the picture. Without bodies there is no visibility buffer: one texel stands in for each of its
// two images, since shaders name them.
struct PictureImages {
  [[nodiscard]] static Result<PictureImages> create(vk::Device& device, const fixtures::Needs& needs,
                                                    const FrameSettings& settings, std::uint32_t mask_words,
                                                    std::uint32_t laser_rows);

  vk::Buffer masks;                     // supertiles x mask_words
  vk::Buffer laser_masks;               // supertiles x words of the lasers' rows; one word without lasers
  vk::Buffer laser_strips;              // LaserStripRow, FL_LASER_STRIPS a supertile in the mean; one without lasers
  vk::Buffer laser_lists;               // LaserListRow, one a supertile; one without lasers
  vk::Buffer display_tiles;             // DisplayTileRow, one a tile; one without displays
  vk::Buffer display_records;           // DisplayListsHead, then DisplayRecordRow
  vk::Buffer tile_depths;               // TileDepthRow, one a tile; one row where no pass reads them
  vk::Buffer coarse;                    // CoarseRow, one a supertile; likewise
  vk::Buffer rims, cuts;                // RimRow and CutRow, rims_max and cuts_max a supertile; likewise
  vk::Buffer shadow_words;              // ShadowWordRow, one a word of the masks
  vk::Buffer shadow_picks;              // lists of shadows by supertile (lib/shadow_picks.glsl)
  vk::Buffer shade_words;               // ShadowWordRow, one a word of fine_masks
  vk::Buffer fine_masks;                // masks of FL_FINE_PX x FL_FINE_PX pixels; likewise
  vk::Buffer pixel_depths, pixel_keys;  // of triangles that compute shaders draw, a word a pixel; likewise
  vk::Buffer pixel_boxes;               // which box a pixel shows; one word without boxes
  vk::Buffer draw_blocks;               // DrawBlocksHead, then DrawBlockRow
  vk::Buffer edge_ids;                  // two words a pixel; likewise
  vk::Buffer edge_samples;              // FrameSettings::edge_samples for edge_room() pixels; likewise
  vk::Buffer edge_masks;                // FL_EDGE_WORDS a tile; likewise
  vk::Buffer edge_parts;                // EdgePartRow, one a row of tiles; likewise
  vk::Image edges;                      // colours of pixels with edges; likewise
  vk::Image blurred;                    // by depth of field; none without it
  vk::Buffer blurs;                     // of each tile
  vk::Image glare;                      // GlareShape (render/glare.h); none without glare
  vk::Image mirror;                     // MirrorShape (render/mirror.h); none where nothing mirrors
  vk::Image surface_id, depth, radiance, screen;
  std::uint32_t supertiles_x = 0;
  std::uint32_t supertiles_y = 0;
  std::uint32_t rims_max = 0;
  std::uint32_t cuts_max = 0;
};

struct Resources {
  RigTables& rig;  // those of several pictures of a frame are the same
  PictureImages picture;
  vk::BindingTable bindings;
  std::uint64_t total_bytes = 0;  // GPU memory, for the report
  std::uint64_t picture_bytes = 0;  // of them those of `picture`

  // Enters what both owners have into `bindings` and counts the bytes.
  void bind_all();
  // GPU memory of bodies and objects: their meshes, and the visibility buffer.
  [[nodiscard]] std::uint64_t body_bytes() const;
};

// Gobo images: texels a side, and the width of their edges in units of the gate's radius. Edges are three texels of the
// smaller size wide, so that interpolation between texels follows them.
inline constexpr int kGoboSizePx = 512;
inline constexpr int kGoboFineSizePx = 1024;
inline constexpr double kGoboEdge = 3.0 * 2.0 / kGoboSizePx;
// GPU memory up to which images have the larger size: 24 or fewer of them. A CPU has the smaller one, as it makes them
// and reads them slowly.
inline constexpr std::uint64_t kGoboFineBytesMax = std::uint64_t{128} << 20;
[[nodiscard]] int gobo_size_px(const FrameSettings& settings, std::size_t images, bool cpu);

// Bytes on the GPU of a HeadState, a Motor, a Spin, a Shutter, an OpticsState and so on.
inline constexpr std::uint64_t kStateBytes = 48;
inline constexpr std::uint64_t kMotorStateBytes = 32;
inline constexpr std::uint64_t kSpinStateBytes = 40;
inline constexpr std::uint64_t kShutterStateBytes = 32;
inline constexpr std::uint64_t kOpticsStateBytes = 116;
inline constexpr std::uint64_t kLampStateBytes = 32;  // of every kind
inline constexpr std::uint64_t kDowserStateBytes = 24;
inline constexpr std::uint64_t kSmoothStateBytes = 32;
inline constexpr std::uint64_t kLaserStateBytes = 64;

// Records that the heads begin anew, as if no step had been, with the barriers that this needs.
void forget_states(VkCommandBuffer commands, const Resources& resources);

}  // namespace footlight::render

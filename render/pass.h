// One pass of the frame.
//
// A pass is one pair of files in render/passes/, its shaders in render/shaders/, and one line in the list of
// render/frame.cpp. Passes meet only through the buffers and images of Resources, never through each other.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "render/resources.h"
#include "render/settings.h"
#include "render/shaders/shared/shadow_map.h"
#include "render/vk/pipeline.h"

namespace footlight::render {

// Recorded once a frame, in the order of the list. Each record() may rely on everything before it being finished.
// `push`: the push constants of its shaders; empty for all passes but step.
class Pass {
 public:
  virtual ~Pass() = default;
  virtual void record(VkCommandBuffer commands, std::span<const std::byte> push) = 0;
  // GPU memory of buffers and images that are not in Resources.
  [[nodiscard]] virtual std::uint64_t own_bytes() const { return 0; }
};

struct PassContext {
  vk::Device& device;
  Resources& resources;
  const FrameSettings& settings;
  std::vector<vk::SpecConstant> constants;  // the result of PassEntry::constants
  bool only_pipelines = false;              // create() is to begin these; resources are empty, and no pass is used
};

// Whether a constant is set that only selects a shader.
[[nodiscard]] inline bool has_constant(const PassContext& context, std::uint32_t id) {
  return std::find(context.constants.begin(), context.constants.end(), vk::SpecConstant{id, 1}) !=
         context.constants.end();
}

// What the light of beams needs, for passes that add it up at places that are no pixels.
[[nodiscard]] inline std::vector<vk::SpecConstant> beam_light_constants(const fixtures::Needs& needs) {
  return {{FL_SPEC_GOBO, needs.gobo},         {FL_SPEC_EXTINCTION, needs.extinction},
          {FL_SPEC_PROFILE, needs.profile},   {FL_SPEC_BLADES, needs.blades},
          {FL_SPEC_FOCUS, needs.focus},       {FL_SPEC_ANIMATION, needs.animation},
          {FL_SPEC_MEASURED, needs.measured}, {FL_SPEC_RECTANGLE, needs.rectangle},
          {FL_SPEC_WIDE, needs.wide},         {FL_SPEC_IRIS, needs.iris}};
}

// The constants of a pass that reads the table of haze. With plumes that has slopes, and the pass a constant more.
[[nodiscard]] inline std::vector<vk::SpecConstant> with_plumes(bool plumes, std::vector<vk::SpecConstant> constants) {
  if (plumes) constants.push_back({FL_SPEC_PLUMES, 1});
  return constants;
}

// An entry in the list of the frame. needed() and constants() are pure: tests call them without a device.
struct PassEntry {
  const char* name;
  bool (*needed)(const fixtures::Needs& needs, const FrameSettings& settings);
  std::vector<vk::SpecConstant> (*constants)(const fixtures::Needs& needs, const FrameSettings& settings);
  Result<std::unique_ptr<Pass>> (*create)(const PassContext& context);
  std::vector<std::vector<vk::Spirv>> (*shaders)();  // the stages of each of its pipelines
  const char* loss;                                  // what the picture loses without it, for the report
  // Bindings that it writes as attachments, so that its shaders do not declare them; null: none.
  std::vector<std::uint32_t> (*attachments)() = nullptr;
  // Recorded once, before the picture of a mirrored camera (render/mirror.h): it is the same for all cameras, or
  // eyes.comp brings what it wrote to another one.
  bool before_views = false;
};

// Whether triangles are drawn: bodies of fixtures, objects of the scene.
[[nodiscard]] inline bool has_bodies(const fixtures::Needs& needs, const FrameSettings& settings) {
  return (needs.fixtures || needs.objects) && settings.bodies;
}
// Whether light in the air is drawn.
[[nodiscard]] inline bool has_air(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.fixtures && needs.haze && settings.view != FrameView::kLux;
}
// Whether a table has the haze that rays pass through: clouds of it, or plumes of machines.
[[nodiscard]] inline bool uneven_haze(const fixtures::Needs& needs) { return needs.haze_field || needs.plumes; }
// Whether haze is not even.
[[nodiscard]] inline bool has_haze_field(const fixtures::Needs& needs, const FrameSettings& settings) {
  const bool others = (needs.panes || needs.displays) && needs.haze && settings.view == FrameView::kPicture;
  return (has_air(needs, settings) || others) && uneven_haze(needs);
}
// Whether triangles are drawn by compute shaders. Before Frame::suited() has chosen: they may be.
[[nodiscard]] inline bool has_computed_triangles(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_bodies(needs, settings) && settings.triangles != TriangleMethod::kRasteriser;
}
// Whether these keep a pixel's depth and triangle in one word of 64 bits, and draw in one round. Likewise.
[[nodiscard]] inline bool has_joined_words(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_computed_triangles(needs, settings) && settings.triangles != TriangleMethod::kTwoRounds;
}
// Pixels with an edge that have room for samples at a time: at least those of a row of tiles.
[[nodiscard]] inline std::uint32_t edge_room(const FrameSettings& settings) {
  const int row = settings.width * FL_TILE_PX;
  const int rows = (settings.height + FL_TILE_PX - 1) / FL_TILE_PX;
  const int most = std::min(rows * row, 1 << FL_EDGE_SLOT_BITS);
  return static_cast<std::uint32_t>(std::clamp(settings.edge_pixels, row, most));
}
// Parts of a picture, each of which has room for the samples of its pixels with an edge, if all have one.
[[nodiscard]] inline std::uint32_t edge_part_count(const FrameSettings& settings) {
  const std::uint32_t rows_of_tiles = edge_room(settings) / static_cast<std::uint32_t>(settings.width * FL_TILE_PX);
  const auto rows = static_cast<std::uint32_t>((settings.height + FL_TILE_PX - 1) / FL_TILE_PX);
  return (rows + rows_of_tiles - 1) / rows_of_tiles;
}
// Whether beams are taken together for tiles, where they are smooth. A rig that never has enough of them lit goes
// without.
[[nodiscard]] inline bool has_tile_classes(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_air(needs, settings) && settings.method == BeamMethod::kGauss && settings.tile_error > 0 &&
         needs.beams_max >= settings.tile_beams;
}
// Whether gobos in the air have tables.
[[nodiscard]] inline bool has_gobo_tables(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.fixtures && needs.haze && needs.gobo && settings.method == BeamMethod::kGauss &&
         (settings.gobo_method == GoboMethod::kTables || settings.gobo_method == GoboMethod::kSuited);
}
// Whether anything solid is in the picture.
[[nodiscard]] inline bool has_solids(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.surfaces || has_bodies(needs, settings);
}
// Whether anything hides light of a beam.
[[nodiscard]] inline bool has_shadows(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.fixtures && settings.shadows && has_solids(needs, settings);
}
// Texels a side of shadow maps; 0: there are none.
[[nodiscard]] inline std::uint32_t shadow_map_px(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_shadows(needs, settings) && settings.shadow_map_px != kShadowsSuited ? settings.shadow_map_px : 0;
}
// Points of a lens from which exact shadows are cast; 1 where maps stand for them.
[[nodiscard]] inline std::uint32_t lens_points(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_shadows(needs, settings) && shadow_map_px(needs, settings) == 0 ? settings.penumbra : 1;
}
// Whether anything hides light in the air.
[[nodiscard]] inline bool has_shadows_in_air(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_shadows(needs, settings) && has_air(needs, settings);
}
// Whether the sun shines through panes.
[[nodiscard]] inline bool has_shafts(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.panes && settings.view != FrameView::kClasses;
}
// Whether their light in the air is drawn.
[[nodiscard]] inline bool has_shafts_in_air(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_shafts(needs, settings) && needs.haze && settings.view != FrameView::kLux;
}
// Whether light of the sun in the air is read from sums along lines of the glass; in clouds of haze it is not.
[[nodiscard]] inline bool has_pane_sums(const fixtures::Needs& needs) { return needs.haze && !uneven_haze(needs); }
// Whether anything hides light of the sun.
[[nodiscard]] inline bool has_shafts_shadowed(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_shafts(needs, settings) && settings.shadows && has_solids(needs, settings);
}
// Whether there are displays; a picture of steps has none.
[[nodiscard]] inline bool has_displays(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.displays && (settings.view == FrameView::kPicture || settings.view == FrameView::kLux);
}
// Whether their light in the air is drawn.
[[nodiscard]] inline bool has_displays_in_air(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_displays(needs, settings) && needs.haze && settings.view == FrameView::kPicture;
}
// Whether their light is interpolated where it is smooth.
[[nodiscard]] inline bool has_display_records(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_displays(needs, settings) && settings.tile_error > 0;
}
// Whether displays that are thin in the picture are drawn by the share of pixels that they cover.
[[nodiscard]] inline bool has_strips(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_displays(needs, settings) && settings.widen_thin && settings.view == FrameView::kPicture;
}
// Whether it is known what hides light.
[[nodiscard]] inline bool has_occluders(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_shadows(needs, settings) || has_shafts_shadowed(needs, settings);
}
// Whether lasers are drawn. Frames that are compared with the judge of beams, which has no lasers, are drawn without.
[[nodiscard]] inline bool has_lasers(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.fixtures && needs.laser && settings.widen_thin && settings.view != FrameView::kClasses &&
         (has_air(needs, settings) || has_solids(needs, settings));
}
// Whether their light in the air is taken together for supertiles; clouds are not polynomials.
[[nodiscard]] inline bool has_laser_strips(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_lasers(needs, settings) && has_air(needs, settings) && !has_haze_field(needs, settings) &&
         settings.view == FrameView::kPicture && settings.tile_error > 0;
}
// Whether the distances of tiles are needed.
[[nodiscard]] inline bool has_tile_depths(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_solids(needs, settings) && (has_tile_classes(needs, settings) || has_shadows_in_air(needs, settings) ||
                                         has_laser_strips(needs, settings));
}
// Whether plain beams have a shader of their own in the air: where the one for all beams is longer, by shadows or by
// what stands in other beams. Shadows have to be rows of maps, or exact with as many nodes as agree with a polynomial.
[[nodiscard]] inline bool has_plain_beams(const fixtures::Needs& needs, const FrameSettings& settings) {
  if (!has_air(needs, settings) || uneven_haze(needs) || settings.method != BeamMethod::kGauss ||
      settings.view != FrameView::kPicture) {
    return false;
  }
  if (!has_shadows(needs, settings)) return needs.gobo || needs.blades || needs.rectangle || needs.measured;
  if (shadow_map_px(needs, settings) > 0) {
    return shadow_map_px(needs, settings) == FL_MAP_ROWS && settings.nodes <= FL_ROW_NODES_MAX;
  }
  return settings.penumbra == 1 && settings.nodes == FL_CUT_NODES;
}
// Whether solid things reflect light to others.
[[nodiscard]] inline bool has_bounce(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.fixtures && settings.bounce && settings.view != FrameView::kClasses &&
         (needs.surfaces || (needs.objects && settings.bodies));
}
// Whether surfaces with sheen mirror what reflection probes show. The light that these see comes from the bounce pass.
[[nodiscard]] inline bool has_probes(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.probes && settings.probes && has_bounce(needs, settings) && settings.view == FrameView::kPicture;
}
// Whether the edges of solid things are smoothed.
[[nodiscard]] inline bool has_smooth_edges(const fixtures::Needs& needs, const FrameSettings& settings) {
  return has_solids(needs, settings) && settings.edge_samples > 0 && settings.view == FrameView::kPicture;
}
// Whether small lenses are splats. Beams that are not widened are drawn as the judge sees them, and so are lenses.
[[nodiscard]] inline bool has_small_lenses(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.fixtures && settings.bodies && settings.widen_thin && settings.view == FrameView::kPicture;
}
// Whether floors mirror.
[[nodiscard]] inline bool has_gloss(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.gloss && settings.gloss_px > 0 && settings.view == FrameView::kPicture && has_solids(needs, settings);
}
// Whether surfaces have sheen.
[[nodiscard]] inline bool has_sheen(const fixtures::Needs& needs, const FrameSettings& settings) {
  return needs.sheen && has_solids(needs, settings);
}
// Whether what is out of the camera's focus is blurred.
[[nodiscard]] inline bool has_depth_of_field(const fixtures::Needs& needs, const FrameSettings& settings) {
  return settings.f_stop > 0 && settings.view == FrameView::kPicture &&
         has_solids(needs, settings);  // other light has no distance
}
// Whether the camera's lens scatters light.
[[nodiscard]] inline bool has_glare(const fixtures::Needs& needs, const FrameSettings& settings) {
  return settings.glare > 0 && settings.view == FrameView::kPicture &&
         (has_air(needs, settings) || needs.panes || needs.displays || has_solids(needs, settings));
}

}  // namespace footlight::render

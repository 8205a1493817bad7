#include "render/memory_groups.h"

#include <algorithm>
#include <initializer_list>

#include "render/frame.h"

namespace footlight::render {
namespace {

using Buffers = std::initializer_list<const vk::Buffer*>;
using Images = std::initializer_list<const vk::Image*>;

class Groups {
 public:
  // others: bytes of the group that are in none of these. Returns the bytes without them.
  std::uint64_t add(const char* name, Buffers buffers, Images images = {}, std::uint64_t others = 0) {
    std::uint64_t bytes = 0;
    for (const vk::Buffer* buffer : buffers) bytes += buffer->size_bytes;
    for (const vk::Image* image : images) bytes += image->size_bytes;
    add(name, bytes + others);
    return bytes;
  }
  void add(const char* name, std::uint64_t bytes) {
    if (bytes > 0) groups_.push_back({name, bytes});
  }
  [[nodiscard]] std::vector<MemoryGroup> take() { return std::move(groups_); }

 private:
  std::vector<MemoryGroup> groups_;
};

// Returns the bytes without those of the films.
std::uint64_t add_rig(const RigTables& rig, const DisplayFilms& films, Groups& groups) {
  std::uint64_t known =
      groups.add("tables of fixtures",
                 {&rig.types, &rig.channels, &rig.functions, &rig.masters, &rig.motors, &rig.spins, &rig.joints,
                  &rig.wheels, &rig.wheel_slots, &rig.facets, &rig.lights, &rig.defaults, &rig.colors, &rig.heads});
  std::uint64_t states = 0;
  for (const vk::Buffer* buffer : rig.all_states()) states += buffer->size_bytes;
  groups.add("states of heads", states);
  known += states;
  known += groups.add("bodies and scenery",
                      {&rig.boxes, &rig.slots, &rig.meshes, &rig.body_levels, &rig.vertices, &rig.indices, &rig.draws,
                       &rig.occluders, &rig.body_boxes, &rig.choices, &rig.drawn, &rig.body_spaces, &rig.body_rounds,
                       &rig.object_shells, &rig.textures, &rig.texture_texels, &rig.object_uvs});
  known += groups.add("gobos", {&rig.gobo_tables, &rig.gobo_queue, &rig.gates},
                      {&rig.gobos, &rig.gobo_whole, &rig.gobo_lines, &rig.gobo_blurs, &rig.gate_images},
                      films.projection_bytes());
  known += groups.add("beams", {&rig.beams, &rig.blades});
  known += groups.add("shadows", {&rig.shadow_lists, &rig.shadows, &rig.shadow_maps});
  known += groups.add("reflected light", {&rig.bounce_solids, &rig.bounce_tree, &rig.bounce_patch_rows,
                                          &rig.bounce_grid, &rig.bounce_forms, &rig.bounce_flux, &rig.bounce_light});
  known += groups.add("reflection probes", {&rig.probes, &rig.probe_light});
  known += groups.add("clouds of haze", {&rig.haze}, {&rig.haze_table});
  known += groups.add("lasers", {&rig.laser_segments, &rig.lasers});
  known += groups.add("mirror balls", {&rig.mirror_balls, &rig.mirror_pairs, &rig.mirror_normals, &rig.mirror_picks});
  known += groups.add("panes", {&rig.panes, &rig.pane_texels, &rig.pane_masks, &rig.pane_groups, &rig.group_panes,
                                &rig.pane_grids, &rig.pane_fans, &rig.pane_lines});
  known += groups.add("displays", {&rig.displays, &rig.display_levels, &rig.display_jobs, &rig.display_pixels,
                                   &rig.display_cells}, {}, films.display_bytes());
  return known;
}

std::uint64_t add_picture(const PictureImages& picture, Groups& groups) {
  std::uint64_t known = groups.add("light and screen", {}, {&picture.radiance, &picture.screen});
  known += groups.add("what a pixel shows",
                      {&picture.pixel_depths, &picture.pixel_keys, &picture.pixel_boxes, &picture.draw_blocks},
                      {&picture.surface_id, &picture.depth});
  known += groups.add("beams by tile", {&picture.masks, &picture.fine_masks, &picture.tile_depths, &picture.coarse,
                                        &picture.rims, &picture.cuts});
  known += groups.add("lasers by tile", {&picture.laser_masks, &picture.laser_strips, &picture.laser_lists});
  known += groups.add("displays by tile", {&picture.display_tiles, &picture.display_records});
  known += groups.add("shadows by tile", {&picture.shadow_words, &picture.shadow_picks, &picture.shade_words});
  known +=
      groups.add("smooth edges", {&picture.edge_masks, &picture.edge_parts, &picture.edge_ids, &picture.edge_samples},
                 {&picture.edges});
  known += groups.add("depth of field", {&picture.blurs}, {&picture.blurred});
  known += groups.add("glare", {}, {&picture.glare});
  known += groups.add("mirrored light", {}, {&picture.mirror});
  return known;
}

}  // namespace

std::vector<MemoryGroup> memory_groups(Frame& frame) {
  const Resources& resources = frame.resources();
  Groups groups;
  const DisplayFilms& films = frame.films();
  const std::uint64_t known = add_rig(resources.rig, films, groups) + add_picture(resources.picture, groups);
  // Buffers that have no group of their own, and are in the sum all the same.
  groups.add("parameters and others", resources.total_bytes - std::min(known, resources.total_bytes));
  const std::uint64_t others = resources.total_bytes + films.bytes();
  groups.add("mirrored picture, and of passes alone", frame.bytes() - std::min(others, frame.bytes()));
  std::vector<MemoryGroup> all = groups.take();
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.bytes > b.bytes; });
  return all;
}

}  // namespace footlight::render

// What a frame begins before it is needed, pipelines that other threads compile, and frames beside another one.
#include <algorithm>

#include "fixtures/simulate/machines.h"
#include "render/frame.h"
#include "render/shadow_tables.h"

namespace footlight::render {

FrameSettings Frame::suited(FrameSettings settings) const {
  const bool cpu = device_.is_software();
  if (settings.gobo_method == GoboMethod::kSuited) {
    settings.gobo_method = cpu ? GoboMethod::kTaps : GoboMethod::kTables;
  }
  if (settings.triangles == TriangleMethod::kSuited) {
    // A CPU draws the demo's bodies at 640 x 360 in half the time with its rasteriser, and thousands in the same time.
    settings.triangles = cpu ? TriangleMethod::kRasteriser : TriangleMethod::kCompute;
  }
  if (settings.triangles == TriangleMethod::kCompute && !vk::has_wide_atomics(device_.facts())) {
    settings.triangles = TriangleMethod::kTwoRounds;
  }
  return settings;
}

void Frame::begin_pipelines(const FrameSettings& settings, Resources& resources) {
  const fixtures::Needs needs = drawn_needs(needs_, haze_, settings);
  const PassList& own = product_passes();  // others may make more than pipelines
  for (const PassEntry* entry : entries_) {
    if (std::find(own.begin(), own.end(), entry) == own.end() || !entry->needed(needs, settings)) continue;
    // If it fails, change() does, too.
    (void)entry->create({device_, resources, settings, entry->constants(needs, settings), true});
  }
}

// The tables of the rig, which pipelines do not need, do not exist yet.
void Frame::compile_beside_tables(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                                  const FrameSettings& requested) {
  FrameSettings settings = suited(requested);
  RigTables none;
  none.has_bodies = has_bodies(compiled.needs, settings);
  none.shadow_map_px = settings.shadow_map_px =
      suited_map_px({rig, compiled, compiled.needs, settings}, device_.limits().maxStorageBufferRange);
  Resources empty{.rig = none};
  begin_pipelines(settings, empty);
}

void Frame::compile_ahead(const FrameSettings& requested) {
  FrameSettings settings = suited(requested);
  settings.shadow_map_px = resources_.rig.shadow_map_px;
  begin_pipelines(settings, resources_);
}

Result<std::unique_ptr<Frame>> Frame::create_beside(Frame& owner, const FrameSettings& settings) {
  std::unique_ptr<Frame> frame(new Frame(owner.device_, owner.entries_, &owner.resources_.rig));
  frame->owner_ = &owner;
  frame->needs_ = owner.needs_;
  frame->haze_ = owner.haze_;
  frame->ambient_lx_ = owner.ambient_lx_;
  frame->mirror_plane_ = owner.mirror_plane_;
  frame->range_m_ = owner.range_m_;
  frame->haze_center_m_ = owner.haze_center_m_;
  frame->haze_radius_m_ = owner.haze_radius_m_;
  FL_TRY(frame->change(settings));
  return frame;
}

void Frame::follow(const Frame& owner) {
  time_ns_ = owner.time_ns_;
  puffs_ = owner.puffs();
  set_haze_per_m(owner.haze_.scattering_per_m + (owner.machines_ ? owner.machines_->scattering_per_m() : 0));
}

}  // namespace footlight::render

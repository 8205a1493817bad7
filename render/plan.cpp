#include "render/plan.h"

#include "render/passes/beams.h"
#include "render/passes/blur.h"
#include "render/passes/bodies.h"
#include "render/passes/boxes.h"
#include "render/passes/bounce.h"
#include "render/passes/coarse.h"
#include "render/passes/depths.h"
#include "render/passes/displays.h"
#include "render/passes/edges.h"
#include "render/passes/fine.h"
#include "render/passes/gather.h"
#include "render/passes/glare.h"
#include "render/passes/gloss.h"
#include "render/passes/gobos.h"
#include "render/passes/haze.h"
#include "render/passes/lasers.h"
#include "render/passes/lenses.h"
#include "render/passes/mirrors.h"
#include "render/passes/probes.h"
#include "render/passes/records.h"
#include "render/passes/reflections.h"
#include "render/passes/shade.h"
#include "render/passes/shadows.h"
#include "render/passes/shadowtiles.h"
#include "render/passes/shafts.h"
#include "render/passes/step.h"
#include "render/passes/strips.h"
#include "render/passes/surfaces.h"
#include "render/passes/tiles.h"
#include "render/passes/tonemap.h"
#include "sim/core/check.h"

namespace footlight::render {
namespace {

// The frame, in order. A new pass is one line here.
const PassEntry* const kPasses[] = {
    &kStepPass,      // raw levels -> fixture states
    &kGatherPass,    // states -> lit beams, in patch order
    &kMirrorsPass,   // lit beams x mirrors of balls -> beams that these send
    &kShadowsPass,   // beams x boxes and bodies -> which part of each beam they hide
    &kGobosPass,     // beams -> tables of their gobos that are not built yet
    &kBodiesPass,    // fixture bodies -> visibility buffer
    &kBoxesPass,     // stage boxes -> which of them each pixel shows
    &kTilesPass,     // beams -> which supertile they touch
    &kBouncePass,    // beams x boxes and scenery -> light that these reflect
    &kProbesPass,    // light that boxes and scenery reflect, beams in haze -> what shiny surfaces mirror
    &kSurfacesPass,  // beams x boxes and bodies -> radiance, distance
    &kReflectionsPass,  // what probes show -> radiance of shiny surfaces
    &kGlossPass,     // picture of the mirrored camera -> radiance of floors that mirror
    &kDepthsPass,    // radiance's distances -> planes of tiles
    &kShadowtilesPass,  // beams x their shadows -> which of these reach each supertile
    &kHazePass,      // haze that is not even -> what rays pass through
    &kCoarsePass,    // beams -> those that are smooth over a supertile, records of rims and cuts, and the rest
    &kRecordsPass,   // beams that are smooth over a supertile but for rims and cuts -> radiance
    &kFinePass,      // the same over 32 x 32 pixels, and beams that are smooth but for their rim -> radiance, the rest
    &kShadePass,     // shadows of beams that were taken together -> radiance, and those left to the beam pass
    &kBeamsPass,     // the rest, pixel by pixel -> radiance
    &kLasersPass,    // lasers -> sheets of light -> radiance
    &kShaftsPass,    // panes of glass -> light of the sun behind them -> radiance
    &kDisplaysPass,  // displays -> their pixels, and their light in the air and on surfaces -> radiance
    &kEdgesPass,     // solid things -> radiance of pixels that show more than one
    &kStripsPass,    // displays that are thin in the picture -> radiance
    &kLensesPass,    // lenses of a few pixels -> radiance
    &kBlurPass,      // radiance, distance -> radiance as a lens shows it that is focused on one distance
    &kGlarePass,     // radiance -> light that the camera's lens scatters
    &kTonemapPass,   // radiance, scattered light -> screen
};

constexpr std::uint32_t kFrameBindings[] = {FL_BINDING_PARAMS, FL_BINDING_COUNTS, FL_BINDING_RADIANCE,
                                            FL_BINDING_SCREEN};

}  // namespace

const PassList& product_passes() {
  static const PassList kList(std::begin(kPasses), std::end(kPasses));
  return kList;
}

std::vector<PassPlan> plan_frame(const fixtures::Needs& needs, const FrameSettings& settings, const PassList& passes) {
  std::vector<PassPlan> plan;
  for (const PassEntry* pass : passes) {
    if (pass->needed(needs, settings)) plan.push_back({pass->name, pass->constants(needs, settings)});
  }
  return plan;
}

std::vector<LeftOutPass> left_out_passes(const fixtures::Needs& needs, const FrameSettings& settings) {
  std::vector<LeftOutPass> out;
  for (const PassEntry* pass : kPasses) {
    if (!pass->needed(needs, settings)) out.push_back({pass->name, pass->loss});
  }
  return out;
}

std::vector<PassShaders> pass_shaders() {
  std::vector<PassShaders> all;
  for (const PassEntry* pass : kPasses) all.push_back({pass->name, pass->shaders()});
  return all;
}

std::span<const std::uint32_t> frame_bindings() { return kFrameBindings; }

std::vector<std::uint32_t> bindings_of(const PassEntry& pass) {
  std::vector<std::uint32_t> bindings;
  if (pass.attachments != nullptr) bindings = pass.attachments();
  for (const auto& stages : pass.shaders()) {
    const auto shader = vk::read_interfaces(stages);
    FL_CHECK(shader.has_value());  // a test reads every shader
    for (const vk::ShaderBinding& binding : shader->bindings) {
      if (binding.binding < FL_BINDING_COUNT) bindings.push_back(binding.binding);
    }
  }
  return bindings;
}

std::vector<PassMemory> plan_memory(const MemoryShape& shape) {
  std::vector<bool> counted(FL_BINDING_COUNT, false);
  const auto bytes_of = [&](const std::vector<std::uint32_t>& bindings) {
    std::uint64_t bytes = 0;
    for (const std::uint32_t binding : bindings) {
      if (!counted[binding]) bytes += binding_bytes(binding, shape);
      counted[binding] = true;
    }
    return bytes;
  };
  std::vector<PassMemory> plan;
  plan.push_back({"frame", bytes_of({std::begin(kFrameBindings), std::end(kFrameBindings)})});
  for (const PassEntry* pass : kPasses) {
    if (pass->needed(shape.needs, shape.settings)) plan.push_back({pass->name, bytes_of(bindings_of(*pass))});
  }
  return plan;
}

fixtures::Needs drawn_needs(const fixtures::Needs& needs, const fixtures::Haze& haze, const FrameSettings& settings) {
  fixtures::Needs drawn = needs;
  if (settings.haze) return drawn;
  drawn.haze = false;
  drawn.haze_field = false;
  drawn.plumes = false;
  drawn.extinction = needs.extinction && haze.absorption_per_m > 0;
  return drawn;
}

}  // namespace footlight::render

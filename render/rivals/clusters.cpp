#include "render/rivals/clusters.h"

#include "render/passes/surfaces.h"
#include "render/rivals/rival_pass.h"
#include "shaders/clusterbits.comp.h"
#include "shaders/clustersurfaces.comp.h"

namespace footlight::render {
namespace {

constexpr std::uint32_t kPublishedLights = 127;

template <bool kLossy, bool kOwnLaw>
Result<std::unique_ptr<Pass>> create_clusters(const PassContext& context) {
  auto pass = std::make_unique<RivalPass>(
      context, std::vector<vk::SpecConstant>{{FL_SPEC_CLUSTER_LIGHTS, kLossy ? kPublishedLights : 0},
                                             {FL_SPEC_CLUSTER_EDGES, kLossy},
                                             {FL_SPEC_CLUSTER_LAW, kOwnLaw}});
  const std::uint32_t words = context.resources.rig.mask_words;
  const auto width = static_cast<std::uint32_t>(context.settings.width);
  const auto height = static_cast<std::uint32_t>(context.settings.height);
  FL_TRY(pass->add_buffer(FL_BINDING_CLUSTERS, VkDeviceSize{3} * FL_CLUSTER_SLABS * 4 * words));
  FL_TRY(pass->add_compute(kClusterbitsComp, [words](VkCommandBuffer commands) {
    vkCmdDispatch(commands, FL_CLUSTER_SLABS / FL_GROUP_CLUSTERS, words, 3);
  }));
  FL_TRY(pass->add_compute(kClustersurfacesComp, [width, height](VkCommandBuffer commands) {
    vkCmdDispatch(commands, groups_of(width, FL_GROUP_SURFACE), groups_of(height, FL_GROUP_SURFACE), 1);
  }));
  return pass;
}

template <bool kLossy, bool kOwnLaw>
PassEntry cluster_entry() {
  return {"clusters",
          [](const fixtures::Needs& needs, const FrameSettings& settings) { return has_solids(needs, settings); },
          [](const fixtures::Needs& needs, const FrameSettings& settings) {
            return kSurfacesPass.constants(needs, settings);
          },
          create_clusters<kLossy, kOwnLaw>,
          [] {
            return std::vector<std::vector<vk::Spirv>>{{kClusterbitsComp}, {kClustersurfacesComp}};
          },
          "light on surfaces"};
}

// Its light in the haze is the product's, every beam pixel by pixel; bodies are not drawn.
Rival cluster_rival(const char* method, bool has_unit, PassList (*passes)()) {
  return {method,
          {FL_CLUSTER_SLABS},
          {FL_CLUSTER_SLABS},
          "z3y, ClusteredBIRP",
          true,
          has_unit,
          false,
          passes,
          [](FrameSettings judged, double) {
            judged.tile_error = 0;
            return judged;
          }};
}

}  // namespace

const PassEntry kClustersPass = cluster_entry<false, false>();
const PassEntry kClustersLossyPass = cluster_entry<true, false>();
const PassEntry kClustersOwnLawPass = cluster_entry<true, true>();

const Rival kClusters = cluster_rival("clusters", true, [] { return passes_with_surfaces(&kClustersPass); });
const Rival kClustersLossy =
    cluster_rival("clusters, 127 lights", true, [] { return passes_with_surfaces(&kClustersLossyPass); });
const Rival kClustersOwnLaw =
    cluster_rival("clusters, own law", false, [] { return passes_with_surfaces(&kClustersOwnLawPass); });

}  // namespace footlight::render

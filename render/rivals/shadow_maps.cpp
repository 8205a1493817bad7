#include "render/rivals/shadow_maps.h"

#include <algorithm>

#include "render/rivals/rival_pass.h"
#include "shaders/bounds.comp.h"
#include "shaders/mapmarch.comp.h"
#include "shaders/shadowmaps.comp.h"

namespace footlight::render {
namespace {

// Beams behind the last map have no shadow, as where a program limits the lights that cast any.
constexpr std::uint64_t kMapBytesMost = 1ull << 30;

template <std::uint32_t kTexels>
Result<std::unique_ptr<Pass>> create_shadow_maps(const PassContext& context) {
  auto pass = std::make_unique<RivalPass>(context, std::vector<vk::SpecConstant>{{FL_SPEC_MAP_TEXELS, kTexels}});
  const std::uint64_t map_bytes = std::uint64_t{4} * kTexels * kTexels;
  const std::uint64_t limit = std::min<std::uint64_t>(kMapBytesMost, context.device.limits().maxStorageBufferRange);
  const auto maps = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
      context.resources.rig.beams_max, 1, std::min<std::uint64_t>(limit / map_bytes, 65'535)));
  FL_TRY(pass->add_bounds());
  FL_TRY(pass->add_buffer(FL_BINDING_SHADOW_MAPS, map_bytes * maps));
  FL_TRY(pass->add_compute(kShadowmapsComp, [maps](VkCommandBuffer commands) {
    vkCmdDispatch(commands, groups_of(kTexels, FL_GROUP_MAPS), groups_of(kTexels, FL_GROUP_MAPS), maps);
  }));
  FL_TRY(pass->add_compute(kMapmarchComp, tiles_of_beams(context)));
  return pass;
}

template <std::uint32_t kTexels>
PassEntry shadow_maps_entry() {
  return {"shadow maps",
          has_air,
          rival_constants,
          create_shadow_maps<kTexels>,
          [] {
            return std::vector<std::vector<vk::Spirv>>{{kBoundsComp}, {kShadowmapsComp}, {kMapmarchComp}};
          },
          "light in the haze"};
}

Rival shadow_maps_rival(const char* method, PassList (*passes)()) {
  Rival rival{method, {32, 64, 256}, {64}, "common practice", false, true, false, passes, rival_settings};
  rival.of_shadows = true;
  return rival;
}

}  // namespace

const PassEntry kShadowMapsSmallPass = shadow_maps_entry<256>();
const PassEntry kShadowMapsPass = shadow_maps_entry<1024>();

const Rival kShadowMapsSmall =
    shadow_maps_rival("shadow maps 256", [] { return passes_with_air({&kShadowMapsSmallPass}); });
const Rival kShadowMaps = shadow_maps_rival("shadow maps 1024", [] { return passes_with_air({&kShadowMapsPass}); });

}  // namespace footlight::render

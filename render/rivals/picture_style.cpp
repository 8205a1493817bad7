#include "render/rivals/picture_style.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "render/passes/gobos.h"
#include "render/passes/haze.h"
#include "render/passes/surfaces.h"
#include "render/rivals/beam_card.h"
#include "render/rivals/rival_pass.h"
#include "render/rivals/rivals.h"
#include "render/rivals/vrsl_disco.h"
#include "shaders/addblended.comp.h"
#include "shaders/vrslbeam.frag.h"
#include "shaders/vrslbeam.vert.h"
#include "shaders/vrslspot.comp.h"

namespace footlight::render {
namespace {

// The product's surfaces without the light of beams: these are hidden from it, and shown again.
class SurfacesWithoutBeams final : public Pass {
 public:
  SurfacesWithoutBeams(const PassContext& context, std::unique_ptr<Pass> surfaces, vk::Buffer kept)
      : counts_(context.resources.rig.counts.handle), surfaces_(std::move(surfaces)), kept_(std::move(kept)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte> push) override {
    const VkBufferCopy keep{offsetof(CountsRow, live_count), 0, sizeof(std::uint32_t)};
    vkCmdCopyBuffer(commands, counts_, kept_.handle, 1, &keep);
    vk::full_barrier(commands);
    vkCmdFillBuffer(commands, counts_, keep.srcOffset, keep.size, 0);
    vk::full_barrier(commands);
    surfaces_->record(commands, push);
    vk::full_barrier(commands);
    const VkBufferCopy back{0, keep.srcOffset, keep.size};
    vkCmdCopyBuffer(commands, kept_.handle, counts_, 1, &back);
  }
  [[nodiscard]] std::uint64_t own_bytes() const override { return surfaces_->own_bytes() + kept_.size_bytes; }

 private:
  VkBuffer counts_;
  std::unique_ptr<Pass> surfaces_;
  vk::Buffer kept_;
};

const PassEntry kUnlitSurfaces{
    "surfaces without beams",
    [](const fixtures::Needs& needs, const FrameSettings& settings) { return kSurfacesPass.needed(needs, settings); },
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return kSurfacesPass.constants(needs, settings);
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      FL_ASSIGN(std::unique_ptr<Pass> surfaces, kSurfacesPass.create(context));
      FL_ASSIGN(vk::Buffer kept, vk::Buffer::device_local(context.device, sizeof(std::uint32_t),
                                                          VK_BUFFER_USAGE_TRANSFER_SRC_BIT));
      return std::make_unique<SurfacesWithoutBeams>(context, std::move(surfaces), std::move(kept));
    },
    [] { return kSurfacesPass.shaders(); },
    "light on floor, walls and fixtures"};

const PassEntry kVrslSpot{
    "VRSL's projected spots",
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return needs.fixtures && kSurfacesPass.needed(needs, settings);
    },
    rival_constants,
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      auto pass = std::make_unique<RivalPass>(context);
      FL_TRY(pass->add_compute(kVrslspotComp, tiles_of_beams(context)));
      return pass;
    },
    [] { return std::vector<std::vector<vk::Spirv>>{{kVrslspotComp}}; },
    "light on surfaces"};

const PassEntry kVrslBeam{"VRSL's beams",
                          has_air,
                          rival_constants,
                          [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                            auto pass = std::make_unique<RivalPass>(context);
                            FL_TRY(pass->add_meshes(kVrslbeamVert, kVrslbeamFrag, FL_CONE_SIDES * 6));
                            return pass;
                          },
                          [] {
                            return std::vector<std::vector<vk::Spirv>>{{kVrslbeamVert, kVrslbeamFrag},
                                                                       {kAddblendedComp}};
                          },
                          "light in the haze"};

// In place of the product's light of beams in the haze. Lasers, displays and shafts still read the table of haze;
// tables of gobos have no reader.
PassList style_passes(const PassList& air) {
  PassList own{&kHazePass};
  own.insert(own.end(), air.begin(), air.end());
  PassList list = passes_with_air(own);
  std::erase(list, &kGobosPass);
  return list;
}

PassList vrsl_passes() {
  PassList list = style_passes({&kVrslDiscoPass, &kVrslSpot, &kVrslBeam});
  std::replace(list.begin(), list.end(), &kSurfacesPass, &kUnlitSurfaces);
  return list;
}

constexpr std::array kStyles{PictureStyle::kPhysical, PictureStyle::kVrsl, PictureStyle::kCard};

}  // namespace

const char* word_of(PictureStyle style) {
  switch (style) {
    case PictureStyle::kVrsl: return "vrsl";
    case PictureStyle::kCard: return "card";
    default: return "physical";
  }
}

Result<PictureStyle> picture_style_of(std::string_view word) {
  for (const PictureStyle style : kStyles)
    if (word == word_of(style)) return style;
  return fail(ErrorCode::kBadInput, "{}: expected physical, vrsl or card", word);
}

const PassList& passes_of(PictureStyle style) {
  static const PassList kVrslList = vrsl_passes();
  static const PassList kCardList = style_passes({&kBeamCardPass});
  return style == PictureStyle::kVrsl ? kVrslList : style == PictureStyle::kCard ? kCardList : product_passes();
}

FrameSettings settings_of(PictureStyle style, FrameSettings settings) {
  if (style == PictureStyle::kPhysical) return settings;
  settings = rival_settings(settings, settings.nodes);
  if (style == PictureStyle::kCard) return settings;
  settings.bounce = false;
  settings.probes = false;
  settings.gloss_px = 0;
  settings.shadows = false;
  return settings;
}

}  // namespace footlight::render

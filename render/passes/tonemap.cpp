#include "render/passes/tonemap.h"

#include <array>
#include <optional>

#include "render/display.h"
#include "render/passes/compute_pass.h"
#include "shaders/expose.comp.h"
#include "shaders/glaretone.comp.h"
#include "shaders/meter.comp.h"
#include "shaders/tonemap.comp.h"

namespace footlight::render {
namespace {

// What the automatic exposure needs.
struct Meter {
  BoundPipeline count, expose;
};

std::uint32_t meter_groups(int size_px) { return groups_of(static_cast<std::uint32_t>(size_px), 4 * FL_GROUP_METER); }

class TonemapPass final : public Pass {
 public:
  TonemapPass(const FrameSettings& settings, BoundPipeline tone, std::optional<Meter> meter)
      : settings_(settings), tone_(std::move(tone)), meter_(std::move(meter)) {
    const glm::dmat3 rows = glm::transpose(white_balance(settings.white_k));
    for (int i = 0; i < 9; ++i) white_[static_cast<std::size_t>(i)] = static_cast<float>(rows[i / 3][i % 3]);
  }

  void record(VkCommandBuffer commands, std::span<const std::byte> push) override {
    if (meter_) {
      meter_->count.bind(commands);
      vkCmdDispatch(commands, meter_groups(settings_.width), meter_groups(settings_.height), 1);
      vk::full_barrier(commands);
      meter_->expose.bind(commands);
      meter_->expose.pipeline->push(commands, push);
      vkCmdDispatch(commands, 1, 1, 1);
      vk::full_barrier(commands);
    }
    tone_.bind(commands);
    tone_.pipeline->push(commands, std::as_bytes(std::span(white_)));
    vkCmdDispatch(commands, tile_groups(settings_.width / settings_.supersample),
                  tile_groups(settings_.height / settings_.supersample), 1);
  }

 private:
  FrameSettings settings_;
  BoundPipeline tone_;
  std::optional<Meter> meter_;
  std::array<float, 9> white_{};
};

}  // namespace

const PassEntry kTonemapPass{
    "tonemap",
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return needs.fixtures || needs.panes || needs.displays || has_solids(needs, settings);
    },
    [](const fixtures::Needs&, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_TONE, static_cast<std::uint32_t>(settings.tone)},
                                           {FL_SPEC_WHITE, settings.white_k > 0},
                                           {FL_SPEC_METER, settings.auto_exposure}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      const bool glare = context.resources.picture.glare.handle != VK_NULL_HANDLE;
      FL_ASSIGN(auto tone, BoundPipeline::compute(context, glare ? vk::Spirv(kGlaretoneComp) : vk::Spirv(kTonemapComp),
                                                  context.constants));
      std::optional<Meter> meter;
      if (context.settings.auto_exposure) {
        FL_ASSIGN(auto count, BoundPipeline::compute(context, kMeterComp, {}));
        FL_ASSIGN(auto expose, BoundPipeline::compute(context, kExposeComp, {}));
        meter.emplace(Meter{std::move(count), std::move(expose)});
      }
      return std::unique_ptr<Pass>(new TonemapPass(context.settings, std::move(tone), std::move(meter)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kMeterComp}, {kExposeComp}, {kTonemapComp}, {kGlaretoneComp}};
    },
    "anything to see"};

}  // namespace footlight::render

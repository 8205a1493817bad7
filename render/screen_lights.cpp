#include "render/screen_lights.h"

#include <cstddef>

namespace footlight::render {

ScreenLights::ScreenLights(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled)
    : dimmers_(rig, compiled), none_(compiled.universes.size() * kSlotCountMax) {
  for (const std::size_t index : dimmers_.displays()) {
    const fixtures::Display& display = rig.displays[index];
    screens_.push_back({index, display.nits * display.color, -1});
  }
}

void ScreenLights::record(VkCommandBuffer commands, RigTables& rig, std::span<const std::uint8_t> levels) {
  if (rig.displays.handle == VK_NULL_HANDLE) return;
  bool any = false;
  for (std::size_t i = 0; i < screens_.size(); ++i) {
    Screen& screen = screens_[i];
    const double share = dimmers_.share(i, levels.empty() ? none_ : levels);
    if (share == screen.share) continue;
    screen.share = share;
    const vec4 light(glm::vec3(share * screen.full_cd_m2), 0);
    vkCmdUpdateBuffer(commands, rig.displays.handle, screen.display * sizeof(DisplayRow) + offsetof(DisplayRow, light),
                      sizeof(light), &light);
    any = true;
  }
  if (any) vk::full_barrier(commands);
}

}  // namespace footlight::render

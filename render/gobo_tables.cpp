#include "render/gobo_tables.h"

#include <algorithm>
#include <iterator>

#include "fixtures/model/param_table.h"
#include "sim/core/check.h"

namespace footlight::render {
namespace {

// Numbers of profiles, as in lib/profile_index.glsl.
std::size_t profile_index(float profile_power) {
  constexpr float kLeast[] = {0.29f, 0.42f, 0.75f, 1.5f, 2.5f, 3.5f};
  return static_cast<std::size_t>(
      std::count_if(std::begin(kLeast), std::end(kLeast), [&](float least) { return profile_power > least; }));
}

bool has_focus(const fixtures::CompiledRig& compiled, const fixtures::TypeRow& type) {
  for (std::uint32_t c = 0; c < type.channel_count; ++c) {
    const fixtures::ChannelRow& channel = compiled.channels[type.channel_first + c];
    for (std::uint32_t f = 0; f < channel.function_count; ++f) {
      const std::uint32_t param = compiled.functions[channel.function_first + f].param;
      if (param < fixtures::kParamCount && fixtures::acts_on(param) == fixtures::kParamFocus) return true;
    }
  }
  return false;
}

}  // namespace

GoboTablePlan plan_gobo_tables(const fixtures::CompiledRig& compiled, const std::vector<std::uint32_t>& planes,
                               std::uint32_t gates) {
  const std::size_t count = compiled.images.size();
  FL_CHECK_EQ(planes.size(), count);
  // Of each image, the profiles of the types that show it; whether it stands in a gobo wheel at all; and whether a
  // type that shows it has a focus.
  std::vector<std::uint32_t> profiles(count, 0);
  std::vector<bool> in_wheel(count, false), in_focus(count, false);
  GoboTablePlan plan;
  bool several = false;  // images may stand behind each other
  for (const fixtures::TypeRow& type : compiled.types) {
    const auto images_of = [&](std::uint32_t wheel_index) {
      const fixtures::WheelRow& wheel = compiled.wheels[type.wheel_first + wheel_index];
      std::uint32_t images = 0;
      for (std::uint32_t s = 0; s < wheel.slot_count; ++s) {
        const std::uint32_t image = compiled.wheel_slots[wheel.slot_first + s].image;
        if (image == 0) continue;
        plan.gate_planes = std::max(plan.gate_planes, planes[image - 1]);
        ++images;
      }
      return images;
    };
    several |= images_of(fixtures::kWheelAnimation) > 0;
    several |= images_of(fixtures::kWheelGobo1) > 0 && images_of(fixtures::kWheelGobo2) > 0;
    const bool focuses = compiled.needs.focus && has_focus(compiled, type);
    for (const std::uint32_t wheel_index : {fixtures::kWheelGobo1, fixtures::kWheelGobo2}) {
      const fixtures::WheelRow& wheel = compiled.wheels[type.wheel_first + wheel_index];
      for (std::uint32_t s = 0; s < wheel.slot_count; ++s) {
        const std::uint32_t image = compiled.wheel_slots[wheel.slot_first + s].image;
        if (image == 0) continue;
        in_wheel[image - 1] = true;
        in_focus[image - 1] = in_focus[image - 1] || focuses;
        if (type.aspect > 0 || type.measured != 0) continue;
        profiles[image - 1] |= 1u << profile_index(compiled.needs.profile ? type.profile_power : 1);
      }
    }
  }
  std::uint64_t bytes = 0;
  const auto take = [&](std::uint32_t& layers, std::uint32_t wanted, std::uint64_t layer_bytes) -> std::uint32_t {
    if (bytes + wanted * layer_bytes > kGoboTableBytesMax) return 0;
    bytes += wanted * layer_bytes;
    layers += wanted;
    return layers - wanted + 1;
  };
  for (std::size_t i = 0; i < count; ++i) {
    plan.rows.push_back({.planes = planes[i], .lines = 0, .blurs = 0, .built = 0, .gate = 0, .whole = {}});
    const bool is_drawn = in_wheel[i] && !compiled.images[i].changes;
    if (is_drawn) plan.rows[i].lines = take(plan.lines_layers, planes[i], kGoboLinesBytes);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (in_focus[i] && plan.rows[i].lines != 0) plan.rows[i].blurs = take(plan.blur_layers, planes[i], kGoboBlurBytes);
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::uint32_t p = 0; p < FL_GOBO_PROFILES; ++p) {
      const bool shown = (profiles[i] >> p & 1u) != 0 && plan.rows[i].lines != 0;
      if (shown) plan.rows[i].whole[p] = take(plan.whole_layers, planes[i], kGoboWholeBytes);
    }
  }
  if (count == 0) return plan;
  plan.gates = static_cast<std::uint32_t>(
      std::min<std::uint64_t>({several ? gates : std::min(gates, kGatesBetweenSlots), FL_GATES_MAX,
                               kGateBytesMax / (plan.gate_planes * kGateBytes)}));
  plan.rows.resize(count + plan.gates, {.planes = 1, .lines = 0, .blurs = 0, .built = 0, .gate = 0, .whole = {}});
  return plan;
}

}  // namespace footlight::render

#include "tools/footlight/preview/ui/draw_controls.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "fixtures/model/attributes.h"
#include "fixtures/model/params.h"
#include "fixtures/simulate/encode.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/pick_colour.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

// An axis of a head: its channel and the function with its angles.
struct Axis {
  ChannelKey key;
  const fixtures::ChannelFunction* function = nullptr;
  [[nodiscard]] double low_deg() const { return std::min(function->physical_from, function->physical_to); }
  [[nodiscard]] double high_deg() const { return std::max(function->physical_from, function->physical_to); }
};

std::optional<Axis> axis_of(UiDesk& desk, int fixture, std::string_view attribute) {
  const auto& mode = fixtures::mode_of(desk.rig(), desk.rig().fixtures[static_cast<std::size_t>(fixture)]);
  for (std::size_t c = 0; c < mode.channels.size(); ++c) {
    const ChannelKey key{fixture, static_cast<int>(c)};
    for (const auto& function : mode.channels[c].functions) {
      const bool its = fixtures::same_attribute(function.attribute, attribute) &&
                       function.physical_from != function.physical_to && desk.index().place(key);
      if (its) return Axis{key, &function};
    }
  }
  return std::nullopt;
}

std::optional<double> angle_deg(UiDesk& desk, const UiInput& input, const Axis& axis) {
  const auto& fixture = desk.rig().fixtures[static_cast<std::size_t>(axis.key.fixture)];
  const ChannelReading reading = reading_of(fixtures::type_of(desk.rig(), fixture), desk.index().channel(axis.key),
                                            desk.index().read(axis.key, input.levels), [&](int other) {
                                              return desk.index().read({axis.key.fixture, other}, input.levels);
                                            });
  return reading.function == axis.function ? std::optional(reading.value) : std::nullopt;
}

std::optional<std::uint32_t> raw_of(const UiDesk& desk, const fixtures::Channel& channel, const Axis& axis,
                                    double value_deg) {
  fixtures::Channel only = channel;
  only.functions = {*axis.function};
  const auto& fixture = desk.rig().fixtures[static_cast<std::size_t>(axis.key.fixture)];
  const auto nearest =
      fixtures::nearest_raw(fixtures::type_of(desk.rig(), fixture), only, axis.function->attribute, value_deg);
  return nearest ? std::optional(nearest->raw) : std::nullopt;
}

// 0 at the lower end of the axis.
float share_of(const Axis& axis, double value_deg) {
  return static_cast<float>(std::clamp((value_deg - axis.low_deg()) / (axis.high_deg() - axis.low_deg()), 0.0, 1.0));
}

}  // namespace

void InspectorControls::draw(UiDesk& desk, const UiInput& input, int lead,
                             const std::optional<glm::dvec2>& simulated_deg) {
  draw_pad(desk, input, lead, simulated_deg);
  draw_colour(desk, input, lead);
}

// Pan to the right and tilt up, over the whole range of both. A cross is where the levels send the head, a dot where it
// is.
void InspectorControls::draw_pad(UiDesk& desk, const UiInput& input, int lead,
                                 const std::optional<glm::dvec2>& simulated_deg) {
  const auto pan = axis_of(desk, lead, "Pan");
  const auto tilt = axis_of(desk, lead, "Tilt");
  if (!pan || !tilt || pan->key == tilt->key) return;
  if (!ImGui::CollapsingHeader(tr_label("Pan and tilt"))) return;
  const float side = 9 * ImGui::GetFrameHeight();
  const ImVec2 size{std::min(side * 1.5f, std::max(ImGui::GetContentRegionAvail().x - 8, 20.0f)), side};
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::InvisibleButton("pad", size);
  const auto take = [&](double pan_deg, double tilt_deg) {
    const auto pan_raw = raw_of(desk, desk.index().channel(pan->key), *pan, pan_deg);
    const auto tilt_raw = raw_of(desk, desk.index().channel(tilt->key), *tilt, tilt_deg);
    if (!pan_raw || !tilt_raw) return;
    const std::array<std::pair<ChannelKey, std::uint32_t>, 2> both{{{pan->key, *pan_raw}, {tilt->key, *tilt_raw}}};
    desk.take_several(both, input.levels);
  };
  if (ImGui::IsItemActive()) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const double x = std::clamp(static_cast<double>((mouse.x - at.x) / size.x), 0.0, 1.0);
    const double y = std::clamp(static_cast<double>((at.y + size.y - mouse.y) / size.y), 0.0, 1.0);
    take(pan->low_deg() + x * (pan->high_deg() - pan->low_deg()),
         tilt->low_deg() + y * (tilt->high_deg() - tilt->low_deg()));
  }
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImVec2 end{at.x + size.x, at.y + size.y};
  draw.AddRectFilled(at, end, ImGui::GetColorU32(ImGuiCol_FrameBg), 3);
  const auto place = [&](double pan_deg, double tilt_deg) {
    return ImVec2{at.x + share_of(*pan, pan_deg) * size.x, end.y - share_of(*tilt, tilt_deg) * size.y};
  };
  const ImU32 dim = ImGui::GetColorU32(ImGuiCol_Separator);
  const ImVec2 home = place(0, 0);
  draw.AddLine({home.x, at.y}, {home.x, end.y}, dim);
  draw.AddLine({at.x, home.y}, {end.x, home.y}, dim);
  if (simulated_deg) draw.AddCircleFilled(place(simulated_deg->x, simulated_deg->y), 4, ImGui::GetColorU32(kUiDim));
  const auto pan_deg = angle_deg(desk, input, *pan);
  const auto tilt_deg = angle_deg(desk, input, *tilt);
  const bool taken = desk.state().taken.contains(pan->key) || desk.state().taken.contains(tilt->key);
  if (pan_deg && tilt_deg) {
    const ImVec2 target = place(*pan_deg, *tilt_deg);
    const ImU32 colour = ImGui::GetColorU32(taken ? kUiGreen : kUiAmber);
    draw.AddLine({target.x - 8, target.y}, {target.x + 8, target.y}, colour, 2);
    draw.AddLine({target.x, target.y - 8}, {target.x, target.y + 8}, colour, 2);
    ui_text(taken ? kUiGreen : ImGui::GetStyleColorVec4(ImGuiCol_Text),
            trf("pan {:.1f}\u00b0  tilt {:.1f}\u00b0", *pan_deg, *tilt_deg));
  } else {
    ui_text(kUiDim, tr("these channels do something else now"));
  }
  ImGui::SameLine();
  if (ImGui::SmallButton(tr_label("home")))
    take(std::clamp(0.0, pan->low_deg(), pan->high_deg()), std::clamp(0.0, tilt->low_deg(), tilt->high_deg()));
  ImGui::SameLine();
  ImGui::BeginDisabled(!taken);
  const std::array<ChannelKey, 2> keys{pan->key, tilt->key};
  if (ImGui::SmallButton(tr_label("release", "pad"))) desk.release_several(keys, input.levels);
  ImGui::EndDisabled();
}

void InspectorControls::draw_colour(UiDesk& desk, const UiInput& input, int lead) {
  const fixtures::PatchedFixture& one = desk.rig().fixtures[static_cast<std::size_t>(lead)];
  const auto& type = fixtures::type_of(desk.rig(), one);
  const auto& mode = fixtures::mode_of(desk.rig(), one);
  const auto now = colour_of_channels(type, mode, [&](int channel) {
    return desk.index().read({lead, channel}, input.levels);
  });
  if (!now || !ImGui::CollapsingHeader(tr_label("Colour"))) return;
  if (!picks_) {
    for (int i = 0; i < 3; ++i) {
      screen_rgb_.at(static_cast<std::size_t>(i)) = static_cast<float>(screen_of_linear((*now)[i]));
    }
  }
  ImGui::SetNextItemWidth(std::min(9 * ImGui::GetFrameHeight(), ImGui::GetContentRegionAvail().x));
  constexpr ImGuiColorEditFlags kFlags = ImGuiColorEditFlags_PickerHueWheel | ImGuiColorEditFlags_NoSidePreview |
                                         ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoLabel |
                                         ImGuiColorEditFlags_NoOptions;
  const bool changed = ImGui::ColorPicker3("colour", screen_rgb_.data(), kFlags);
  picks_ = ImGui::IsItemActive();
  if (changed) {
    const auto linear = [&](std::size_t i) { return linear_of_screen(static_cast<double>(screen_rgb_.at(i))); };
    desk.take_colour({linear(0), linear(1), linear(2)});
  }
  std::vector<ChannelKey> keys;
  for (const ChannelRaw& value : channels_of_colour(type, mode, *now)) keys.push_back({lead, value.channel});
  const bool taken =
      std::any_of(keys.begin(), keys.end(), [&](ChannelKey key) { return desk.state().taken.contains(key); });
  ImGui::BeginDisabled(!taken);
  if (ImGui::SmallButton(tr_label("release", "colour"))) desk.release_several(keys, input.levels);
  ImGui::EndDisabled();
}

}  // namespace footlight::tools

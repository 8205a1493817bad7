#include "tools/footlight/preview/ui/draw_wheels.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kFacetsDrawn = 8;

std::string key_of(const fixtures::ImageSource& image) {
  return fmt::format("gobo {} {} {}", static_cast<const void*>(image.files.get()), image.clear ? 1 : 0, image.name);
}

// What the slot looks like, within a square.
void draw_look(const WheelChoice::Slot& slot, PictureShelf* shelf, ImVec2 low, float side) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImVec2 high{low.x + side, low.y + side};
  const ImVec2 middle{low.x + side / 2, low.y + side / 2};
  const ImU32 line = ImGui::GetColorU32(ui_colours.text);
  if (slot.image && shelf != nullptr) {
    const auto place = shelf->find(key_of(*slot.image), [image = *slot.image] { return gobo_picture(image); });
    if (place) {
      draw.AddImage(ImGui::GetIO().Fonts->TexID, low, high, {place->left, place->top}, {place->right, place->bottom});
      return;
    }
  }
  if (slot.coloured) {
    const ImVec4 chip{static_cast<float>(slot.screen_rgb.x), static_cast<float>(slot.screen_rgb.y),
                      static_cast<float>(slot.screen_rgb.z), 1};
    draw.AddRectFilled({low.x + 2, low.y + 2}, {high.x - 2, high.y - 2}, ImGui::GetColorU32(chip), 3);
    return;
  }
  if (slot.facets > 0) {
    const std::size_t count = std::min(slot.facets, kFacetsDrawn);
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
      draw.AddCircle({middle.x + side * 0.24f * static_cast<float>(std::cos(angle)),
                      middle.y + side * 0.24f * static_cast<float>(std::sin(angle))},
                     side * 0.16f, line);
    }
    return;
  }
  if (slot.open) return draw.AddCircle(middle, side * 0.36f, line, 0, 1.5f);
  const std::string number = fmt::format("{}", slot.number);
  const ImVec2 size = ImGui::CalcTextSize(number.c_str());
  draw.AddText({middle.x - size.x / 2, middle.y - size.y / 2}, line, number.c_str());
}

void draw_choice(UiDesk& desk, const UiInput& input, int lead, const WheelChoice& choice) {
  const ChannelKey key{lead, choice.channel};
  const std::uint32_t raw = desk.index().read(key, input.levels);
  ui_text(desk.state().taken.contains(key) ? kUiGreen : kUiDim, choice.name);
  const float side = 1.7f * ImGui::GetFrameHeight();
  const float end = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  ImGui::BeginDisabled(!desk.index().place(key));
  for (std::size_t i = 0; i < choice.slots.size(); ++i) {
    const WheelChoice::Slot& slot = choice.slots[i];
    if (i > 0) {
      ImGui::SameLine(0, 3);
      if (ImGui::GetCursorScreenPos().x + side > end) ImGui::NewLine();
    }
    const ImVec2 low = ImGui::GetCursorScreenPos();
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::InvisibleButton("slot", {side, side})) desk.take(key, slot.raw, input.levels);
    const bool hovered = ImGui::IsItemHovered();
    const bool visible = ImGui::IsItemVisible();  // else it is scrolled away, and needs no place of the shelf
    ImGui::PopID();
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImVec2 high{low.x + side, low.y + side};
    draw.AddRectFilled(low, high, ImGui::GetColorU32(hovered ? ImGuiCol_FrameBgHovered : ImGuiCol_FrameBg), 3);
    draw_look(slot, visible ? input.pictures : nullptr, low, side);
    if (raw >= slot.raw_from && raw <= slot.raw_to) draw.AddRect(low, high, ImGui::GetColorU32(kUiAmber), 3, 0, 2);
    if (hovered) ImGui::SetTooltip("%d: %s", slot.number, slot.name.c_str());
  }
  ImGui::EndDisabled();
}

}  // namespace

void InspectorWheels::draw(UiDesk& desk, const UiInput& input, int lead) {
  if (lead != lead_ || shown_count_ != desk.shown_count()) {
    const fixtures::PatchedFixture& one = desk.rig().fixtures[static_cast<std::size_t>(lead)];
    choices_ = wheel_choices(fixtures::type_of(desk.rig(), one), fixtures::mode_of(desk.rig(), one));
    lead_ = lead;
    shown_count_ = desk.shown_count();
  }
  if (choices_.empty() || !ImGui::CollapsingHeader(tr_label("Wheels"))) return;
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    draw_choice(desk, input, lead, choices_[i]);
    ImGui::PopID();
  }
}

}  // namespace footlight::tools

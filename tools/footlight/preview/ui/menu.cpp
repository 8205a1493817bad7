#include "tools/footlight/preview/ui/menu.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/actions.h"
#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {
namespace {

void draw_rows(UiMenu menu, const UiDesk& desk, const OutputsView* outputs, std::optional<UiCall>& chosen) {
  for (const KeyRow& row : key_rows()) {
    if (row.menu != menu) continue;
    const bool checked = (row.call.action == UiAction::kHighlight && desk.highlights()) ||
                         (row.call.action == UiAction::kLocate && desk.locates()) ||
                         (row.call.action == UiAction::kHandles && desk.handles()) ||
                         (row.call.action == UiAction::kMeasure && desk.measure().on) ||
                         (row.call.action == UiAction::kFly && desk.fly().on()) ||
                         (row.call.action == UiAction::kFloorLines && desk.floor_lines());
    const std::string label = fmt::format("{}###{}", label_of(row, desk), row.keys);
    if (ImGui::MenuItem(label.c_str(), row.keys, checked, is_possible(row, desk, true, outputs))) chosen = row.call;
  }
}

void draw_recent(const UiDesk& desk, std::optional<UiCall>& chosen) {
  ui_text(kUiDim, "Open again");
  for (std::size_t i = 0; i < desk.recent_rigs().size(); ++i) {
    const std::string& path = desk.recent_rigs()[i];
    const std::string name = std::filesystem::path(path).filename().string();
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::MenuItem(name.c_str())) chosen = UiCall{UiAction::kOpenRecent, static_cast<int>(i)};
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", path.c_str());
    ImGui::PopID();
  }
}

void draw_panel_rows(const UiPanels& open, std::optional<UiCall>& chosen) {
  for (std::size_t i = 0; i < panels().size(); ++i) {
    if (ImGui::MenuItem(panels()[i].title, panels()[i].key_text, open.is_open(i))) {
      chosen = UiCall{UiAction::kPanel, static_cast<int>(i)};
    }
  }
}

struct Menu {
  const char* title;
  bool is_there;
  std::function<void()> draw;
};

// All menus fit beside each other in the side panel: with a log and outputs they are too wide otherwise. ImGui has
// twice the spacing between two menus.
ImVec2 menu_spacing(std::span<const Menu> menus) {
  float text_px = 0;
  int count = 0;
  for (const Menu& menu : menus) {
    if (!menu.is_there) continue;
    text_px += ImGui::CalcTextSize(menu.title).x;
    ++count;
  }
  const ImVec2 usual = ImGui::GetStyle().ItemSpacing;
  const float spare_px = ImGui::GetContentRegionAvail().x - text_px;
  return {std::clamp(spare_px / static_cast<float>(2 * count), 1.0f, usual.x), usual.y};
}

}  // namespace

std::optional<UiCall> draw_menu(const UiDesk& desk, const UiPanels& open, bool has_log, const OutputsView* outputs) {
  std::optional<UiCall> chosen;
  const auto rows = [&](UiMenu menu) { return [&, menu] { draw_rows(menu, desk, outputs, chosen); }; };
  const std::array<Menu, 6> menus{{{"File", !desk.recent_rigs().empty(), [&] { draw_recent(desk, chosen); }},
                                   {"Panels", true, [&] { draw_panel_rows(open, chosen); }},
                                   {"Edit", true, rows(UiMenu::kEdit)},
                                   {"View", true, rows(UiMenu::kView)},
                                   {"Play", has_log, rows(UiMenu::kPlayback)},
                                   {"Outputs", outputs != nullptr, rows(UiMenu::kOutputs)}}};
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, menu_spacing(menus));
  for (const Menu& menu : menus) {
    if (!menu.is_there || !ImGui::BeginMenu(menu.title)) continue;
    menu.draw();
    ImGui::EndMenu();
  }
  ImGui::PopStyleVar();
  return chosen;
}

}  // namespace footlight::tools

#include "tools/footlight/preview/ui/menu.h"

#include <algorithm>
#include <filesystem>
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

// All menus fit beside each other in the side panel: with a log and outputs they are too wide otherwise. ImGui has
// twice the spacing between two menus.
ImVec2 menu_spacing(bool has_files, bool has_log, bool has_outputs) {
  float text_px = 0;
  int count = 0;
  const auto add = [&](bool is_there, const char* title) {
    if (!is_there) return;
    text_px += ImGui::CalcTextSize(title).x;
    ++count;
  };
  add(has_files, "File");
  add(true, "Panels");
  add(true, "Edit");
  add(true, "View");
  add(has_log, "Play");
  add(has_outputs, "Outputs");
  const ImVec2 usual = ImGui::GetStyle().ItemSpacing;
  const float spare_px = ImGui::GetContentRegionAvail().x - text_px;
  return {std::clamp(spare_px / static_cast<float>(2 * count), 1.0f, usual.x), usual.y};
}

}  // namespace

std::optional<UiCall> draw_menu(const UiDesk& desk, const UiPanels& open, bool has_log, const OutputsView* outputs) {
  std::optional<UiCall> chosen;
  const bool has_files = !desk.recent_rigs().empty();
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, menu_spacing(has_files, has_log, outputs != nullptr));
  if (has_files && ImGui::BeginMenu("File")) {
    ui_text(kUiDim, "Open again");
    for (std::size_t i = 0; i < desk.recent_rigs().size(); ++i) {
      const std::string& path = desk.recent_rigs()[i];
      const std::string name = std::filesystem::path(path).filename().string();
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::MenuItem(name.c_str())) chosen = UiCall{UiAction::kOpenRecent, static_cast<int>(i)};
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", path.c_str());
      ImGui::PopID();
    }
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Panels")) {
    for (std::size_t i = 0; i < panels().size(); ++i) {
      if (ImGui::MenuItem(panels()[i].title, panels()[i].key_text, open.is_open(i))) {
        chosen = UiCall{UiAction::kPanel, static_cast<int>(i)};
      }
    }
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Edit")) {
    draw_rows(UiMenu::kEdit, desk, outputs, chosen);
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("View")) {
    draw_rows(UiMenu::kView, desk, outputs, chosen);
    ImGui::EndMenu();
  }
  if (has_log && ImGui::BeginMenu("Play")) {
    draw_rows(UiMenu::kPlayback, desk, outputs, chosen);
    ImGui::EndMenu();
  }
  if (outputs != nullptr && ImGui::BeginMenu("Outputs")) {
    draw_rows(UiMenu::kOutputs, desk, outputs, chosen);
    ImGui::EndMenu();
  }
  ImGui::PopStyleVar();
  return chosen;
}

}  // namespace footlight::tools

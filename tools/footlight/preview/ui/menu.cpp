#include "tools/footlight/preview/ui/menu.h"

#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

namespace footlight::tools {
namespace {

// "undo: set Pan of Spot 3"
std::string label_of(const KeyRow& row, const UiDesk& desk) {
  const UiCommand* command = row.call.action == UiAction::kUndo   ? desk.history().next_undo()
                             : row.call.action == UiAction::kRedo ? desk.history().next_redo()
                                                                  : nullptr;
  return command == nullptr ? row.does : fmt::format("{}: {}", row.does, text_of(*command, desk.rig()));
}

bool can(const KeyRow& row, const UiDesk& desk) {
  switch (row.call.action) {
    case UiAction::kUndo: return desk.history().next_undo() != nullptr;
    case UiAction::kRedo: return desk.history().next_redo() != nullptr;
    case UiAction::kSave: return desk.can_edit();
    case UiAction::kDelete: return desk.can_edit() && !desk.selected().empty();
    case UiAction::kReleaseAll: return !desk.state().taken.empty();
    case UiAction::kSelectAll: return !desk.rig().fixtures.empty();
    default: return true;
  }
}

bool can(const KeyRow& row, const OutputsView& outputs) {
  switch (row.call.action) {
    case UiAction::kEndBlackout: return outputs.darkness != Darkness::kNone;
    case UiAction::kDisarm: return outputs.live_count() > 0;
    default: return true;
  }
}

void draw_rows(UiMenu menu, const UiDesk& desk, std::optional<UiCall>& chosen) {
  for (const KeyRow& row : key_rows()) {
    if (row.menu != menu) continue;
    const bool checked = row.call.action == UiAction::kHighlight && desk.highlights();
    const std::string label = fmt::format("{}###{}", label_of(row, desk), row.keys);
    if (ImGui::MenuItem(label.c_str(), row.keys, checked, can(row, desk))) chosen = row.call;
  }
}

}  // namespace

std::optional<UiCall> draw_menu(const UiDesk& desk, const UiPanels& open, bool has_log, const OutputsView* outputs) {
  std::optional<UiCall> chosen;
  if (ImGui::BeginMenu("Panels")) {
    for (std::size_t i = 0; i < panels().size(); ++i) {
      if (ImGui::MenuItem(panels()[i].title, panels()[i].key_text, open.is_open(i))) {
        chosen = UiCall{UiAction::kPanel, static_cast<int>(i)};
      }
    }
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Edit")) {
    draw_rows(UiMenu::kEdit, desk, chosen);
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("View")) {
    draw_rows(UiMenu::kView, desk, chosen);
    ImGui::EndMenu();
  }
  if (has_log && ImGui::BeginMenu("Play")) {
    draw_rows(UiMenu::kPlayback, desk, chosen);
    ImGui::EndMenu();
  }
  if (outputs != nullptr && ImGui::BeginMenu("Outputs")) {
    for (const KeyRow& row : key_rows()) {
      if (row.menu != UiMenu::kOutputs) continue;
      if (ImGui::MenuItem(row.does, row.keys, false, can(row, *outputs))) chosen = row.call;
    }
    ImGui::EndMenu();
  }
  return chosen;
}

}  // namespace footlight::tools

#include "tools/footlight/preview/ui/actions.h"

#include <fmt/format.h>

#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

std::string label_of(const KeyRow& row, const UiDesk& desk) {
  if (row.call.action == UiAction::kFlashes) return trf("{} (now {})", tr(row.does), tr(word_of(desk.flashes())));
  const UiCommand* command = row.call.action == UiAction::kUndo   ? desk.history().next_undo()
                             : row.call.action == UiAction::kRedo ? desk.history().next_redo()
                                                                  : nullptr;
  return command == nullptr ? tr(row.does) : fmt::format("{}: {}", tr(row.does), text_of(*command, desk.rig()));
}

bool is_possible(const UiCall& call, UiMenu menu, const UiDesk& desk, bool has_log, const OutputsView* outputs) {
  if (menu == UiMenu::kPlayback && !has_log) return false;
  if (menu == UiMenu::kOutputs && outputs == nullptr) return false;
  switch (call.action) {
    case UiAction::kUndo: return desk.history().next_undo() != nullptr;
    case UiAction::kRedo: return desk.history().next_redo() != nullptr;
    case UiAction::kSave: return desk.can_edit();
    case UiAction::kStoreCamera: return desk.can_edit();
    case UiAction::kDelete: return desk.can_edit() && !desk.selected().empty();
    case UiAction::kNudge: return desk.can_edit() && !desk.selected().empty();
    case UiAction::kCompare: return !desk.compiled().universes.empty();
    case UiAction::kEndCompare: return desk.comparison().a.has_value();
    case UiAction::kReleaseAll: return !desk.state().taken.empty();
    case UiAction::kSelectAll: return !desk.rig().fixtures.empty();
    case UiAction::kEndBlackout: return is_blackout(outputs->darkness);
    case UiAction::kDisarm: return outputs->any_on();
    default: return true;
  }
}

std::vector<UiActionItem> action_items(const UiDesk& desk, bool has_log, const OutputsView* outputs) {
  constexpr int kDigits = 9;
  std::vector<UiActionItem> items;
  for (const KeyRow& row : key_rows()) {
    if (row.keys == nullptr) continue;
    if (row.call.action != UiAction::kCamera) {
      items.push_back(
          {row.call, label_of(row, desk), tr(row.keys), is_possible(row.call, row.menu, desk, has_log, outputs)});
      continue;
    }
    for (int i = 0; i < static_cast<int>(desk.cameras().size()); ++i) {
      items.push_back({{UiAction::kCamera, i},
                       trf("camera {}", desk.cameras()[static_cast<std::size_t>(i)].name),
                       i < kDigits ? std::to_string(i + 1) : std::string()});
    }
  }
  for (const CommandRow& row : command_rows()) {
    items.push_back({row.call, tr(row.does), {}, is_possible(row.call, row.menu, desk, has_log, outputs)});
  }
  for (std::size_t i = 0; i < panels().size(); ++i) {
    const PanelInfo& panel = panels()[i];
    items.push_back({{UiAction::kPanel, static_cast<int>(i)},
                     trf("panel {}: {}", tr(panel.title), tr(panel.shows)),
                     tr(panel.key_text)});
  }
  for (std::size_t i = 0; i < desk.recent_rigs().size(); ++i) {
    items.push_back({{UiAction::kOpenRecent, static_cast<int>(i)}, trf("open {}", desk.recent_rigs()[i]), {}});
  }
  for (std::size_t i = 0; has_log && i < desk.state().markers.size(); ++i) {
    const Marker& marker = desk.state().markers[i];
    items.push_back({{UiAction::kMarker, static_cast<int>(i)}, trf("marker {}", marker.name), time_text(marker.at_ns)});
  }
  return items;
}

}  // namespace footlight::tools

#include "tools/footlight/preview/ui/actions.h"

#include <iterator>

#include <fmt/format.h>

#include "render/display.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

std::string label_of(const KeyRow& row, const UiDesk& desk) {
  if (row.call.action == UiAction::kLock) return desk.locked() ? tr("unlock: edits and levels") : tr(row.does);
  if (row.call.action == UiAction::kFlashes) return trf("{} (now {})", tr(row.does), tr(word_of(desk.flashes())));
  const UiCommand* command = row.call.action == UiAction::kUndo   ? desk.history().next_undo()
                             : row.call.action == UiAction::kRedo ? desk.history().next_redo()
                                                                  : nullptr;
  return command == nullptr ? tr(row.does) : fmt::format("{}: {}", tr(row.does), text_of(*command, desk.rig()));
}

namespace {

UiMenu menu_of(UiAction action) {
  for (const KeyRow& row : key_rows()) {
    if (row.call.action == action && row.menu != UiMenu::kNone) return row.menu;
  }
  for (const CommandRow& row : command_rows()) {
    if (row.call.action == action) return row.menu;
  }
  return UiMenu::kNone;
}

std::string when(bool impossible, const char* reason) { return impossible ? reason : std::string(); }

std::string why_not_edited(const UiDesk& desk, bool needs_selection) {
  if (!desk.can_edit()) return tr("this rig cannot be edited");
  return when(needs_selection && desk.selected().empty(), tr("select a fixture first"));
}

// What a locked window refuses. Blackouts, outputs, cameras, the timeline and panels are not among it.
bool is_locked_away(const UiCall& call, const UiDesk& desk) {
  switch (call.action) {
    case UiAction::kUndo: return desk.locks(desk.history().next_undo());
    case UiAction::kRedo: return desk.locks(desk.history().next_redo());
    case UiAction::kOpen:
    case UiAction::kOpenRecent:
    case UiAction::kOpenRecentLog:
    case UiAction::kDelete:
    case UiAction::kUnpatch:
    case UiAction::kEditField:
    case UiAction::kNudge:
    case UiAction::kStoreCamera:
    case UiAction::kHighlight:
    case UiAction::kLocate:
    case UiAction::kReleaseAll:
    case UiAction::kTap: return desk.locked();
    default: return false;
  }
}

std::string why_not_exposed(const UiDesk& desk, bool brighter) {
  const Exposure& exposure = desk.state().exposure;
  if (exposure.automatic) return tr("the exposure is automatic");
  return when(brighter ? exposure.ev <= kBrightestEv : exposure.ev >= kDarkestEv, tr("the exposure ends here"));
}

}  // namespace

std::string why_not(const UiCall& call, const UiDesk& desk, bool has_log, const OutputsView* outputs) {
  if (is_locked_away(call, desk)) return locked_words();
  const UiMenu menu = menu_of(call.action);
  if (menu == UiMenu::kPlayback && !has_log) return tr("no log plays: drop one on the window, or start with --log");
  if (menu == UiMenu::kOutputs && outputs == nullptr) {
    return tr("there is no output to real lamps; F6 or --output ENDPOINT adds one");
  }
  switch (call.action) {
    case UiAction::kUndo: return when(desk.history().next_undo() == nullptr, tr("nothing to undo"));
    case UiAction::kRedo: return when(desk.history().next_redo() == nullptr, tr("nothing to redo"));
    case UiAction::kSave:
    case UiAction::kSaveAs:
    case UiAction::kStoreCamera:
    case UiAction::kLibrary: return why_not_edited(desk, false);
    case UiAction::kDelete:
    case UiAction::kEditField:
    case UiAction::kUnpatch:
    case UiAction::kNudge: return why_not_edited(desk, true);
    case UiAction::kHighlight: return when(desk.selected().empty() && !desk.highlights(), tr("select a fixture first"));
    case UiAction::kLocate: return when(desk.selected().empty() && !desk.locates(), tr("select a fixture first"));
    case UiAction::kCompareStage:
    case UiAction::kCompare: return when(desk.compiled().universes.empty(), tr("no fixture of the rig has an address"));
    case UiAction::kEndCompare: return when(!desk.comparison().a, tr("no moments are compared"));
    case UiAction::kReleaseAll: return when(desk.state().taken.empty(), tr("nothing is taken over"));
    case UiAction::kSelectAll: return when(desk.rig().fixtures.empty(), tr("the rig has no fixture"));
    case UiAction::kCamera: {
      const bool is_there = call.argument < static_cast<int>(desk.cameras().size());
      return when(!is_there, tr("the rig has no such camera; C stores one"));
    }
    case UiAction::kBrighter: return why_not_exposed(desk, true);
    case UiAction::kDarker: return why_not_exposed(desk, false);
    case UiAction::kTone: {
      const bool same = desk.state().look.tone == render::kToneCurves[static_cast<std::size_t>(call.argument)];
      return when(same, tr("the picture has it"));
    }
    case UiAction::kEndBlackout: return when(!is_blackout(outputs->darkness), tr("there is no blackout"));
    case UiAction::kDisarm: return when(!outputs->any_on(), tr("no output is armed"));
    default: return "";
  }
}

std::vector<UiActionItem> action_items(const UiDesk& desk, bool has_log, const OutputsView* outputs) {
  constexpr int kDigits = 9;
  std::vector<UiActionItem> items;
  for (const KeyRow& row : key_rows()) {
    if (row.keys == nullptr) continue;
    if (row.call.action != UiAction::kCamera) {
      items.push_back({row.call, label_of(row, desk), tr(row.keys), why_not(row.call, desk, has_log, outputs)});
      continue;
    }
    for (int i = 0; i < static_cast<int>(desk.cameras().size()); ++i) {
      items.push_back({{UiAction::kCamera, i},
                       trf("camera {}", desk.cameras()[static_cast<std::size_t>(i)].name),
                       i < kDigits ? std::to_string(i + 1) : std::string()});
    }
  }
  for (const CommandRow& row : command_rows()) {
    items.push_back({row.call, tr(row.does), {}, why_not(row.call, desk, has_log, outputs)});
  }
  for (std::size_t i = 0; i < std::size(render::kToneCurves); ++i) {
    const UiCall call{UiAction::kTone, static_cast<int>(i)};
    items.push_back({call,
                     trf("tone curve {}", render::word_of(render::kToneCurves[i])),
                     {},
                     why_not(call, desk, has_log, outputs)});
  }
  for (std::size_t i = 0; i < quality_choices().size(); ++i) {
    const QualityChoice& choice = quality_choices()[i];
    items.push_back({{UiAction::kQuality, static_cast<int>(i)},
                     choice.error > 0 ? trf("quality: error of {} %", 100 * choice.error)
                     : choice.ms > 0  ? trf("quality: {} ms a picture", choice.ms)
                                      : std::string(tr("quality by hand")),
                     {},
                     {}});
  }
  for (std::size_t i = 0; i < panels().size(); ++i) {
    const PanelInfo& panel = panels()[i];
    items.push_back({{UiAction::kPanel, static_cast<int>(i)},
                     trf("panel {}: {}", tr(panel.title), tr(panel.shows)),
                     tr(panel.key_text)});
  }
  for (std::size_t i = 0; i < desk.recent_rigs().size(); ++i) {
    const UiCall call{UiAction::kOpenRecent, static_cast<int>(i)};
    items.push_back({call, trf("open {}", desk.recent_rigs()[i]), {}, why_not(call, desk, has_log, outputs)});
  }
  for (std::size_t i = 0; i < desk.recent_logs().size(); ++i) {
    const UiCall call{UiAction::kOpenRecentLog, static_cast<int>(i)};
    items.push_back({call, trf("open {}", desk.recent_logs()[i]), {}, why_not(call, desk, has_log, outputs)});
  }
  for (std::size_t i = 0; has_log && i < desk.state().markers.size(); ++i) {
    const Marker& marker = desk.state().markers[i];
    items.push_back({{UiAction::kMarker, static_cast<int>(i)}, trf("marker {}", marker.name), time_text(marker.at_ns)});
  }
  return items;
}

}  // namespace footlight::tools

#include "tools/footlight/preview/ui/run_action.h"

#include <cstddef>

#include "render/display.h"
#include "tools/footlight/preview/ui/rig_editor.h"
#include "tools/footlight/preview/ui/stage_handles.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

ActionNews show_handles(UiDesk& desk) {
  desk.set_handles(!desk.handles());
  return {desk.handles() && desk.selected().empty() ? tr("handles: select a fixture to see them") : "", false};
}

ActionNews set_tone(UiDesk& desk, int index) {
  PictureLook look = desk.state().look;
  look.tone = render::kToneCurves[static_cast<std::size_t>(index)];
  desk.set_look(look);
  return {trf("tone curve {}", render::word_of(look.tone)), false};
}

std::optional<ActionNews> select_all(UiDesk& desk) {
  desk.select_all();
  if (!desk.lists_some()) return ActionNews{};
  const std::size_t all = desk.rig().fixtures.size();
  return ActionNews{trf_n("selected {} of {} fixture, which the filter lists",
                          "selected {} of {} fixtures, which the filter lists", all,
                          desk.state().selection.fixtures.size(), all),
                    false};
}

}  // namespace

std::optional<ActionNews> run_on_desk(UiDesk& desk, const UiCall& call) {
  switch (call.action) {
    case UiAction::kDelete: return ActionNews{delete_selected(desk), false};
    case UiAction::kUnpatch: return ActionNews{unpatch_selected(desk), false};
    case UiAction::kSelectAll: return select_all(desk);
    case UiAction::kLock:
      desk.set_locked(!desk.locked());
      return ActionNews{desk.locked() ? locked_words() : tr("unlocked"), false};
    case UiAction::kHandles: return show_handles(desk);
    case UiAction::kNudge:
      return ActionNews{nudge_selected(desk, nudge_axis(call.argument), nudge_sign(call.argument) * kNudgeM), true};
    case UiAction::kHighlight: desk.set_highlight(!desk.highlights()); break;
    case UiAction::kLocate: desk.set_locate(!desk.locates()); break;
    case UiAction::kReleaseAll: desk.release_all(); break;
    case UiAction::kMeasure: desk.measure() = {!desk.measure().on, {}, {}}; break;
    case UiAction::kFloorLines: desk.set_floor_lines(!desk.floor_lines()); break;
    case UiAction::kEndCompare: desk.comparison() = {}; break;
    case UiAction::kFly: desk.fly().set_on(!desk.fly().on()); break;
    case UiAction::kFlashes:
      desk.set_flashes(next_of(desk.flashes()));
      return ActionNews{trf("harmful flashes: {}", tr(words_of(desk.flashes()))), false};
    case UiAction::kTone: return set_tone(desk, call.argument);
    default: return std::nullopt;
  }
  return ActionNews{};
}

}  // namespace footlight::tools

#include "tools/footlight/preview/ui/draw_compare.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "sim/core/counted.h"
#include "tools/footlight/preview/ui/slot_names.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

std::optional<TimeNs> log_time(const UiInput& input) {
  return input.transport != nullptr ? input.transport->levels_ns() : std::nullopt;
}

// Another log: its name, its time, and how far it is ahead of the window.
void draw_log(KeptLevels& kept, float scale) {
  ui_text(kept.log);
  ImGui::SameLine(0, 4);
  ui_text(kUiDim, kept.when);
  ImGui::SameLine(0, 4);
  ImGui::SetNextItemWidth(84 * scale);
  auto offset_s = static_cast<float>(static_cast<double>(kept.offset_ns) * 1e-9);
  if (ImGui::DragFloat("##offset", &offset_s, 0.02f, -36000, 36000, "%+.2f s")) {
    kept.offset_ns = std::llround(static_cast<double>(std::clamp(offset_s, -36000.0f, 36000.0f)) * 1e9);
  }
  if (ImGui::IsItemHovered()) {
    ImGui::SetTooltip("%s", tr("The time of this log is later by so much. A click with Ctrl lets it be typed."));
  }
}

// The button that goes to where a kept moment is in the log.
void draw_go(const UiInput& input, const KeptLevels& kept) {
  if (input.transport == nullptr || !kept.log_ns) return;
  ImGui::SameLine(0, 2);
  if (ImGui::SmallButton(tr_label("go"))) input.transport->seek_ns = *kept.log_ns;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("The log goes to this time."));
}

}  // namespace

// Another log is compared in its universes alone: those that were made up for faders are in no log.
MomentDifference CompareView::of(const KeptLevels& a, const LevelView& b) {
  if (a.log.empty() || std::equal(b.universes.begin(), b.universes.end(), a.moment.universes.begin(),
                                  a.moment.universes.end())) {
    return compare_moments(a.moment, b);
  }
  return compare_moments(a.moment, only_of(b, a.moment.universes));
}

bool CompareView::take(const UiDesk& desk, const UiInput& input, bool frozen) {
  const LevelComparison& both = desk.comparison();
  if (!both.a || both.b) {
    difference_ = both.a ? of(*both.a, both.b->moment) : MomentDifference{};
    a_.reset();
    return false;
  }
  if (frozen && a_ && !both.a->log.empty()) return false;
  const bool same = a_ && *a_ == both.a->moment;
  if (frozen && same) return false;
  difference_ = of(*both.a, LevelView(desk.compiled().universes, input.levels));
  if (!same) a_ = both.a->moment;
  return frozen;
}

void CompareView::draw_row(UiDesk& desk, const UiInput& input, Universe universe) {
  LevelComparison& both = desk.comparison();
  if (!both.a) return;
  const auto keep = [&] { return keep_levels(desk.compiled().universes, input.levels, log_time(input)); };
  ImGui::PushID("a");
  ui_text(kUiAmber, "A");
  ImGui::SameLine(0, 4);
  if (both.a->log.empty()) {
    ui_text(both.a->when);
  } else {
    draw_log(*both.a, input.scale);
  }
  ImGui::SameLine(0, 4);
  if (ImGui::SmallButton(tr_label("here"))) both.a = keep();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("A is this moment."));
  draw_go(input, *both.a);
  ImGui::PopID();
  ImGui::SameLine(0, 14 * input.scale);
  ImGui::PushID("b");
  ui_text(kUiAmber, "B");
  ImGui::SameLine(0, 4);
  ui_text(both.b ? both.b->when : tr("now"));
  ImGui::SameLine(0, 4);
  if (ImGui::SmallButton(tr_label("here"))) both.b = keep();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("B is this moment, and stays it."));
  if (both.b) {
    draw_go(input, *both.b);
    ImGui::SameLine(0, 2);
    if (ImGui::SmallButton(tr_label("now"))) both.b.reset();
  }
  ImGui::PopID();
  ImGui::SameLine(0, 14 * input.scale);
  const std::size_t all = difference_.slots.size();
  const std::string words = all == 0 ? tr("no slot differs")
                                     : trf_n("{} slot differs, {} in universe {}", "{} slots differ, {} in universe {}",
                                             all, all, difference_.slots_of(universe), universe);
  ui_text(all > 0 ? kUiAmber : kUiGreen, words);
  ImGui::SameLine();
  if (ImGui::SmallButton(tr_label("end"))) both = {};
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("Ends the comparison (Shift+K)."));
}

void CompareView::draw_list(UiDesk& desk, float height, std::size_t& shown) const {
  constexpr ImGuiTableFlags kFlags =
      ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg | ImGuiTableFlags_Resizable | ImGuiTableFlags_BordersInnerV;
  if (!ImGui::BeginTable("differences", 5, kFlags, {0, height})) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  ImGui::TableSetupColumn(tr("Slot"), ImGuiTableColumnFlags_WidthStretch, 0.6f);
  ImGui::TableSetupColumn(tr("Fixture"), ImGuiTableColumnFlags_WidthStretch, 1.4f);
  ImGui::TableSetupColumn(tr("Parameter"), ImGuiTableColumnFlags_WidthStretch, 1.6f);
  ImGui::TableSetupColumn("A", ImGuiTableColumnFlags_WidthStretch, 0.4f);
  ImGui::TableSetupColumn("B", ImGuiTableColumnFlags_WidthStretch, 0.8f);
  ImGui::TableHeadersRow();
  const auto& universes = desk.compiled().universes;
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(difference_.slots.size()));
  while (clipper.Step()) {
    for (int row = clipper.DisplayStart; row < clipper.DisplayEnd; ++row) {
      const SlotDifference& one = difference_.slots[static_cast<std::size_t>(row)];
      const auto at = std::lower_bound(universes.begin(), universes.end(), one.universe);
      const bool known = at != universes.end() && *at == one.universe;
      const auto universe = static_cast<std::size_t>(at - universes.begin());
      std::vector<SlotName> names;
      if (known) {
        names = names_of_slot(desk.rig(), desk.compiled(), desk.index(), universe,
                              static_cast<std::size_t>(slot_of_address(one.address)));
      }
      ImGui::PushID(row);
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      const std::string slot = fmt::format("{}.{}", one.universe, one.address);
      const bool marked = std::any_of(names.begin(), names.end(),
                                      [&](const SlotName& name) { return desk.state().selection.has(name.index); });
      if (ImGui::Selectable(slot.c_str(), marked, ImGuiSelectableFlags_SpanAllColumns)) {
        if (known) shown = universe;
        if (!names.empty()) desk.select(names.front().index, ImGui::GetIO().KeyCtrl);
      }
      ImGui::TableNextColumn();
      ui_text(names.empty() ? "" : names.front().fixture);
      ImGui::TableNextColumn();
      ui_text(names.empty() ? "" : names.front().parameter);
      ImGui::TableNextColumn();
      ui_text(fmt::format("{}", one.a));
      ImGui::TableNextColumn();
      ui_text(fmt::format("{} ({:+})", one.b, one.b - one.a));
      ImGui::PopID();
    }
  }
  ImGui::EndTable();
}

}  // namespace footlight::tools

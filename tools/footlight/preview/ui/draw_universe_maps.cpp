#include "tools/footlight/preview/ui/draw_universe_maps.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/level_source.h"
#include "tools/footlight/preview/ui/slot_tip.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr int kMapColumns = 32;
constexpr int kMapRows = kSlotCountMax / kMapColumns;

ImVec4 between(const ImVec4& a, const ImVec4& b, float share) {
  return {a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share, a.z + (b.z - a.z) * share, 1};
}

}  // namespace

void draw_slot_tip(UiDesk& desk, const UiInput& input, std::size_t universe, std::size_t slot,
                   const SlotChanges& changes, TimeNs now_ns, const std::string& more) {
  const SlotTip tip = tip_of_slot(desk, input, universe, slot, changes, now_ns);
  ImGui::BeginTooltip();
  ui_text(tip.level);
  for (const std::string& line : tip.means) ui_text(kUiAmber, line);
  if (tip.means.empty()) ui_text(kUiDim, tr("no fixture and no display uses this slot"));
  ui_text(kUiDim, trf("from {}", tip.from));
  if (!tip.ages.empty()) ui_text(kUiDim, tip.ages);
  if (!more.empty()) ui_text(ui_colours.differs, more);
  ImGui::EndTooltip();
}

// Of one map: without its title.
struct UniverseMaps::Place {
  ImVec2 low;
  ImVec2 cell;
};

// The levels of the page: of the kept moment B if there is one.
void UniverseMaps::take(const UiDesk& desk, const UiInput& input, bool frozen) {
  const auto& universes = desk.compiled().universes;
  const std::size_t count = std::min(universes.size() - first_, kOnPage);
  const auto page = std::span(universes).subspan(first_, count);
  const bool fresh = !taken_ || !std::equal(page.begin(), page.end(), taken_->begin(), taken_->end());
  const auto& b = desk.comparison().b;
  const bool keeps = b && desk.comparison().a;
  if (frozen && !fresh && !keeps) return;
  if (fresh || keeps) maps_.assign(count, {});
  maps_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (keeps) {
      const auto levels = LevelView(b->moment).of(universes[first_ + i]);
      std::copy(levels.begin(), levels.end(), maps_[i].levels.begin());
      continue;
    }
    const std::size_t from = (first_ + i) * kSlotCountMax;
    if (from + kSlotCountMax > input.levels.size()) continue;
    maps_[i].take(input.levels.subspan(from, kSlotCountMax), input.now_ns, fresh);
  }
  now_ns_ = input.now_ns;
  taken_.reset();  // what comes after a kept moment begins anew
  if (!keeps) taken_.emplace(page.begin(), page.end());
}

void UniverseMaps::draw_map(UiDesk& desk, const UiInput& input, std::size_t index, const Place& place) const {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const std::size_t universe = first_ + index;
  const SlotChanges& map = maps_[index];
  const ImVec2 size{place.cell.x * kMapColumns, place.cell.y * kMapRows};
  draw.AddRectFilled(place.low, {place.low.x + size.x, place.low.y + size.y}, ImGui::GetColorU32(ui_colours.ground));
  const UiState& state = desk.state();
  for (int slot = 0; slot < kSlotCountMax; ++slot) {
    const auto at = static_cast<std::size_t>(slot);
    const auto uses = desk.index().uses(universe, at);
    const float heat = map.heat(at, now_ns_);
    if (uses.empty() && map.levels[at] == 0 && heat == 0) continue;
    const int row = slot / kMapColumns;
    const ImVec2 low{place.low.x + place.cell.x * static_cast<float>(slot % kMapColumns),
                     place.low.y + place.cell.y * static_cast<float>(row)};
    const ImVec2 high{low.x + std::max(place.cell.x - 1, 1.0f), low.y + std::max(place.cell.y - 1, 1.0f)};
    const ImVec4& ground = uses.empty()                        ? ui_colours.ground
                           : uses.front().key.fixture % 2 == 0 ? ui_colours.even
                                                               : ui_colours.odd;
    const float level = static_cast<float>(map.levels[at]) / 255;
    // The colour has the level: as a bar of the grid, but for its height.
    const ImVec4 lit = between(ui_colours.bar, ui_colours.hot, heat);
    draw.AddRectFilled(low, high, ImGui::GetColorU32(between(ground, lit, std::max(std::sqrt(level), 0.5f * heat))));
    const bool selected =
        !state.selection.fixtures.empty() &&
        std::any_of(uses.begin(), uses.end(), [&](const SlotUse& use) { return state.selection.has(use.key.fixture); });
    if (selected) draw.AddRectFilled({low.x, high.y - 1.5f}, high, ImGui::GetColorU32(kUiAmber));
  }
  if (source_of_universe(desk, input, universe).silent) {
    draw.AddRect(place.low, {place.low.x + size.x, place.low.y + size.y}, ImGui::GetColorU32(kUiRed));
  }
}

std::optional<std::size_t> UniverseMaps::draw(UiDesk& desk, const UiInput& input, bool frozen,
                                              const MomentDifference& difference) {
  const auto& universes = desk.compiled().universes;
  if (first_ >= universes.size()) first_ = 0;
  take(desk, input, frozen);
  const int count = static_cast<int>(maps_.size());
  const int columns = count <= 1 ? 1 : count <= 4 ? 2 : 3;
  const int rows = (count + columns - 1) / columns;
  const float line = ImGui::GetTextLineHeight();
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float gap = 0.6f * line;
  const ImVec2 cell{
      std::max((room.x - gap * static_cast<float>(columns - 1)) / static_cast<float>(columns * kMapColumns), 2.0f),
      std::max((room.y / static_cast<float>(rows) - line - gap) / kMapRows, 2.0f)};
  std::optional<std::size_t> clicked;
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const std::size_t universe = first_ + index;
    const int map_row = i / columns;
    const ImVec2 corner{at.x + static_cast<float>(i % columns) * (cell.x * kMapColumns + gap),
                        at.y + static_cast<float>(map_row) * (cell.y * kMapRows + line + gap)};
    const Place place{{corner.x, corner.y + line}, cell};
    const auto lit = std::count_if(maps_[index].levels.begin(), maps_[index].levels.end(),
                                   [](std::uint8_t level) { return level > 0; });
    const int differ = difference.slots_of(universes[universe]);
    const std::string title = differ > 0 ? trf("universe {}: {} differ", universes[universe], differ)
                                         : trf("universe {}: {} not 0", universes[universe], lit);
    ImGui::SetCursorScreenPos(corner);
    ui_text(title);
    ImGui::SetCursorScreenPos(place.low);
    ImGui::PushID(i);
    if (ImGui::InvisibleButton("map", {cell.x * kMapColumns, cell.y * kMapRows})) clicked = universe;
    const bool hovered = ImGui::IsItemHovered();
    ImGui::PopID();
    draw_map(desk, input, index, place);
    if (!hovered) continue;
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const int column = static_cast<int>(std::floor((mouse.x - place.low.x) / cell.x));
    const int row = static_cast<int>(std::floor((mouse.y - place.low.y) / cell.y));
    if (column < 0 || column >= kMapColumns || row < 0 || row >= kMapRows) continue;
    draw_slot_tip(desk, input, universe, static_cast<std::size_t>(row * kMapColumns + column), maps_[index], now_ns_,
                  "");
  }
  return clicked;
}

}  // namespace footlight::tools

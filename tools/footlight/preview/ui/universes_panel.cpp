// The levels of one universe as a grid: what each slot is for, how high it is and when it last changed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "fixtures/displays/pixel_slots.h"
#include "tools/footlight/monitor/slot_changes.h"
#include "tools/footlight/preview/ui/draw_compare.h"
#include "tools/footlight/preview/ui/draw_universe_maps.h"
#include "tools/footlight/preview/ui/draw_unpatched.h"
#include "tools/footlight/preview/ui/level_source.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/slot_names.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr int kColumns = 32;
constexpr int kRows = kSlotCountMax / kColumns;

ImU32 mixed(const ImVec4& a, const ImVec4& b, float share) {
  return ImGui::GetColorU32({a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share, a.z + (b.z - a.z) * share, 1});
}

// "0" to "255".
const std::array<std::array<char, 4>, 256>& level_words() {
  static const auto kWords = [] {
    std::array<std::array<char, 4>, 256> words{};
    for (std::size_t i = 0; i < words.size(); ++i) (void)std::snprintf(words[i].data(), 4, "%d", static_cast<int>(i));
    return words;
  }();
  return kWords;
}

class UniversesPanel final : public Panel {
 public:
  void draw(UiDesk& desk, const UiInput& input) override {
    const auto& universes = desk.compiled().universes;
    if (universes.empty()) {
      ui_text(kUiDim, tr("No fixture of this rig has an address."));
      return;
    }
    shown_ = std::min(shown_, universes.size() - 1);
    draw_choice(desk, input);
    unpatched_.draw_choice(input);
    if (unpatched_.shows()) return unpatched_.draw(input, frozen_);
    if (compare_.take(desk, input, frozen_)) fresh_ = true;  // the grid shows the levels that were compared
    if (nine_ && universes.size() > 1) return draw_nine(desk, input);
    take(desk, input);
    draw_source(desk, input);
    compare_.draw_row(desk, input, universes[shown_]);
    const bool lists = desk.comparison().a && !compare_.difference().slots.empty();
    const float list = lists ? std::max(ImGui::GetContentRegionAvail().y * 0.38f, 4 * ImGui::GetTextLineHeight()) : 0;
    const std::optional<std::size_t> under = draw_grid(desk, input, list);
    draw_slot(desk, under.value_or(last_under_));
    if (under) last_under_ = *under;
    const std::size_t before = shown_;
    if (lists) compare_.draw_list(desk, list, shown_);
    if (shown_ != before) fresh_ = true;
  }

 private:
  void draw_choice(UiDesk& desk, const UiInput& input) {
    const auto& universes = desk.compiled().universes;
    const std::size_t before = shown_;
    const std::size_t step = nine_ ? UniverseMaps::kOnPage : 1;
    if (ImGui::ArrowButton("before", ImGuiDir_Left)) shown_ -= std::min(shown_, step);
    ImGui::SameLine(0, 2);
    ImGui::SetNextItemWidth(120 * input.scale);
    if (ImGui::BeginCombo("##universe", trf("universe {}", universes[shown_]).c_str())) {
      ImGuiListClipper clipper;
      clipper.Begin(static_cast<int>(universes.size()));
      while (clipper.Step()) {
        for (auto i = static_cast<std::size_t>(clipper.DisplayStart); i < static_cast<std::size_t>(clipper.DisplayEnd);
             ++i) {
          const int differ = compare_.difference().slots_of(universes[i]);
          const std::string name =
              differ > 0 ? trf("universe {}: {} differ", universes[i], differ) : trf("universe {}", universes[i]);
          if (ImGui::Selectable(name.c_str(), i == shown_)) shown_ = i;
        }
      }
      ImGui::EndCombo();
    }
    ImGui::SameLine(0, 2);
    if (ImGui::ArrowButton("after", ImGuiDir_Right)) shown_ = std::min(shown_ + step, universes.size() - 1);
    ImGui::SameLine();
    ImGui::Checkbox(tr_label("freeze"), &frozen_);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("Keeps what is shown. The picture goes on."));
    if (!desk.comparison().a) {
      ImGui::SameLine();
      if (ImGui::Button(tr_label("compare with now (K)"))) {
        const auto log_ns = input.transport != nullptr ? input.transport->levels_ns() : std::nullopt;
        desk.comparison().a = keep_levels(universes, input.levels, log_ns);
      }
      if (ImGui::IsItemHovered())
        ImGui::SetTooltip("%s", tr("Keeps this moment, and marks the slots that differ from it."));
    }
    if (universes.size() > 1) {
      ImGui::SameLine();
      if (ImGui::Checkbox(tr_label("nine at once"), &nine_)) fresh_ = true;
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("Maps of nine universes. A click on one shows it alone."));
    }
    if (shown_ == before) return;
    fresh_ = true;
    unpatched_.leave();
  }

  void draw_nine(UiDesk& desk, const UiInput& input) {
    compare_.draw_row(desk, input, desk.compiled().universes[shown_]);
    maps_.turn_to(shown_);
    const auto clicked = maps_.draw(desk, input, frozen_, compare_.difference());
    if (!clicked) return;
    shown_ = *clicked;
    nine_ = false;
    fresh_ = true;
  }

  // The levels of the grid: of the kept moment B if there is one.
  void take(const UiDesk& desk, const UiInput& input) {
    if (const auto& b = desk.comparison().b; b && desk.comparison().a) {
      changes_ = {};
      const auto levels = LevelView(b->moment).of(desk.compiled().universes[shown_]);
      std::copy(levels.begin(), levels.end(), changes_.levels.begin());
      fresh_ = true;  // what comes after it begins anew
      return;
    }
    if (frozen_ && !fresh_) return;
    const std::size_t from = shown_ * kSlotCountMax;
    if (from + kSlotCountMax > input.levels.size()) return;
    if (fresh_) changes_ = {};
    changes_.take(input.levels.subspan(from, kSlotCountMax), input.now_ns, fresh_);
    now_ns_ = input.now_ns;
    fresh_ = false;
  }

  // Who sends the universe, and how old its newest frame is.
  void draw_source(const UiDesk& desk, const UiInput& input) const {
    const LevelSource source = source_of_universe(desk, input, shown_);
    if (shown_ >= input.stamps.size()) return ui_text(kUiDim, source.words);
    if (source.kind == SourceKind::kNobody) return ui_text(kUiAmber, source.words);
    ui_text(source.silent ? kUiRed : kUiGreen, source.silent   ? tr("no signal since")
                                               : source.rarely ? tr("last change")
                                                               : tr("last frame"));
    ImGui::SameLine(0, 4);
    ui_text(fmt::format("{:.1f} s", static_cast<double>(source.age_ns) * 1e-9));
    ImGui::SameLine();
    ui_text(kUiDim, source.words);
  }

  // The slot under the mouse.
  std::optional<std::size_t> draw_grid(UiDesk& desk, const UiInput& input, float below) {
    const float line = ImGui::GetTextLineHeight();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float head = line * 2.2f;  // the address of the first slot of a row
    const float width = std::max(std::floor((room.x - head) / kColumns), 4.0f);
    const float height = std::clamp(std::floor((room.y - below - 2 * line - 8) / kRows), 5.0f, line * 1.8f);
    ImGui::InvisibleButton("grid", {head + width * kColumns, height * kRows});
    std::optional<std::size_t> under;
    if (ImGui::IsItemHovered()) {
      const ImVec2 mouse = ImGui::GetIO().MousePos;
      const int column = static_cast<int>(std::floor((mouse.x - at.x - head) / width));
      const int row = static_cast<int>((mouse.y - at.y) / height);
      if (column >= 0 && column < kColumns && row >= 0 && row < kRows) {
        under = static_cast<std::size_t>(row * kColumns + column);
      }
      if (under && ImGui::IsItemClicked()) {
        const auto uses = desk.index().uses(shown_, *under);
        const ImGuiIO& io = ImGui::GetIO();
        desk.select(uses.empty() ? -1 : uses.front().key.fixture, io.KeyCtrl || io.KeyShift);
      }
    }
    if (under) draw_slot_tip(desk, input, shown_, *under, changes_, now_ns_, difference_words(desk, *under));
    ImDrawList* draw = ImGui::GetWindowDrawList();
    const float size = ImGui::GetFontSize() * 0.8f;
    const bool numbers = width >= size * 2 && height >= size;
    const bool heads = height >= size;
    for (int row = 0; row < kRows; ++row) {
      if (!heads && row % 4 != 0) continue;
      const std::string address = fmt::format("{}", row * kColumns + 1);
      draw->AddText(ImGui::GetFont(), size, {at.x, at.y + static_cast<float>(row) * height}, ImGui::GetColorU32(kUiDim),
                    address.c_str());
    }
    for (int slot = 0; slot < kSlotCountMax; ++slot) {
      const int row = slot / kColumns;
      const int column = slot % kColumns;
      const ImVec2 low{at.x + head + static_cast<float>(column) * width, at.y + static_cast<float>(row) * height};
      draw_cell(desk, *draw, static_cast<std::size_t>(slot), low, {width, height}, numbers ? size : 0);
    }
    return under;
  }

  // The level of a slot in the kept moment A; nothing if it does not differ.
  [[nodiscard]] std::optional<std::uint8_t> other_level(const UiDesk& desk, std::size_t slot) const {
    if (!desk.comparison().a) return std::nullopt;
    const auto levels = LevelView(desk.comparison().a->moment).of(desk.compiled().universes[shown_]);
    const std::uint8_t level = levels.empty() ? std::uint8_t{0} : levels[slot];
    return level != changes_.levels[slot] ? std::optional(level) : std::nullopt;
  }

  [[nodiscard]] std::string difference_words(const UiDesk& desk, std::size_t slot) const {
    const auto other = other_level(desk, slot);
    if (!other) return "";
    return trf("A {}, B {} ({:+})", *other, changes_.levels[slot], changes_.levels[slot] - *other);
  }

  // A slot: a bar as high as its level, brighter where it changed; frames for what is selected, taken over or shared.
  void draw_cell(UiDesk& desk, ImDrawList& draw, std::size_t slot, ImVec2 low, ImVec2 size, float text_size) const {
    const auto uses = desk.index().uses(shown_, slot);
    const auto pixels = pixels_of(desk, slot);
    const std::uint8_t level = changes_.levels[slot];
    const float heat = changes_.heat(slot, now_ns_);
    const ImVec2 high{low.x + size.x - 1, low.y + size.y - 1};
    const bool used = !uses.empty() || !pixels.empty();
    const int user = !uses.empty() ? uses.front().key.fixture : used ? pixels.front().column : 0;
    const ImVec4& ground = !used ? ui_colours.ground : user % 2 == 0 ? ui_colours.even : ui_colours.odd;
    draw.AddRectFilled(low, high, ImGui::GetColorU32(ground));
    if (level > 0) {
      const float top = high.y - (high.y - low.y) * static_cast<float>(level) / 255;
      draw.AddRectFilled({low.x, top}, high, mixed(ui_colours.bar, ui_colours.hot, heat));
    } else if (heat > 0) {
      draw.AddRectFilled({low.x, high.y - 2}, high, mixed(ground, ui_colours.hot, heat));
    }
    if (!uses.empty()) {
      const UiState& state = desk.state();
      const bool taken =
          std::any_of(uses.begin(), uses.end(), [&](const SlotUse& use) { return state.taken.contains(use.key); });
      const bool shared = uses.size() > 1 && uses.back().key.fixture != uses.front().key.fixture;
      const bool selected = std::any_of(uses.begin(), uses.end(),
                                        [&](const SlotUse& use) { return state.selection.has(use.key.fixture); });
      if (selected) draw.AddRect(low, high, ImGui::GetColorU32(kUiAmber));
      if (taken) draw.AddRectFilled({high.x - 4, low.y}, {high.x, low.y + 4}, ImGui::GetColorU32(kUiGreen));
      if (shared) draw.AddRectFilled({low.x, high.y - 2}, high, ImGui::GetColorU32(kUiRed));
    }
    if (const auto other = other_level(desk, slot)) {
      constexpr float kFrameUnits = 9;  // in a lower cell a frame and a line would hide the bar
      if (size.y < kFrameUnits) {
        draw.AddRectFilled({low.x, high.y - 2}, high, ImGui::GetColorU32(ui_colours.differs));
      } else {  // its level in A is a line
        const float at = high.y - (high.y - low.y) * static_cast<float>(*other) / 255;
        draw.AddLine({low.x, at}, {high.x, at}, ImGui::GetColorU32(ui_colours.line), 1.5f);
        draw.AddRect(low, high, ImGui::GetColorU32(ui_colours.differs), 0, 0, 1.5f);
      }
    }
    if (text_size > 0 && (level > 0 || used)) {
      const float lift = (size.y - 1 - text_size) / 2;
      draw.AddText(ImGui::GetFont(), text_size, {low.x + 2, low.y + lift},
                   ImGui::GetColorU32(level > 0 ? ImGuiCol_Text : ImGuiCol_TextDisabled), level_words()[level].data());
    }
  }

  [[nodiscard]] std::vector<fixtures::PixelUse> pixels_of(const UiDesk& desk, std::size_t slot) const {
    return fixtures::pixel_uses(desk.rig(), desk.compiled().universes[shown_], static_cast<int>(slot));
  }

  // What the slot is for.
  void draw_slot(UiDesk& desk, std::size_t slot) const {
    std::string words = trf("{}.{}  level {} ({:.0f} %)", desk.compiled().universes[shown_], slot + 1,
                            changes_.levels[slot], changes_.levels[slot] / 2.55);
    if (changes_.changed_ns[slot] != 0) {
      words += trf("  changed {:.1f} s ago", static_cast<double>(now_ns_ - changes_.changed_ns[slot]) * 1e-9);
    }
    if (const auto other = other_level(desk, slot)) words += trf("  A {}", *other);
    ui_text(words);
    const std::string meaning = text_of(names_of_slot(desk.rig(), desk.compiled(), desk.index(), shown_, slot));
    const bool used = !meaning.empty();
    ui_text(used ? kUiAmber : kUiDim, used ? meaning : tr("no fixture and no display uses this slot"));
  }

  std::size_t shown_ = 0;  // which universe of the rig
  bool frozen_ = false;
  bool fresh_ = true;  // no levels of this universe were taken yet
  SlotChanges changes_;
  CompareView compare_;
  bool nine_ = false;  // maps of a page of universes
  UniverseMaps maps_;
  UnpatchedView unpatched_;
  TimeNs now_ns_ = 0;  // of changes_
  std::size_t last_under_ = 0;
};

}  // namespace

std::unique_ptr<Panel> make_universes_panel(UiDesk&) { return std::make_unique<UniversesPanel>(); }

}  // namespace footlight::tools

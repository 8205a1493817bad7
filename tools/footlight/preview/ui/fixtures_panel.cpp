// The patch of the rig as a table: sorted by any column, filtered by text, with rows to select and to edit.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "fixtures/edit/patch_slots.h"
#include "fixtures/paperwork/patch_sheet.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/name_order.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/rig_editor.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

enum Column : int {
  kColumnId,
  kColumnName,
  kColumnType,
  kColumnMode,
  kColumnAddress,
  kColumnPlace,
  kColumnLayer,
  kColumnX,
  kColumnY,
  kColumnZ,
  kColumnCount
};
constexpr std::array<const char*, kColumnCount> kHeads{
    tr_mark("Id"),    tr_mark("Name"),  tr_mark("Type"), tr_mark("Mode"), tr_mark("Address"),
    tr_mark("Hangs"), tr_mark("Layer"), tr_mark("x m"),  tr_mark("y m"),  tr_mark("z m")};

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

class FixturesPanel final : public Panel {
 public:
  explicit FixturesPanel(UiDesk& desk) { read(desk); }

  void draw(UiDesk& desk, const UiInput& input) override {
    if (read_count_ != desk.shown_count()) read(desk);
    if (const auto asked = desk.take_asked_field()) wanted_ = asked;
    draw_head(desk, input);
    tell_listed(desk);
    draw_table(desk, input);
    // Edits come last, since the rows are then those of the rig from before.
    if (const auto field = std::exchange(wanted_, std::nullopt); field && !desk.selected().empty()) {
      editor_.open(desk, *field, in_order(desk));
    }
    if (std::exchange(menu_wanted_, false)) ImGui::OpenPopup("menu of the selection");
    if (ImGui::BeginPopup("menu of the selection")) {
      editor_.draw_menu(desk, in_order(desk));
      ImGui::EndPopup();
    }
    editor_.draw(desk, input.scale);
  }

 private:
  // The rows of the rig as it is.
  void read(UiDesk& desk) {
    read_count_ = desk.shown_count();
    rows_ = fixtures::patch_rows(desk.edited());
    texts_.clear();
    texts_.reserve(rows_.size());
    ids_ = places_ = layers_ = false;
    unpatched_count_ = 0;
    for (const fixtures::PatchRow& row : rows_) {
      texts_.push_back(lower_case(fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}", row.id, row.name, row.type, row.mode,
                                              row.addresses, row.place, row.layer)));
      ids_ = ids_ || row.id != row.name;
      places_ = places_ || !row.place.empty();
      layers_ = layers_ || !row.layer.empty();
      if (!is_patched(desk, row)) ++unpatched_count_;
    }
    conflicts_.assign(rows_.size(), {});
    conflict_count_ = 0;
    for (const fixtures::PatchConflict& each : fixtures::patch_conflicts(desk.edited())) {
      conflicts_[static_cast<std::size_t>(each.fixture)] = each;
      ++conflict_count_;
    }
    only_conflicts_ = only_conflicts_ && conflict_count_ > 0;
    only_unpatched_ = only_unpatched_ && unpatched_count_ > 0;
    filter(desk);
  }

  // Ctrl+A selects no fixture that the filter hides.
  void tell_listed(UiDesk& desk) const {
    if (filter_[0] == 0 && !only_conflicts_ && !only_unpatched_) return;
    std::vector<int> listed;
    for (const int row : shown_) listed.push_back(row_at(row).fixture);
    desk.list(std::move(listed));
  }

  [[nodiscard]] static bool is_patched(const UiDesk& desk, const fixtures::PatchRow& row) {
    return desk.edited().fixtures[static_cast<std::size_t>(row.fixture)].patched;
  }

  void draw_table(UiDesk& desk, const UiInput& input) {
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_Sortable | ImGuiTableFlags_ScrollY | ImGuiTableFlags_ScrollX |
                                       ImGuiTableFlags_Resizable | ImGuiTableFlags_RowBg | ImGuiTableFlags_Hideable |
                                       ImGuiTableFlags_SizingFixedFit;
    if (!ImGui::BeginTable("patch", kColumnCount, kFlags)) return;
    const std::array<float, kColumnCount> widths{44, 130, 150, 90, 76, 60, 80, 52, 52, 52};
    for (std::size_t i = 0; i < widths.size(); ++i) {
      const ImGuiTableColumnFlags flags = i == kColumnAddress             ? ImGuiTableColumnFlags_DefaultSort
                                          : i == kColumnName              ? ImGuiTableColumnFlags_NoHide
                                          : i == kColumnId && !ids_       ? ImGuiTableColumnFlags_DefaultHide
                                          : i == kColumnPlace && !places_ ? ImGuiTableColumnFlags_DefaultHide
                                          : i == kColumnLayer && !layers_ ? ImGuiTableColumnFlags_DefaultHide
                                                                          : ImGuiTableColumnFlags_None;
      ImGui::TableSetupColumn(tr(kHeads[i]), flags, widths[i] * input.scale);
    }
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableHeadersRow();
    sort();
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(shown_.size()));
    while (clipper.Step()) {
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) draw_row(desk, static_cast<std::size_t>(i));
    }
    ImGui::EndTable();
  }

  // The selected fixtures as they are listed, then those that the filter hides.
  [[nodiscard]] std::vector<int> in_order(const UiDesk& desk) const {
    const Selection& selection = desk.state().selection;
    std::vector<int> order;
    std::vector<bool> listed(rows_.size());
    for (const int row : shown_) {
      const int fixture = row_at(row).fixture;
      if (!selection.has(fixture)) continue;
      order.push_back(fixture);
      listed[static_cast<std::size_t>(fixture)] = true;
    }
    for (const int fixture : selection.fixtures) {
      if (!listed[static_cast<std::size_t>(fixture)]) order.push_back(fixture);
    }
    return order;
  }

  [[nodiscard]] const fixtures::PatchRow& row_at(int index) const { return rows_[static_cast<std::size_t>(index)]; }

  void draw_head(UiDesk& desk, const UiInput& input) {
    ImGui::SetNextItemWidth(180 * input.scale);
    if (ImGui::InputTextWithHint("##filter", tr("filter"), filter_.data(), filter_.size())) filter(desk);
    ImGui::SameLine();
    const std::size_t selected = desk.state().selection.fixtures.size();
    ui_text(kUiDim, trf_n("{} of {} fixture, {} selected", "{} of {} fixtures, {} selected", rows_.size(),
                          shown_.size(), rows_.size(), selected));
    if (conflict_count_ > 0) {
      ImGui::SameLine();
      ImGui::PushStyleColor(ImGuiCol_Text, kUiRed);
      const std::string label =
          trf_n("{} shares addresses", "{} share addresses", conflict_count_, conflict_count_) + "###conflicts";
      if (ImGui::Checkbox(label.c_str(), &only_conflicts_)) filter(desk);
      ImGui::PopStyleColor();
    }
    if (unpatched_count_ > 0) {
      ImGui::SameLine();
      const std::string label = trf_n("{} has no address", "{} have no address", unpatched_count_, unpatched_count_);
      if (ImGui::Checkbox((label + "###unpatched").c_str(), &only_unpatched_)) filter(desk);
    }
  }

  void filter(const UiDesk& desk) {
    const std::string wanted = lower_case(filter_.data());
    shown_.clear();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (only_conflicts_ && !conflicts_[static_cast<std::size_t>(rows_[i].fixture)]) continue;
      if (only_unpatched_ && is_patched(desk, rows_[i])) continue;
      if (texts_[i].find(wanted) != std::string::npos) shown_.push_back(static_cast<int>(i));
    }
    sorted_ = false;
    anchor_ = -1;
  }

  void sort() {
    ImGuiTableSortSpecs* specs = ImGui::TableGetSortSpecs();
    if (specs == nullptr || (!specs->SpecsDirty && sorted_)) return;
    specs->SpecsDirty = false;
    sorted_ = true;
    if (specs->SpecsCount == 0) return;
    const ImGuiTableColumnSortSpecs& one = specs->Specs[0];
    const bool down = one.SortDirection == ImGuiSortDirection_Descending;
    std::stable_sort(shown_.begin(), shown_.end(), [&](int a, int b) {
      return down ? before(b, a, one.ColumnIndex) : before(a, b, one.ColumnIndex);
    });
    anchor_ = -1;
  }

  [[nodiscard]] bool before(int a, int b, int column) const {
    const fixtures::PatchRow& x = row_at(a);
    const fixtures::PatchRow& y = row_at(b);
    switch (column) {
      case kColumnId: return compare_names(x.id, y.id) < 0;
      case kColumnName: return compare_names(x.name, y.name) < 0;
      case kColumnType: return compare_names(x.type, y.type) < 0;
      case kColumnMode: return compare_names(x.mode, y.mode) < 0;
      case kColumnPlace: return compare_names(x.place, y.place) < 0;
      case kColumnLayer: return compare_names(x.layer, y.layer) < 0;
      case kColumnX: return x.position_m.x < y.position_m.x;
      case kColumnY: return x.position_m.y < y.position_m.y;
      case kColumnZ: return x.position_m.z < y.position_m.z;
      default: return a < b;  // patch_rows() has the order of addresses
    }
  }

  void draw_row(UiDesk& desk, std::size_t at) {
    const fixtures::PatchRow& row = row_at(shown_[at]);
    const auto& conflict = conflicts_[static_cast<std::size_t>(row.fixture)];
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    if (row.id != row.name) ui_text(row.id);
    // In the column of the name, which cannot be hidden.
    ImGui::TableNextColumn();
    ImGui::PushID(row.fixture);
    constexpr ImGuiSelectableFlags kFlags = ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowDoubleClick;
    if (ImGui::Selectable("##row", desk.state().selection.has(row.fixture), kFlags)) {
      const bool twice = desk.can_edit() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
      if (!twice || !desk.state().selection.has(row.fixture)) click(desk, at);
      if (twice) wanted_ = field_under_mouse();
    }
    if (desk.can_edit()) take_right_click(desk, row.fixture);
    ImGui::PopID();
    ImGui::SameLine(0, 0);
    ui_text(row.name);
    for (const std::string* text : {&row.type, &row.mode}) {
      ImGui::TableNextColumn();
      ui_text(*text);
    }
    ImGui::TableNextColumn();
    if (conflict) {
      ui_text(kUiRed, row.addresses + " !");
      if (ImGui::IsItemHovered())
        ImGui::SetTooltip("%s", tr_known(fixtures::text_of(*conflict, desk.edited())).c_str());
    } else {
      ui_text(row.addresses);
    }
    ImGui::TableNextColumn();
    ui_text(row.place);
    ImGui::TableNextColumn();
    ui_text(row.layer);
    for (int c = 0; c < 3; ++c) {
      ImGui::TableNextColumn();
      std::array<char, 32> number{};
      (void)std::snprintf(number.data(), number.size(), "%8.2f", row.position_m[c]);
      ui_text(number.data());
    }
  }

  // A double click edits the cell under the mouse: number, name or address.
  [[nodiscard]] static std::optional<RigEditor::Field> field_under_mouse() {
    for (const auto& [column, field] :
         {std::pair(kColumnId, RigEditor::Field::kNumber), std::pair(kColumnName, RigEditor::Field::kName),
          std::pair(kColumnAddress, RigEditor::Field::kAddress)}) {
      if ((ImGui::TableGetColumnFlags(column) & ImGuiTableColumnFlags_IsHovered) != 0) return field;
    }
    return std::nullopt;
  }

  // A right click on a row that is not selected selects it.
  void take_right_click(UiDesk& desk, int fixture) {
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right) && !desk.state().selection.has(fixture)) {
      desk.select(fixture, false);
    }
    menu_wanted_ = menu_wanted_ || ImGui::IsItemClicked(ImGuiMouseButton_Right);
  }

  // As in any list: a click selects, Ctrl adds or removes, Shift extends from the last click.
  void click(UiDesk& desk, std::size_t at) {
    const ImGuiIO& io = ImGui::GetIO();
    const int fixture = row_at(shown_[at]).fixture;
    if (!io.KeyShift || anchor_ < 0) {
      desk.select(fixture, io.KeyCtrl);
      anchor_ = static_cast<int>(at);
      return;
    }
    Selection next = io.KeyCtrl ? desk.state().selection : Selection{};
    const auto from = std::min(static_cast<std::size_t>(anchor_), at);
    const auto to = std::max(static_cast<std::size_t>(anchor_), at);
    for (std::size_t i = from; i <= to; ++i) next.fixtures.push_back(row_at(shown_[i]).fixture);
    std::sort(next.fixtures.begin(), next.fixtures.end());
    next.fixtures.erase(std::unique(next.fixtures.begin(), next.fixtures.end()), next.fixtures.end());
    next.lead = fixture;
    desk.select(std::move(next));
  }

  std::vector<fixtures::PatchRow> rows_;
  std::vector<std::string> texts_;  // of each row, for the filter
  bool ids_ = false;                // some fixture has an id
  bool places_ = false;             // or a pipe that it hangs from
  bool layers_ = false;             // or a layer
  std::vector<int> shown_;          // indices into rows_, filtered and sorted
  std::array<char, 128> filter_{};
  bool sorted_ = false;
  int anchor_ = -1;  // index into shown_: where Shift extends from
  bool only_conflicts_ = false;
  std::uint64_t read_count_ = 0;                                   // UiDesk::shown_count() of the rows
  std::vector<std::optional<fixtures::PatchConflict>> conflicts_;  // of each fixture
  std::size_t conflict_count_ = 0;
  bool only_unpatched_ = false;
  std::size_t unpatched_count_ = 0;
  RigEditor editor_;
  std::optional<RigEditor::Field> wanted_;  // to be edited, of what is selected
  bool menu_wanted_ = false;
};

}  // namespace

std::unique_ptr<Panel> make_fixtures_panel(UiDesk& desk) { return std::make_unique<FixturesPanel>(desk); }

}  // namespace footlight::tools

// The installed definitions of fixtures as a table that is searched, the chosen one in detail, and how many of it are
// added to the rig.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "fixtures/edit/add_fixtures.h"
#include "fixtures/files/definition_list.h"
#include "fixtures/files/definition_reader.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/new_place.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr int kAddedMax = 10'000;                                            // of fixtures that are added at once
constexpr ImGuiInputTextFlags kSelects = ImGuiInputTextFlags_AutoSelectAll;  // a click selects what is in a field
constexpr float kNarrow = 560;  // in a narrower panel the details are below the list

enum LibraryColumn : int {
  kLibraryMaker,
  kLibraryName,
  kLibraryKind,
  kLibraryModes,
  kLibrarySlots,
  kLibraryFile,
  kLibraryCount
};
constexpr std::array<const char*, kLibraryCount> kLibraryHeads{tr_mark("Maker"), tr_mark("Name"),  tr_mark("Kind"),
                                                               tr_mark("Modes"), tr_mark("Slots"), tr_mark("File")};
constexpr std::array<float, kLibraryCount> kLibraryWidths{110, 160, 115, 46, 58, 200};

// "14", "8 - 24"
std::string span_of_slots(const fixtures::Definition& one) {
  if (one.modes.empty()) return "";
  int least = one.modes.front().slots;
  int most = least;
  for (const fixtures::DefinitionMode& mode : one.modes) {
    least = std::min(least, mode.slots);
    most = std::max(most, mode.slots);
  }
  return least == most ? std::to_string(least) : fmt::format("{} - {}", least, most);
}

// "3, 4": where a channel is in its mode.
std::string slots_text(const fixtures::Channel& channel) {
  std::string slots;
  for (const int offset : channel.slot_offsets) slots += fmt::format("{}{}", slots.empty() ? "" : ", ", offset + 1);
  if (channel.dmx_break > 1) slots += trf(" of break {}", channel.dmx_break);
  return slots.empty() ? "-" : slots;
}

class LibraryPanel final : public Panel {
 public:
  explicit LibraryPanel(UiDesk& desk)
      : reader_(std::make_unique<fixtures::DefinitionReader>(desk.definition_folders())) {
    const glm::dvec3 place = new_place(desk.edited());
    // To the millimetre; + 0 so that there is no "-0.00".
    const auto rounded = [](double metres) { return std::round(metres * 1000) / 1000 + 0.0; };
    position_m_ = {rounded(place.x), rounded(place.y), rounded(place.z)};
  }

  void draw(UiDesk& desk, const UiInput& input) override {
    take();
    draw_search(input);
    const ImVec2 space = ImGui::GetContentRegionAvail();
    const bool narrow = space.x < kNarrow * input.scale;
    const ImVec2 size = narrow ? ImVec2(0, space.y * 0.4f) : ImVec2(space.x * 0.58f, 0);
    if (ImGui::BeginChild("list", size)) draw_table(input);
    ImGui::EndChild();
    if (!narrow) ImGui::SameLine();
    if (ImGui::BeginChild("details")) draw_details(desk, input);
    ImGui::EndChild();
  }

 private:
  // What was read since the last picture.
  void take() {
    if (!reader_) return;
    state_ = reader_->state();
    std::vector<fixtures::Definition> more = reader_->take();
    if (!more.empty()) {
      list_.add(std::move(more));
      search();
    }
    if (state_.ended) reader_.reset();
  }

  void search() {
    shown_ = list_.search(words_.data());
    broken_ = 0;
    for (const int index : shown_) broken_ += list_.at(index).error.empty() ? 0 : 1;
  }

  void draw_search(const UiInput& input) {
    ImGui::SetNextItemWidth(240 * input.scale);
    if (ImGui::InputTextWithHint("##words", tr("maker, name, kind, mode"), words_.data(), words_.size(), kSelects))
      search();
    ImGui::SameLine();
    std::string text = trf_n("{} of {} definition", "{} of {} definitions", list_.size(), shown_.size(), list_.size());
    if (broken_ > 0) text += trf(", {} cannot be read", broken_);
    ui_text(kUiDim, text);
    if (reader_) {
      ImGui::SameLine();
      ui_text(kUiAmber, state_.all == 0 ? std::string(tr("searching folders"))
                                        : trf("reading {} of {}", state_.done, state_.all));
      ImGui::SameLine();
      if (ImGui::SmallButton(tr_label("stop"))) reader_->stop();
    } else if (state_.done < state_.all) {
      ImGui::SameLine();
      ui_text(kUiAmber, trf("stopped after {} of {} files", state_.done, state_.all));
    }
    for (const std::string& note : state_.notes) ui_text(kUiAmber, note);
  }

  void draw_table(const UiInput& input) {
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_ScrollX | ImGuiTableFlags_Resizable |
                                       ImGuiTableFlags_RowBg | ImGuiTableFlags_Hideable |
                                       ImGuiTableFlags_SizingFixedFit;
    if (!ImGui::BeginTable("definitions", kLibraryCount, kFlags)) return;
    for (std::size_t i = 0; i < kLibraryHeads.size(); ++i) {
      ImGui::TableSetupColumn(tr(kLibraryHeads[i]),
                              i == kLibraryName ? ImGuiTableColumnFlags_NoHide : ImGuiTableColumnFlags_None,
                              kLibraryWidths[i] * input.scale);
    }
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableHeadersRow();
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(shown_.size()));
    while (clipper.Step()) {
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) draw_row(shown_[static_cast<std::size_t>(i)]);
    }
    ImGui::EndTable();
  }

  void draw_row(int index) {
    const fixtures::Definition& one = list_.at(index);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ui_text(one.file.manufacturer);
    ImGui::TableNextColumn();  // which cannot be hidden
    ImGui::PushID(index);
    if (ImGui::Selectable("##row", index == chosen_, ImGuiSelectableFlags_SpanAllColumns)) choose(index);
    ImGui::PopID();
    ImGui::SameLine(0, 0);
    if (one.error.empty()) {
      ui_text(one.file.model);
    } else {
      ui_text(kUiRed, one.file.model);
    }
    ImGui::TableNextColumn();
    ui_text(one.error.empty() ? tr(one.kind.c_str()) : tr("cannot be read"));
    ImGui::TableNextColumn();
    if (!one.modes.empty()) ui_text(std::to_string(one.modes.size()));
    ImGui::TableNextColumn();
    ui_text(span_of_slots(one));
    ImGui::TableNextColumn();
    ui_text(one.file.format == "built" ? one.file.path : std::filesystem::path(one.file.path).filename().string());
  }

  // Reads its file again: the list has no channels.
  void choose(int index) {
    if (index == chosen_) return;
    chosen_ = index;
    row_ = {};
    name_.fill(0);
    error_ = list_.at(index).error;
    planned_ = false;
    if (!error_.empty()) return;
    auto type = fixtures::open_definition(list_.at(index).file.path);
    if (type) {
      row_.type = std::make_shared<const fixtures::FixtureType>(std::move(*type));
    } else {
      error_ = tr_known(type.error().message);
    }
  }

  void draw_details(UiDesk& desk, const UiInput& input) {
    if (chosen_ < 0) {
      ui_text(kUiDim, tr("Click a definition."));
      return;
    }
    const fixtures::Definition& one = list_.at(chosen_);
    ui_text(kUiAmber, fmt::format("{} {}", one.file.manufacturer, one.file.model));
    ImGui::PushTextWrapPos(0);
    std::string about = one.file.format == "built" ? tr("built in") : one.file.format;
    if (!one.kind.empty()) about += fmt::format(", {}", tr(one.kind.c_str()));
    if (one.gobos > 0) about += trf_n(", {} gobo", ", {} gobos", one.gobos, one.gobos);
    ui_text(about);
    ui_text(kUiDim, one.file.path);
    if (row_.type == nullptr) {
      ui_text(kUiRed, error_);
      ImGui::PopTextWrapPos();
      return;
    }
    ImGui::PopTextWrapPos();
    draw_mode(input);
    if (desk.can_edit()) {
      draw_fields(desk, input);
    } else {
      ui_text(kUiDim, tr("This rig cannot be edited."));
    }
    draw_channels(input.scale);
  }

  [[nodiscard]] const fixtures::Mode& mode() const { return row_.type->modes[static_cast<std::size_t>(row_.mode)]; }

  static std::string text_of(const fixtures::Mode& mode) {
    return fmt::format("{}: {}, {}", mode.name, trf_n("{} slot", "{} slots", mode.slot_count, mode.slot_count),
                       trf_n("{} channel", "{} channels", mode.channels.size(), mode.channels.size()));
  }

  void draw_mode(const UiInput& input) {
    ImGui::SetNextItemWidth(240 * input.scale);
    if (!ImGui::BeginCombo(tr_label("mode"), text_of(mode()).c_str())) return;
    for (std::size_t i = 0; i < row_.type->modes.size(); ++i) {
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::Selectable(text_of(row_.type->modes[i]).c_str(), static_cast<int>(i) == row_.mode)) {
        row_.mode = static_cast<int>(i);
        planned_ = false;
      }
      ImGui::PopID();
    }
    ImGui::EndCombo();
  }

  void draw_fields(UiDesk& desk, const UiInput& input) {
    bool changed = false;
    ImGui::SetNextItemWidth(110 * input.scale);
    changed = ImGui::InputInt(tr_label("count"), &row_.count) || changed;
    row_.count = std::clamp(row_.count, 1, kAddedMax);
    ImGui::SetNextItemWidth(240 * input.scale);
    changed =
        ImGui::InputTextWithHint(tr_label("name"), row_.type->name.c_str(), name_.data(), name_.size(), kSelects) ||
        changed;
    ImGui::SetNextItemWidth(110 * input.scale);
    changed =
        ImGui::InputTextWithHint(tr_label("address"), tr("first free"), address_.data(), address_.size(), kSelects) ||
        changed;
    if (address_[0] != '\0') {
      ImGui::SameLine();
      changed = ImGui::Checkbox(tr_label("skip slots of others"), &only_free_) || changed;
    }
    const auto numbers = [&](const char* label, std::array<double, 3>& values) {
      ImGui::SetNextItemWidth(240 * input.scale);
      changed = ImGui::InputScalarN(label, ImGuiDataType_Double, values.data(), 3, nullptr, nullptr, "%.2f") || changed;
    };
    numbers(tr_label("position, m"), position_m_);
    numbers(tr_label("apart, m"), apart_m_);
    if (changed || !planned_ || planned_count_ != desk.shown_count()) plan(desk);
    ImGui::BeginDisabled(!error_.empty());
    if (ImGui::Button(tr_label("Add"))) add(desk);
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::PushTextWrapPos(0);
    ui_text(error_.empty() ? kUiDim : kUiRed, error_.empty() ? plan_ : error_);
    ImGui::PopTextWrapPos();
  }

  // What Add would do, or why it cannot.
  void plan(const UiDesk& desk) {
    planned_ = true;
    planned_count_ = desk.shown_count();
    error_.clear();
    row_.name = name_.data();
    row_.position_m = {position_m_[0], position_m_[1], position_m_[2]};
    row_.step_m = {apart_m_[0], apart_m_[1], apart_m_[2]};
    row_.address.reset();
    row_.only_free = only_free_;
    if (address_[0] != '\0') {
      const auto place = fixtures::parse_patch(address_.data(), 1);
      if (!place) {
        error_ = tr_known(place.error().message);
        return;
      }
      row_.address = *place;
    }
    const auto edit = fixtures::add_fixtures(desk.edited(), row_);
    if (!edit) {
      error_ = tr_known(edit.error().message);
      return;
    }
    const fixtures::PatchedFixture& first = edit->added.front().value;
    const fixtures::PatchedFixture& last = edit->added.back().value;
    plan_ = row_.count == 1 ? trf("{} at {}", first.name, fixtures::text_of_patch(first))
                            : trf("{} to {}, {} to {}", first.name, last.name, fixtures::text_of_patch(first),
                                  fixtures::text_of_patch(last));
  }

  void add(UiDesk& desk) {
    desk.begin_gesture();
    const Status added = desk.add(row_);
    desk.begin_gesture();
    if (!added) {
      desk.tell(tr_known(added.error().message));
      return;
    }
    desk.tell(row_.count == 1 ? trf("added {} (Ctrl+Z takes it back)", plan_)
                              : trf("added {} (Ctrl+Z takes them back)", plan_));
    for (std::size_t i = 0; i < position_m_.size(); ++i) position_m_[i] += row_.count * apart_m_[i];
    address_.fill(0);  // it is taken now
    planned_ = false;
  }

  void draw_channels(float scale) const {
    const float slots_width = 90 * scale;
    const std::vector<fixtures::Channel>& channels = mode().channels;
    if (!ImGui::BeginChild("channels")) {
      ImGui::EndChild();
      return;
    }
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(channels.size()));
    while (clipper.Step()) {
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
        const fixtures::Channel& channel = channels[static_cast<std::size_t>(i)];
        ui_text(kUiDim, slots_text(channel));
        ImGui::SameLine(slots_width);
        ui_text(name_of(channel));
      }
    }
    ImGui::EndChild();
  }

  std::unique_ptr<fixtures::DefinitionReader> reader_;  // null: it has ended
  fixtures::DefinitionReader::State state_;
  fixtures::DefinitionList list_;
  std::array<char, 128> words_{};
  std::vector<int> shown_;  // indices into list_
  int broken_ = 0;          // of shown_
  int chosen_ = -1;         // index into list_
  fixtures::NewFixtures row_;
  std::array<char, 128> name_{};
  std::array<char, 32> address_{};
  bool only_free_ = true;
  std::array<double, 3> position_m_{0, 0, 4};
  std::array<double, 3> apart_m_{1, 0, 0};
  bool planned_ = false;             // plan_ and error_ are of the fields and of the rig with planned_count_
  std::uint64_t planned_count_ = 0;  // UiDesk::shown_count()
  std::string plan_;
  std::string error_;
};

}  // namespace

std::unique_ptr<Panel> make_library_panel(UiDesk& desk) { return std::make_unique<LibraryPanel>(desk); }

}  // namespace footlight::tools

#include "tools/footlight/preview/ui/rig_editor.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

using Field = RigEditor::Field;

constexpr const char* kPopup = "edit fixtures";
constexpr int kCopiesMax = 1000;  // of each fixture, at once

const fixtures::PatchedFixture& first_of(const UiDesk& desk, const std::vector<int>& which) {
  return desk.edited().fixtures[static_cast<std::size_t>(which.front())];
}

// "Spot 3" as "Spot {}", for several names.
std::string pattern_of(const std::string& name) {
  std::string stem = name;
  while (!stem.empty() && stem.back() >= '0' && stem.back() <= '9') stem.pop_back();
  return stem + (stem.size() == name.size() ? " {}" : "{}");
}

std::string fixtures_text(std::size_t count) { return trf_n("{} fixture", "{} fixtures", count, count); }

int number_at_end(const std::string& name) {
  std::size_t at = name.size();
  while (at > 0 && name[at - 1] >= '0' && name[at - 1] <= '9' && name.size() - at < 8) --at;
  int number = 1;
  (void)std::from_chars(name.data() + at, name.data() + name.size(), number);
  return number;
}

}  // namespace

void RigEditor::open(const UiDesk& desk, Field field, std::vector<int> which) {
  field_ = field;
  which_ = std::move(which);
  shown_count_ = desk.shown_count();
  opens_ = focuses_ = true;
  error_.clear();
  const fixtures::PatchedFixture& first = first_of(desk, which_);
  std::string text;
  switch (field) {
    case Field::kAddress: text = first.patched ? fmt::format("{}.{}", first.universe, first.address) : "1.1"; break;
    case Field::kName:
      text = which_.size() > 1 ? pattern_of(first.name) : first.name;
      first_ = which_.size() > 1 ? number_at_end(first.name) : 1;
      break;
    case Field::kNumber: text = std::to_string(std::max(first.labels.fixture_id_numeric, 1)); break;
    case Field::kClone: break;
  }
  text_.fill(0);
  std::memcpy(text_.data(), text.data(), std::min(text.size(), text_.size() - 1));
}

void RigEditor::tell(const Status& edited) { error_ = edited ? "" : tr_known(edited.error().message); }

void RigEditor::apply(UiDesk& desk) {
  desk.begin_gesture();
  const fixtures::Rig& rig = desk.edited();
  const std::string text = text_.data();
  switch (field_) {
    case Field::kAddress: {
      const auto place = fixtures::parse_patch(text, first_of(desk, which_).universe);
      if (!place) {
        error_ = tr_known(place.error().message);
        break;
      }
      fixtures::PatchStart start;
      start.universe = place->universe;
      start.address = place->address;
      start.only_free = free_only_;
      tell(desk.edit(fixtures::patch_fixtures(rig, which_, start)));
      break;
    }
    case Field::kName: tell(desk.edit(fixtures::rename_fixtures(rig, which_, text, first_))); break;
    case Field::kNumber: {
      int number = 0;
      const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
      if (fault != std::errc() || end != text.data() + text.size()) {
        error_ = trf("number '{}': expected a whole number", text);
        break;
      }
      tell(desk.edit(fixtures::number_fixtures(rig, which_, number)));
      break;
    }
    case Field::kClone: {
      fixtures::CloneRow row;
      row.count = count_;
      row.offset_m = {offset_m_[0], offset_m_[1], offset_m_[2]};
      tell(desk.clone(which_, row));
      break;
    }
  }
  desk.begin_gesture();
  shown_count_ = desk.shown_count();
}

void RigEditor::draw_fields(UiDesk& desk, float scale) {
  static constexpr const char* kTitles[] = {tr_mark("Address of {}"), tr_mark("Name of {}"), tr_mark("Number of {}"),
                                            tr_mark("Clone of {}")};
  ui_text(kUiAmber, trf_marked(kTitles[static_cast<int>(field_)],
                               which_.size() == 1 ? first_of(desk, which_).name : fixtures_text(which_.size())));
  bool entered = false;
  ImGui::SetNextItemWidth(200 * scale);
  if (field_ == Field::kClone) {
    ImGui::InputInt(tr_label("copies"), &count_);
    count_ = std::clamp(count_, 1, kCopiesMax);
    ImGui::SetNextItemWidth(200 * scale);
    ImGui::InputScalarN(tr_label("metres apart: x, y, z"), ImGuiDataType_Double, offset_m_.data(), 3, nullptr, nullptr,
                        "%.3f");
  } else {
    if (std::exchange(focuses_, false)) ImGui::SetKeyboardFocusHere();
    constexpr ImGuiInputTextFlags kFlags = ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll;
    entered = ImGui::InputText("##text", text_.data(), text_.size(), kFlags);
  }
  if (field_ == Field::kAddress) {
    if (which_.size() > 1) ui_text(kUiDim, tr("of the first; the others follow"));
    ImGui::Checkbox(tr_label("skip slots of others"), &free_only_);
  }
  if (field_ == Field::kName && which_.size() > 1) {
    ImGui::SetNextItemWidth(100 * scale);
    ImGui::InputInt(tr_label("{} from"), &first_);
  }
  if (field_ == Field::kNumber && which_.size() > 1) ui_text(kUiDim, tr("of the first; the others count up"));
  if (!error_.empty()) {
    ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + 320 * scale);
    ui_text(kUiRed, error_);
    ImGui::PopTextWrapPos();
  }
  if (ImGui::Button(tr_label("OK")) || entered) {
    apply(desk);
    if (error_.empty()) ImGui::CloseCurrentPopup();
  }
  ImGui::SameLine();
  if (ImGui::Button(tr_label("Cancel"))) ImGui::CloseCurrentPopup();
}

void RigEditor::draw(UiDesk& desk, float scale) {
  if (std::exchange(opens_, false)) ImGui::OpenPopup(kPopup);
  if (!ImGui::BeginPopup(kPopup)) return;
  // After another edit the indices may be those of other fixtures.
  if (shown_count_ == desk.shown_count() && !which_.empty()) {
    draw_fields(desk, scale);
  } else {
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

namespace {

std::string news_of(UiDesk& desk, Result<fixtures::RigEdit> edit) {
  const std::string text = edit ? edit->text : "";
  const Status edited = desk.edit(std::move(edit));
  return edited ? trf("{} (Ctrl+Z brings it back)", tr_known(text)) : tr_known(edited.error().message);
}

}  // namespace

void RigEditor::draw_menu(UiDesk& desk, const std::vector<int>& which) {
  if (which.empty()) return;
  const fixtures::PatchedFixture first = first_of(desk, which);
  ui_text(kUiDim, which.size() == 1 ? first.name : fixtures_text(which.size()));
  if (ImGui::MenuItem(tr_label("Address..."))) open(desk, Field::kAddress, which);
  if (ImGui::MenuItem(tr_label("Name..."))) open(desk, Field::kName, which);
  if (ImGui::MenuItem(tr_label("Number..."))) open(desk, Field::kNumber, which);
  const auto& modes = fixtures::type_of(desk.edited(), first).modes;
  std::optional<Result<fixtures::RigEdit>> edit;
  if (ImGui::BeginMenu(tr_label("Mode"), modes.size() > 1)) {
    for (std::size_t i = 0; i < modes.size(); ++i) {
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::MenuItem(modes[i].name.c_str(), nullptr, static_cast<int>(i) == first.mode)) {
        edit = fixtures::set_mode(desk.edited(), which, modes[i].name);
      }
      ImGui::PopID();
    }
    ImGui::EndMenu();
  }
  ImGui::Separator();
  if (ImGui::MenuItem(tr_label("Clone..."))) open(desk, Field::kClone, which);
  if (ImGui::MenuItem(tr_label("Unpatch"))) edit = fixtures::unpatch_fixtures(desk.edited(), which);
  if (ImGui::MenuItem(tr_label("Delete"), tr("Del"))) {
    desk.begin_gesture();
    desk.tell(news_of(desk, fixtures::delete_fixtures(desk.edited(), which)));
    desk.begin_gesture();
  }
  if (!edit) return;
  desk.begin_gesture();
  if (const Status edited = desk.edit(std::move(*edit)); !edited) desk.tell(tr_known(edited.error().message));
  desk.begin_gesture();
}

std::string delete_selected(UiDesk& desk) {
  if (!desk.can_edit() || desk.selected().empty()) return "";
  return news_of(desk, fixtures::delete_fixtures(desk.edited(), desk.selected()));
}

std::string unpatch_selected(UiDesk& desk) {
  if (!desk.can_edit() || desk.selected().empty()) return "";
  return news_of(desk, fixtures::unpatch_fixtures(desk.edited(), desk.selected()));
}

}  // namespace footlight::tools

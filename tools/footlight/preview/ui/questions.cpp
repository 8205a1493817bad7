#include "tools/footlight/preview/ui/questions.h"

#include <algorithm>
#include <initializer_list>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

bool begin_question(const char* title) {
  constexpr float kMargin = 8;
  const ImVec2 size = ImGui::GetMainViewport()->Size;
  ImGui::SetNextWindowPos(ImGui::GetMainViewport()->GetCenter(), ImGuiCond_Always, {0.5f, 0.5f});
  const ImVec2 most{std::max(size.x - 2 * kMargin, 1.0f), std::max(size.y - 2 * kMargin, 1.0f)};
  ImGui::SetNextWindowSizeConstraints({0, 0}, most);
  return ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove);
}

std::optional<CloseAnswer> CloseQuestion::draw(const std::string& target, const std::string& error) {
  const char* const kTitle = tr_label("Unsaved edits");
  if (!open_) ImGui::OpenPopup(kTitle);
  std::optional<CloseAnswer> answer;
  if (begin_question(kTitle)) {
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 30);
    ui_text(tr("The rig has edits that are not saved."));
    ui_text(kUiDim, target);
    if (!error.empty()) ui_text(kUiRed, error);
    ImGui::PopTextWrapPos();
    if (ImGui::Button(tr_label("Save and close"))) answer = CloseAnswer::kSave;
    ImGui::SameLine();
    if (ImGui::Button(tr_label("Discard them"))) answer = CloseAnswer::kDiscard;
    ImGui::SameLine();
    if (ImGui::Button(tr_label("Stay"))) answer = CloseAnswer::kStay;
    if (answer) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  } else if (open_) {
    answer = CloseAnswer::kStay;
  }
  open_ = !answer;
  return answer;
}

std::optional<OpenAnswer> OpenQuestion::draw(const std::string& what, const std::string& then, bool compares) {
  const char* const kTitle = tr_label("Open a file");
  if (!open_) ImGui::OpenPopup(kTitle);
  std::optional<OpenAnswer> answer;
  if (begin_question(kTitle)) {
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 30);
    ui_text(what);
    ui_text(kUiDim, then);
    if (compares) ui_text(kUiDim, tr("Compare: its levels are shown beside those of now, and nothing else changes."));
    ImGui::PopTextWrapPos();
    if (ImGui::Button(tr_label("Open"))) answer = OpenAnswer::kOpen;
    ImGui::SameLine();
    if (compares) {
      if (ImGui::Button(tr_label("Compare"))) answer = OpenAnswer::kCompare;
      ImGui::SameLine();
    }
    if (ImGui::Button(tr_label("Stay"))) answer = OpenAnswer::kStay;
    if (answer) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  } else if (open_) {
    answer = OpenAnswer::kStay;
  }
  open_ = !answer;
  return answer;
}

namespace {

// A line at the top left of the window, with its words and then its buttons: below them where they do not fit beside.
// Between this and ImGui::End(); false: it is not seen.
bool begin_line(const char* id, const std::string& words, std::initializer_list<const char*> labels, float scale) {
  ImGui::SetNextWindowPos({8 * scale, 8 * scale}, ImGuiCond_Always);
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize |
                                      ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoFocusOnAppearing;
  if (!ImGui::Begin(id, nullptr, kFlags)) return false;
  ui_text(kUiAmber, words);
  const ImGuiStyle& style = ImGui::GetStyle();
  float width = ImGui::CalcTextSize(words.c_str()).x + 2 * (8 * scale + style.WindowPadding.x);
  for (const char* label : labels) {
    width += ImGui::CalcTextSize(label).x + 2 * style.FramePadding.x + style.ItemSpacing.x;
  }
  if (width < ImGui::GetMainViewport()->Size.x) ImGui::SameLine();
  return true;
}

}  // namespace

std::optional<RecordedAnswer> draw_recorded(const std::string& name, float scale) {
  std::optional<RecordedAnswer> answer;
  if (begin_line("recorded", trf("Recorded: {}", name), {tr("Play it"), tr("Close")}, scale)) {
    if (ImGui::SmallButton(tr_label("Play it"))) answer = RecordedAnswer::kPlay;
    ImGui::SameLine();
    if (ImGui::SmallButton(tr_label("Close"))) answer = RecordedAnswer::kClose;
  }
  ImGui::End();
  return answer;
}

std::optional<LostAnswer> draw_lost_edits(const std::string& when, bool older, float scale) {
  std::optional<LostAnswer> answer;
  const std::string words = older ? trf("The file has changed since the automatic copy of {}.", when)
                                  : trf("Edits were not saved: there is an automatic copy of {}.", when);
  if (begin_line("lost edits", words, {tr("Recover"), tr("Keep"), tr("Discard")}, scale)) {
    if (ImGui::SmallButton(tr_label("Recover"))) answer = LostAnswer::kRecover;
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("%s", tr("The window opens again with these edits, as --recover does."));
    ImGui::SameLine();
    if (ImGui::SmallButton(tr_label("Keep"))) answer = LostAnswer::kKeep;
    ImGui::SameLine();
    if (ImGui::SmallButton(tr_label("Discard"))) answer = LostAnswer::kDiscard;
  }
  ImGui::End();
  return answer;
}

}  // namespace footlight::tools

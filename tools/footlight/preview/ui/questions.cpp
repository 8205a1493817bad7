#include "tools/footlight/preview/ui/questions.h"

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

std::optional<CloseAnswer> CloseQuestion::draw(const std::string& target, const std::string& error) {
  const char* const kTitle = tr_label("Unsaved edits");
  if (!open_) ImGui::OpenPopup(kTitle);
  std::optional<CloseAnswer> answer;
  const ImVec2 middle = ImGui::GetMainViewport()->GetCenter();
  ImGui::SetNextWindowPos(middle, ImGuiCond_Appearing, {0.5f, 0.5f});
  if (ImGui::BeginPopupModal(kTitle, nullptr, ImGuiWindowFlags_AlwaysAutoResize)) {
    ui_text(tr("The rig has edits that are not saved."));
    ui_text(kUiDim, target);
    if (!error.empty()) {
      ImGui::PushTextWrapPos(ImGui::GetFontSize() * 30);
      ui_text(kUiRed, error);
      ImGui::PopTextWrapPos();
    }
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
  ImGui::SetNextWindowPos(ImGui::GetMainViewport()->GetCenter(), ImGuiCond_Appearing, {0.5f, 0.5f});
  if (ImGui::BeginPopupModal(kTitle, nullptr, ImGuiWindowFlags_AlwaysAutoResize)) {
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 30);
    ui_text(what);
    ui_text(kUiDim, then);
    ImGui::PopTextWrapPos();
    if (compares) ui_text(kUiDim, tr("Compare: its levels are shown beside those of now, and nothing else changes."));
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

std::optional<LostAnswer> draw_lost_edits(const std::string& when, bool older, float scale) {
  std::optional<LostAnswer> answer;
  ImGui::SetNextWindowPos({8 * scale, 8 * scale}, ImGuiCond_Always);
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize |
                                      ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_NoMove;
  if (ImGui::Begin("lost edits", nullptr, kFlags)) {
    ui_text(kUiAmber, older ? trf("The file has changed since the automatic copy of {}.", when)
                            : trf("Edits were not saved: there is an automatic copy of {}.", when));
    ImGui::SameLine();
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

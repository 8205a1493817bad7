#include "tools/footlight/preview/ui/draw_output_questions.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/questions.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {
namespace {

constexpr float kAskedLines = 5;  // outputs of the question that are in sight

}  // namespace

void ArmQuestion::ask(OutputId which) {
  asks_ = which;
  opens_ = true;
  clear_ = false;
}

// The outputs that the question is about; many of them scroll, so that its buttons are in the window.
void ArmQuestion::draw_asked(const OutputsView& outputs) const {
  std::vector<std::string> lines;
  for (const OutputRow& row : outputs.rows) {
    if ((*asks_ != kAll && *asks_ != row.id) || row.state != ArmState::kOff) continue;
    lines.push_back(row.made_up ? trf("{}  universe {}  (made up: no lamp gets it)", row.endpoint,
                                      show_universes(row.sent()))
                                : trf("{}  universe {}", row.endpoint, show_universes(row.sent())));
  }
  const float width = ImGui::GetFontSize() * 26;
  float height = 0;
  for (const std::string& line : lines) {
    height += ImGui::CalcTextSize(line.c_str(), nullptr, false, width).y + ImGui::GetStyle().ItemSpacing.y;
  }
  if (ImGui::BeginChild("asked", {width, std::min(height, kAskedLines * ImGui::GetTextLineHeightWithSpacing())})) {
    ImGui::PushTextWrapPos(0);
    for (const std::string& line : lines) ui_text(kUiAmber, line);
    ImGui::PopTextWrapPos();
  }
  ImGui::EndChild();
}

void RemovalQuestion::draw(OutputsView& outputs) {
  if (!removes_) return;
  const char* const title = tr_label("Remove a live output?");
  if (std::exchange(opens_, false)) ImGui::OpenPopup(title);
  if (!begin_question(title)) return removes_.reset();
  const OutputRow* const row = outputs.find(*removes_);
  if (row == nullptr) {  // it was removed meanwhile
    removes_.reset();
    ImGui::CloseCurrentPopup();
    return ImGui::EndPopup();
  }
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 26);
  ui_text(trf("{} is live. Its lamps get zeros, and it is closed.", row->endpoint));
  ImGui::PopTextWrapPos();
  const bool yes = ImGui::Button(tr_label("Remove it"));
  ImGui::SameLine();
  const bool no = ImGui::Button(tr_label("Leave it"));
  if (yes) outputs.remove.push_back(row->id);
  if (yes || no) {
    removes_.reset();
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

// Two acts at two places: a tick, and the button that it enables. A click that comes twice arms nothing.
void ArmQuestion::draw(const UiInput& input) {
  const char* const kTitle = tr_label("Send to real lamps?");
  if (!asks_) return;
  OutputsView& outputs = *input.outputs;
  if (opens_) ImGui::OpenPopup(kTitle);
  opens_ = false;
  if (!begin_question(kTitle)) {
    asks_.reset();
    return;
  }
  // One that was removed before it may have left the list meanwhile.
  if (*asks_ != kAll && outputs.find(*asks_) == nullptr) {
    asks_.reset();
    ImGui::CloseCurrentPopup();
    return ImGui::EndPopup();
  }
  draw_asked(outputs);
  const auto lit =
      std::count_if(input.levels.begin(), input.levels.end(), [](std::uint8_t level) { return level > 0; });
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 26);
  if (outputs.needs_hold) {
    ui_text(trf_n("Real lamps get zeros, and while {} is held the levels of the picture: {} slot of the rig is above "
                  "zero.",
                  "Real lamps get zeros, and while {} is held the levels of the picture: {} slots of the rig are "
                  "above zero.",
                  lit, tr(kHoldKeyName), lit));
  } else {
    ui_text(trf_n("Real lamps get the levels of the picture at once, and move: {} slot of the rig is above zero.",
                  "Real lamps get the levels of the picture at once, and move: {} slots of the rig are above zero.",
                  lit, lit));
  }
  if (input.inputs != nullptr && !input.inputs->made_up.empty()) {
    ui_text(kUiRed, trf("A made-up input moves them: {}.", input.inputs->made_up.front()));
  }
  ui_text(kUiDim, tr("B or F9 is the blackout, Ctrl+D disarms all. Disarmed outputs end dark."));
  ImGui::PopTextWrapPos();
  ImGui::Checkbox(tr_label("The stage is clear, and nobody is near the lamps"), &clear_);
  ImGui::BeginDisabled(!clear_);
  const bool arms = ImGui::Button(tr_label("Arm"));
  ImGui::EndDisabled();
  ImGui::SameLine();
  const bool leaves = ImGui::Button(tr_label("Leave it"));
  if (arms) {
    for (const OutputRow& row : outputs.rows) {
      if (*asks_ == kAll || *asks_ == row.id) outputs.arm.push_back(row.id);
    }
  }
  if (arms || leaves) {
    asks_.reset();
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

}  // namespace footlight::tools

// The last messages of the window, for who did not see a box in time.
#include <string>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/messages.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

class MessagesPanel final : public Panel {
 public:
  void draw(UiDesk&, const UiInput& input) override {
    if (input.messages == nullptr || input.messages->all().empty()) {
      ui_text(kUiDim, tr("There was no message yet."));
      return;
    }
    const auto& all = input.messages->all();
    if (ImGui::SmallButton(tr_label("copy all"))) {
      std::string text;
      for (const Message& one : all) text += one.time + " " + text_of(one) + "\n";
      ImGui::SetClipboardText(text.c_str());
    }
    if (ImGui::BeginChild("messages")) {
      for (const Message& one : all) {
        ui_text(kUiDim, one.time);
        ImGui::SameLine();
        ImGui::PushTextWrapPos(0);
        ui_text(one.wrong ? kUiRed : ImGui::GetStyleColorVec4(ImGuiCol_Text), text_of(one));
        ImGui::PopTextWrapPos();
      }
      // The newest stays in sight, unless the user scrolled up to read.
      if (ImGui::GetScrollY() >= ImGui::GetScrollMaxY()) ImGui::SetScrollHereY(1);
    }
    ImGui::EndChild();
  }
};

}  // namespace

std::unique_ptr<Panel> make_messages_panel(UiDesk&) { return std::make_unique<MessagesPanel>(); }

}  // namespace footlight::tools

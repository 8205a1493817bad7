#include "tools/footlight/preview/ui/escape.h"

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>  // ClosePopupToLevel: Dear ImGui closes popups by Esc only with its own navigation

namespace footlight::tools {

bool close_topmost(UiPanels& open, UiDesk& desk) {
  constexpr std::size_t kKeysPanel = 0;
  if (const int popups = ImGui::GetCurrentContext()->OpenPopupStack.Size; popups > 0) {
    ImGui::ClosePopupToLevel(popups - 1, true);
  } else if (open.is_open(kKeysPanel)) {
    open.set_open(kKeysPanel, false, desk);
  } else if (desk.fly().on()) {
    desk.fly().set_on(false);
  } else if (desk.measure().on) {
    desk.measure() = {};
  } else if (!desk.state().selection.fixtures.empty()) {
    desk.select(-1, false);
  } else {
    return false;
  }
  return true;
}

}  // namespace footlight::tools

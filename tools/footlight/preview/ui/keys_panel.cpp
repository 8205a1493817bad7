// The list of keys, from the table that handles them.
#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/outputs_view.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

class KeysPanel final : public Panel {
 public:
  void draw(UiDesk&, const UiInput& input) override {
    if (std::exchange(scale_, input.scale) != input.scale) measure();
    for (const KeyRow& row : key_rows()) {
      if (row.keys != nullptr) line(tr(row.keys), tr(row.does));
    }
    line(tr(kHoldKeyName), tr("held, if so asked for in F6: lamps are live"));
    ImGui::Separator();
    for (const PanelInfo& panel : panels()) {
      line(tr(panel.key_text), fmt::format("{}: {}", tr(panel.title), tr(panel.shows)));
    }
    ImGui::Separator();
    for (const MouseRow& row : mouse_rows()) line(tr(row.hands), tr(row.does));
  }

 private:
  // The keys of some languages are long.
  void measure() {
    keys_width_ = 160 * scale_;
    const auto fit = [&](const char* keys) {
      keys_width_ = std::max(keys_width_, ImGui::CalcTextSize(keys).x + 2 * ImGui::GetFontSize());
    };
    for (const KeyRow& row : key_rows()) {
      if (row.keys != nullptr) fit(tr(row.keys));
    }
    for (const MouseRow& row : mouse_rows()) fit(tr(row.hands));
  }

  void line(const char* keys, const std::string& does) const {
    ui_text(kUiAmber, keys);
    ImGui::SameLine(keys_width_);
    ImGui::PushTextWrapPos(0);
    ui_text(does);
    ImGui::PopTextWrapPos();
  }

  float scale_ = 0;  // that keys_width_ is for
  float keys_width_ = 160;
};

}  // namespace

std::unique_ptr<Panel> make_keys_panel(UiDesk&) { return std::make_unique<KeysPanel>(); }

}  // namespace footlight::tools

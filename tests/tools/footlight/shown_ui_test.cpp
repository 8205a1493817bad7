// The side panel of the window, and what need not be drawn again. Without a window.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "sim/system_clock.h"
#include "tests/support/must.h"
#include "tests/tools/footlight/side_panel_ui.h"
#include "tools/footlight/preview/window_ui.h"

namespace footlight::tools {
namespace {

using footlight::testing::must;

struct SidePanel final : testing::SidePanelUi {
  SidePanel() : SidePanelUi(800, 1200) {}
};

TEST_CASE("the list of live inputs leaves out what the window itself receives them with") {
  SystemClock clock;
  const std::array<Universe, 1> universes{1};
  const auto live = must(LiveLevels::start(universes, {}, clock));
  SidePanel panel;
  panel.live = live.get();
  panel.facts.status.ports.resize(2);
  panel.facts.status.ports[0].name = "sacn:1";
  panel.facts.status.ports[1].name = "own-trail";
  panel.facts.status.ports[1].is_sink = true;
  const std::string words = panel.words();
  CHECK(words.find("sacn:1") != std::string::npos);
  CHECK(words.find("own-trail") == std::string::npos);
}

TEST_CASE("panels that stay as they are need not be drawn again, and those that change do") {
  SidePanel panel;
  panel.facts.rig = "a rig";
  for (int i = 0; i < 3; ++i) panel.frame();  // sizes settle
  ShownUi shown;
  CHECK(shown.changes(*ImGui::GetDrawData()));  // the first ones
  panel.frame();
  CHECK(!shown.changes(*ImGui::GetDrawData()));
  panel.facts.rig = "b rig";
  panel.frame();
  CHECK(shown.changes(*ImGui::GetDrawData()));
  panel.frame();
  CHECK(!shown.changes(*ImGui::GetDrawData()));
  panel.controls.work_light = true;
  panel.frame();
  CHECK(shown.changes(*ImGui::GetDrawData()));
  shown.forget();
  CHECK(shown.changes(*ImGui::GetDrawData()));
}

TEST_CASE("a slider that moves by less than a quarter of a pixel need not be drawn again, until it has moved by one") {
  SidePanel panel;
  panel.facts.has_log = true;
  panel.controls.transport.duration_ns = 60 * kNsPerS;
  panel.controls.transport.now_ns = 10 * kNsPerS;
  for (int i = 0; i < 3; ++i) panel.frame();  // sizes settle
  ShownUi shown;
  CHECK(shown.changes(*ImGui::GetDrawData()));
  const TimeNs from_ns = panel.controls.transport.now_ns;
  while (panel.controls.transport.now_ns < from_ns + 99 * kNsPerMs) {  // within a tenth of a second, which is text
    panel.controls.transport.now_ns += kNsPerMs;
    panel.frame();
    if (shown.changes(*ImGui::GetDrawData())) break;
  }
  // Some four pixels a second.
  CHECK(panel.controls.transport.now_ns > from_ns + 50 * kNsPerMs);
  CHECK(panel.controls.transport.now_ns < from_ns + 99 * kNsPerMs);
  panel.frame();
  CHECK(!shown.changes(*ImGui::GetDrawData()));
}

}  // namespace
}  // namespace footlight::tools

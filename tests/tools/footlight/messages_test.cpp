// Messages of the window: boxes over the stage, and the panel that keeps them.
#include "tools/footlight/preview/ui/messages.h"

#include <string>

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/toasts.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kMessages = 7;

TEST_CASE("a message is shown for its time, errors longer, and at most four at once") {
  MessageLog log;
  log.add("saved", false, "20:00:00", 0);
  log.add("no route", true, "20:00:01", kNsPerS);
  CHECK(log.shown(kNsPerS).size() == 2);
  CHECK(log.shown(kNsPerS)[0]->text == "saved");
  CHECK(log.shown(MessageLog::kShownNs).size() == 1);
  CHECK(log.shown(MessageLog::kShownNs)[0]->wrong);
  CHECK(log.shown(kNsPerS + MessageLog::kWrongNs).empty());
  for (int i = 0; i < 9; ++i) log.add("message " + std::to_string(i), false, "", kNsPerS);
  const auto shown = log.shown(kNsPerS);
  REQUIRE(shown.size() == MessageLog::kBoxesMax);
  CHECK(shown.back()->text == "message 8");
  CHECK(log.all().size() == 11);
}

TEST_CASE("the same again is counted and shown anew, and the oldest are forgotten") {
  MessageLog log;
  for (int i = 0; i < 3; ++i) log.add("nothing to undo", false, "20:00:0" + std::to_string(i), i * kNsPerS);
  REQUIRE(log.all().size() == 1);
  CHECK(text_of(log.all()[0]) == "nothing to undo (3 times)");
  CHECK(log.all()[0].time == "20:00:02");
  CHECK(log.shown(2 * kNsPerS + MessageLog::kShownNs - 1).size() == 1);
  log.add("nothing to undo", true, "", 0);  // as an error it is another one
  CHECK(log.all().size() == 2);
  for (std::size_t i = 0; i < 2 * MessageLog::kKeptMax; ++i) log.add(std::to_string(i), false, "", 0);
  CHECK(log.all().size() == MessageLog::kKeptMax);
  CHECK(log.all().front().text == std::to_string(MessageLog::kKeptMax));
}

TEST_CASE("boxes stand one above the other at the bottom of the stage, within it, also with a long text") {
  const testing::HeadlessImGui imgui(800, 600);
  MessageLog log;
  const auto boxes = [&] {
    ImGui::NewFrame();
    draw_toasts(log, kNsPerS, {500, 600}, 1);
    ImRect place(1e6f, 1e6f, -1e6f, -1e6f);
    for (const ImDrawVert& vertex : ImGui::GetForegroundDrawList()->VtxBuffer) place.Add(vertex.pos);
    ImGui::Render();
    return place;
  };
  CHECK(boxes().Max.x < 0);
  log.add("saved", false, "", kNsPerS);
  const ImRect one = boxes();
  CHECK(one.Min.x > 0);
  CHECK(one.Max.y < 600);
  log.add("not armed: no route", true, "", kNsPerS);
  const ImRect two = boxes();
  CHECK(two.Max.y == doctest::Approx(one.Max.y));
  CHECK(two.Min.y < one.Min.y - 10);
  std::string words;
  for (int i = 0; i < 60; ++i) words += "a long message ";
  log.add(words, true, "", kNsPerS);
  const ImRect three = boxes();
  CHECK(three.Max.x <= 500);
  CHECK(three.Min.y >= 0);
}

TEST_CASE("the panel lists what was said, with its time, and copies it") {
  const testing::HeadlessImGui imgui(1280, 720);
  const testing::UiRig rig = testing::compiled_rig(testing::parsed_rig(testing::kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  UiPanels open;
  MessageLog log;
  UiInput input;
  input.messages = &log;
  open.set_open(kMessages, true, desk);
  const auto frame = [&](bool logs) {
    ImGui::NewFrame();
    if (logs) ImGui::LogToClipboard();
    open.draw(desk, input, 1280, 720);
    if (logs) ImGui::LogFinish();
    ImGui::Render();
  };
  for (int i = 0; i < 3; ++i) frame(false);
  frame(true);
  CHECK(std::string(ImGui::GetClipboardText()).find("no message yet") != std::string::npos);
  log.add("saved stage.toml", false, "20:15:07", 0);
  log.add("sacn:1: no route", true, "20:15:09", 0);
  for (int i = 0; i < 3; ++i) frame(false);
  frame(true);
  const std::string words = ImGui::GetClipboardText();
  for (const char* part : {"20:15:07", "saved stage.toml", "20:15:09", "sacn:1: no route"}) {
    INFO(part);
    CHECK(words.find(part) != std::string::npos);
  }
  // The button is at the top left.
  const ImRect place = ImGui::FindWindowByName("###Messages")->Rect();
  ImGuiIO& io = ImGui::GetIO();
  ImGui::SetClipboardText("");
  for (float y = place.Min.y + 24; y < place.Min.y + 60 && *ImGui::GetClipboardText() == 0; y += 5) {
    io.MousePos = {place.Min.x + 30, y};
    frame(false);
    io.MouseDown[0] = true;
    frame(false);
    io.MouseDown[0] = false;
    frame(false);
  }
  CHECK(std::string(ImGui::GetClipboardText()) == "20:15:07 saved stage.toml\n20:15:09 sacn:1: no route\n");
}

}  // namespace
}  // namespace footlight::tools

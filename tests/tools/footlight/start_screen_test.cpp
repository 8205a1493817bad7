// The screen of a window without a rig, with a mouse and without a window.
#include "tools/footlight/preview/ui/start_screen.h"

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>

#include <doctest/doctest.h>

#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/panels_test_imgui.h"
#include "tools/footlight/preview/start_window.h"

namespace footlight::tools {
namespace {

constexpr const char* kHall =
    "[rig]\nname = \"Hall\"\n[[fixture]]\nname = \"A\"\ntype = \"generic/par\"\nuniverse = 1\naddress = 1\n"
    "position = [0, 0, 4]\n";

struct StartUi : testing::DrawnUi {
  StartUi() {
    std::ofstream(folder.file("hall.toml")) << kHall;
    std::ofstream(folder.file("tour.show")) << "OLA Show\n1 0,255\n1000\n";
    std::ofstream(folder.file("notes.txt")) << "text\n";
    screen.emplace(std::vector{folder.file("hall.toml"), folder.file("gone.toml")},
                   std::vector{folder.file("tour.show")}, "");
  }
  void draw() override {
    if (auto one = screen->draw(1)) chosen = one;
  }
  void press_id(std::initializer_list<const char*> path) {
    for (int i = 0; i < 3; ++i) frame();
    testing::activate("###start", path);
    for (int i = 0; i < 3; ++i) frame();
  }
  // A row of a list.
  void press_row(const char* list, int row) {
    for (int i = 0; i < 3; ++i) frame();
    const ImGuiWindow* const window = ImGui::FindWindowByName("###start");
    REQUIRE(window != nullptr);
    const ImGuiID id = ImHashData(&row, sizeof(row), ImHashStr(list, 0, window->ID));
    ImGui::ActivateItem(ImHashStr("##row", 0, id));
    for (int i = 0; i < 3; ++i) frame();
  }

  testing::HeadlessImGui imgui{640, 360};
  const testing::TempFolder folder;
  std::optional<StartScreen> screen;
  std::optional<StartChoice> chosen;
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_CASE("the start screen opens the demo, a recent rig, or a file of the dialog, and says what to do") {
  StartUi ui;
  const std::string words = ui.words();
  for (const char* part : {"Open the demo", "Open a file", "drop a file", "Recent rigs", "hall.toml", "gone.toml",
                           "Recent logs", "tour.show"}) {
    CHECK_MESSAGE(has(words, part), part);
  }
  ui.press_id({"###Open the demo"});
  REQUIRE(ui.chosen);
  CHECK(*ui.chosen == StartChoice{true, "", ""});
  ui.chosen.reset();
  ui.press_row("Recent rigs", 0);
  REQUIRE(ui.chosen);
  CHECK(*ui.chosen == StartChoice{false, ui.folder.file("hall.toml"), ""});
  ui.chosen.reset();
  ui.press_row("Recent rigs", 1);
  CHECK(!ui.chosen);
  CHECK(has(ui.words(), "gone.toml: there is no such file"));
  CHECK(!ui.screen->has_keys());
  ui.press_id({"###Open a file ..."});
  CHECK(ui.screen->has_keys());
  CHECK(ImGui::GetTopMostPopupModal() != nullptr);
}

TEST_CASE("a log that is chosen first plays on the rig that is opened after it") {
  StartUi ui;
  ui.press_row("Recent logs", 0);
  CHECK(!ui.chosen);
  CHECK(has(ui.words(), "The log tour.show plays as soon as a rig is opened."));
  ui.press_row("Recent rigs", 0);
  REQUIRE(ui.chosen);
  CHECK(*ui.chosen == StartChoice{false, ui.folder.file("hall.toml"), ui.folder.file("tour.show")});
  ui.press_id({"###without it"});
  CHECK(ui.screen->log().empty());
}

TEST_CASE("a file that is dropped on the start screen is opened, and one that is unknown is named") {
  StartUi ui;
  CHECK(!ui.screen->take_files({ui.folder.file("notes.txt")}));
  CHECK(has(ui.words(), "notes.txt: is no definition"));
  CHECK(!ui.chosen);
  CHECK(ui.screen->take_files({ui.folder.file("tour.show"), ui.folder.file("hall.toml")}));
  CHECK(!has(ui.words(), "notes.txt"));
  REQUIRE(ui.chosen);
  CHECK(*ui.chosen == StartChoice{false, ui.folder.file("hall.toml"), ui.folder.file("tour.show")});
}

TEST_CASE("only a window without a rig and without the demo begins with the start screen") {
  PreviewOptions options;
  CHECK(needs_start(options));
  options.files.log = "show.dmxlog";
  CHECK(needs_start(options));
  options.files.demo = true;
  CHECK(!needs_start(options));
  options.files.demo = false;
  options.files.rig = "hall.toml";
  CHECK(!needs_start(options));
}

}  // namespace
}  // namespace footlight::tools

// The panel of the library, without a window.
#include <algorithm>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "tests/support/definition_files.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/edit_ui.h"

namespace footlight::tools {
namespace {

using footlight::testing::EditUi;
using footlight::testing::kUiRig;
using footlight::testing::parsed_rig;
using footlight::testing::qxf_head;
using footlight::testing::TempFolder;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::size_t panel_of(const std::string& word) {
  const auto all = panels();
  const auto at = std::find_if(all.begin(), all.end(), [&](const PanelInfo& one) { return word == one.word; });
  REQUIRE(at != all.end());
  return static_cast<std::size_t>(at - all.begin());
}

// Opens the panel and waits for its thread. The list is on the left of x = 700, the details are on the right.
void show_library(EditUi& ui, const TempFolder& folder) {
  ui.desk.list_definitions_in({{folder.path().string()}});
  ui.show(panel_of("library"));
  for (int i = 0; i < 10'000 && contains(ui.words(), "stop"); ++i) std::this_thread::yield();
  REQUIRE(!contains(ui.words(), "stop"));
}

// Types words into the search field and chooses the first row.
void choose(EditUi& ui, const std::string& words) {
  ui.pause();
  ui.press(300, 152);
  ui.type(words);
  REQUIRE(ui.click_down(400, 186, 230, [&] { return !contains(ui.words(), "Click a definition."); }).y > 0);
}

TEST_CASE("the library lists what is installed, a search narrows it, and a broken file shows its error") {
  const TempFolder folder;
  folder.write("one.qxf", qxf_head("Robe", "Spot One", {{"short", 3}, {"long", 4}}));
  folder.write("cut.qxf", "<?xml version=\"1.0\"?><FixtureDefinition><Manufacturer>Robe</Manufacturer><Model>Cut");
  EditUi ui(parsed_rig(kUiRig));
  show_library(ui, folder);
  const std::string all = ui.words();
  for (const char* part : {"Spot One", "generic/profile", "vrsl/spot", "one.qxf", "cannot be read", "moving head",
                           "3 - 4", "1 cannot be read"}) {
    CHECK_MESSAGE(contains(all, part), part);
  }
  ui.pause();
  ui.press(300, 152);
  ui.type("LONG robe");
  CHECK(contains(ui.words(), "1 of "));
  CHECK(contains(ui.words(), "Spot One"));
  CHECK(!contains(ui.words(), "generic/profile"));
  ui.pause();
  ui.press(300, 152);
  ui.type("one.qxf");  // a file's name is no word of it
  CHECK(contains(ui.words(), "0 of "));
}

TEST_CASE("a broken definition that is chosen shows why, and cannot be added") {
  const TempFolder folder;
  folder.write("cut.qxf", "<?xml version=\"1.0\"?><FixtureDefinition><Manufacturer>Robe</Manufacturer><Model>Cut");
  EditUi ui(parsed_rig(kUiRig));
  show_library(ui, folder);
  choose(ui, "cut");
  CHECK(contains(ui.words(), "cut.qxf:1"));
  CHECK(!contains(ui.words(), "Add"));
}

TEST_CASE("Add puts fixtures into the rig at the first free addresses and selects them, and undo takes them back") {
  const TempFolder folder;
  folder.write("one.qxf", qxf_head("Robe", "Spot One", {{"long", 4}}));
  EditUi ui(parsed_rig(kUiRig));
  show_library(ui, folder);
  choose(ui, "spot one");
  const std::string details = ui.words();
  CHECK(contains(details, "qxf, moving head, 2 gobos"));
  CHECK(contains(details, "long: 4 slots, 4 channels"));
  CHECK(contains(details, "3 Dimmer"));
  CHECK(contains(details, "Spot One 1 at 1.43"));  // what Add would do
  const auto count = [&] { return ui.desk.edited().fixtures.size(); };
  const ImVec2 add = ui.click_down(730, 200, 400, [&] { return count() > 5; });
  REQUIRE(add.y > 0);
  REQUIRE(count() == 6);
  CHECK(ui.edit.fixture(5).name == "Spot One 1");
  CHECK(ui.edit.patch(5) == "1.43");
  CHECK(ui.desk.state().selection.fixtures == std::vector<int>{5});
  CHECK(ui.edit.scene->scene()->rig.fixtures.size() == 6);  // what the picture is made from
  CHECK(ui.desk.take_news() == "added Spot One 1 at 1.43 (Ctrl+Z takes it back)");
  CHECK(contains(ui.words(), "Spot One 2 at 1.47"));
  ui.pause();
  ui.press(add.x, add.y);
  REQUIRE(count() == 7);
  CHECK(ui.edit.fixture(6).position_m == ui.edit.fixture(5).position_m + glm::dvec3(1, 0, 0));
  CHECK(ui.desk.edited().types.size() == 3);
  CHECK(ui.desk.undo() == "add Spot One 2 at 1.47");
  CHECK(ui.desk.undo() == "add Spot One 1 at 1.43");
  CHECK(ui.desk.edited().types.size() == 2);
  CHECK(count() == 5);
  CHECK(contains(ui.words(), "Spot One 1 at 1.43"));
  CHECK(ui.desk.redo() == "add Spot One 1 at 1.43");
  CHECK(ui.edit.fixture(5).name == "Spot One 1");
}

// A click on the field of a label, which is left of it in the details, and a text.
void fill(EditUi& ui, float y, const std::string& text) {
  ui.pause();
  ImGui::GetIO().KeyCtrl = true;  // numbers are typed after a click with Ctrl
  ui.press(760, y);
  ImGui::GetIO().KeyCtrl = false;
  ui.frame();
  ui.type(text);
}

TEST_CASE("count, mode and address are those that the fields say, and what cannot be added says why") {
  const TempFolder folder;
  folder.write("one.qxf", qxf_head("Robe", "Spot One", {{"short", 3}, {"long", 4}}));
  EditUi ui(parsed_rig(kUiRig));
  show_library(ui, folder);
  choose(ui, "spot one");
  // The mode: a list opens at one of the lines, and its second entry is chosen.
  const ImVec2 combo = ui.click_down(760, 190, 280, [&] { return EditUi::has_popup(); });
  REQUIRE(combo.y > 0);
  for (float down = 10; down < 70; down += 5) {
    if (!EditUi::has_popup()) ui.press(combo.x, combo.y);
    ui.pause();
    ui.press(combo.x, combo.y + down);
    if (!EditUi::has_popup() && contains(ui.words(), "long: 4 slots") && !contains(ui.words(), "short: 3 slots")) break;
  }
  REQUIRE(contains(ui.words(), "long: 4 slots"));
  float count_y = 0;
  for (float y = combo.y + 20; y < combo.y + 44 && count_y == 0; y += 4) {
    fill(ui, y, "3");
    if (contains(ui.words(), "Spot One 1 to Spot One 3, 1.43 to 1.51")) count_y = y;
  }
  REQUIRE(count_y > 0);
  const float address_y = count_y + 2 * ImGui::GetFrameHeightWithSpacing();
  fill(ui, address_y, "5.507");
  CHECK(contains(ui.words(), "Spot One 1 to Spot One 3, 5.507 to 6.5"));
  fill(ui, address_y, "5.510");
  CHECK(contains(ui.words(), "choose an address of at most 509"));
  const auto count = [&] { return ui.desk.edited().fixtures.size(); };
  CHECK(ui.click_down(730, address_y + 60, 420, [&] { return count() > 5; }).y < 0);  // Add is off
  fill(ui, address_y, "nonsense");
  CHECK(contains(ui.words(), "expected universe.address such as 2.101"));
  fill(ui, address_y, "5.1");
  REQUIRE(ui.click_down(730, address_y + 40, 420, [&] { return count() > 5; }).y > 0);
  REQUIRE(count() == 8);
  CHECK(ui.edit.patch(5) == "5.1");
  CHECK(ui.edit.patch(7) == "5.9");
  CHECK(fixtures::mode_of(ui.desk.edited(), ui.edit.fixture(7)).name == "long");
  CHECK(ui.desk.state().selection.fixtures == std::vector<int>{5, 6, 7});
  CHECK(contains(ui.words(), "Spot One 4 to Spot One 6, 1.43 to 1.51"));  // the first free one again
}

TEST_CASE("a long library costs no more to draw than one that fills the list") {
  int vertices[2] = {};
  for (const int count : {60, 600}) {
    const TempFolder folder;
    for (int i = 0; i < count; ++i) {
      folder.write(fmt::format("{:03}.qxf", i), qxf_head("A", fmt::format("N{:03}", i), {{"m", 4}}));
    }
    EditUi ui(parsed_rig(kUiRig));
    show_library(ui, folder);
    ui.frame();
    vertices[count > 60 ? 1 : 0] = ImGui::GetDrawData()->TotalVtxCount;
  }
  CHECK(vertices[0] > 1000);
  CHECK(std::abs(vertices[1] - vertices[0]) < 200);  // the scroll bar, and digits of the number of definitions
}

TEST_CASE("the library may be closed while it reads, and has F7") {
  const TempFolder folder;
  for (int i = 0; i < 300; ++i) {
    folder.write(fmt::format("{}.qxf", i), qxf_head("A", fmt::format("N{}", i), {{"m", 4}}));
  }
  EditUi ui(parsed_rig(kUiRig));
  ui.desk.list_definitions_in({{folder.path().string()}});
  CHECK(std::string(panels()[panel_of("library")].key_text) == "F7");
  ui.open.set_open(panel_of("library"), true, ui.desk);
  ui.frame();
  ui.open.set_open(panel_of("library"), false, ui.desk);
  ui.frame();
  CHECK(!ui.open.any_open());
}

}  // namespace
}  // namespace footlight::tools

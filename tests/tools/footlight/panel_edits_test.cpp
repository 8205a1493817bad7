// Panels that edit the rig, without a window.
#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/edit_ui.h"
#include "tools/footlight/preview/mouse_queue.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/menu.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/questions.h"
#include "tools/footlight/preview/ui/rig_editor.h"

namespace footlight::tools {
namespace {

using footlight::testing::EditUi;
using footlight::testing::kUiRig;
using footlight::testing::many_fixtures;
using footlight::testing::parsed_rig;

constexpr std::size_t kFixtures = 2;
constexpr std::size_t kInspector = 3;
constexpr const char* kPatchWindow = "###Fixtures";

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST_CASE("a double click on a name edits it, Enter takes it, and undo brings it back") {
  EditUi ui(parsed_rig(kUiRig));
  ui.show(kFixtures);
  const ImVec2 row = ui.row_of(1, 60);
  REQUIRE(row.y > 0);
  ui.twice(row.x, row.y);
  CHECK(ui.has_popup());
  CHECK(contains(ui.words(), "Name of Spot 2"));
  ui.type("LX 7");
  CHECK(!ui.has_popup());
  CHECK(ui.edit.fixture(1).name == "LX 7");
  CHECK(contains(ui.words(), "LX 7"));
  CHECK(ui.desk.undo() == "rename Spot 2 to LX 7");
  CHECK(contains(ui.words(), "Spot 2"));
}

TEST_CASE("a wrong name stays in the field with the reason, and changes nothing") {
  EditUi ui(parsed_rig(kUiRig));
  ui.show(kFixtures);
  const ImVec2 row = ui.row_of(1, 60);
  REQUIRE(row.y > 0);
  ui.twice(row.x, row.y);
  ui.type("Par");
  CHECK(ui.has_popup());
  CHECK(contains(ui.words(), "another fixture is called 'Par'"));
  CHECK(ui.edit.fixture(1).name == "Spot 2");
}

// Opens the menu of the selection at a row and clicks the entry at which `done` becomes true.
template <class Done>
bool choose(EditUi& ui, ImVec2 row, Done done) {
  for (float down = 20; down < 260; down += 8) {
    ui.press(1200, 700);  // closes what is open, beside all
    ui.press(row.x, row.y, 1);
    if (!EditUi::has_popup()) return false;
    ui.press(row.x + 30, row.y + down);
    ui.frame();
    if (done()) return true;
  }
  return false;
}

TEST_CASE("a right click selects a row and opens a menu, and addresses count up as the rows are listed") {
  EditUi ui(parsed_rig(kUiRig));
  ui.show(kFixtures);
  const ImVec2 row = ui.row_of(1, 60);
  REQUIRE(row.y > 0);
  ui.desk.select(-1, false);
  ui.press(row.x, row.y, 1);
  CHECK(ui.desk.state().selection.fixtures == std::vector<int>{1});
  CHECK(ui.has_popup());
  for (const char* entry : {"Address...", "Name...", "Number...", "Mode", "Clone...", "Unpatch", "Delete"}) {
    CHECK(contains(ui.words(), entry));
  }
  ui.desk.select(0, false);
  ui.desk.select(1, true);
  ui.desk.select(2, true);
  REQUIRE(choose(ui, row, [&] { return contains(ui.words(), "Address of 3 fixtures"); }));
  ui.type("7.490");
  CHECK(ui.edit.patch(0) == "7.490");
  CHECK(ui.edit.patch(1) == "8.1");
  CHECK(ui.edit.patch(2) == "8.15");
  CHECK(ui.desk.undo() == "patch 3 fixtures from 7.490");
}

TEST_CASE("the menu unpatches, deletes and copies what is selected") {
  EditUi ui(parsed_rig(kUiRig));
  ui.show(kFixtures);
  const ImVec2 row = ui.row_of(1, 60);
  REQUIRE(row.y > 0);
  const auto count = [&] { return ui.desk.edited().fixtures.size(); };
  CHECK(choose(ui, row, [&] { return contains(ui.words(), "Clone of Spot 2"); }));
  ui.press(1200, 700);
  CHECK(choose(ui, row, [&] {
    if (count() < 5) ui.desk.undo();
    return ui.edit.patch(1) == "-";
  }));
  CHECK(ui.desk.undo() == "unpatch Spot 2");
  ui.desk.select(1, false);
  CHECK(choose(ui, row, [&] {
    if (ui.edit.patch(1) == "-") ui.desk.undo();
    return count() == 4;
  }));
  CHECK(ui.desk.undo() == "delete Spot 2");
  CHECK(ui.edit.fixture(1).name == "Spot 2");
}

TEST_CASE("a popup of an edit closes when another edit changes the rig") {
  EditUi ui(parsed_rig(kUiRig));
  ui.show(kFixtures);
  const ImVec2 row = ui.row_of(1, 60);
  REQUIRE(row.y > 0);
  ui.desk.select(0, false);
  REQUIRE(ui.desk.edit(fixtures::delete_fixtures(ui.desk.edited(), ui.desk.selected())));
  for (int i = 0; i < 3; ++i) ui.frame();
  const ImVec2 now = ui.row_of(0, 60);
  REQUIRE(now.y > 0);
  ui.twice(now.x, now.y);
  REQUIRE(contains(ui.words(), "Name of Spot 2"));
  while (ui.desk.edited().fixtures.size() == 4) REQUIRE(!ui.desk.undo().empty());
  ui.frame();
  ui.frame();
  CHECK(!ui.has_popup());
}

TEST_CASE("the inspector's place is dragged as one edit, also between two pictures, and typed") {
  EditUi ui(parsed_rig(kUiRig));
  ui.desk.select(0, false);
  ui.desk.select(1, true);  // the lead
  ui.show(kInspector);
  const auto x_of = [&](std::size_t i) { return fixtures::position_of(ui.edit.fixture(i)).x; };
  MouseQueue mouse;
  const auto give = [&] {
    ImGuiIO& io = ImGui::GetIO();
    while (const auto moment = mouse.next()) {
      io.MousePos = {moment->x, moment->y};
      const bool ends = io.MouseDown[0] && !moment->down[0];
      if (!io.MouseDown[0] && moment->down[0]) ui.desk.begin_gesture();
      io.MouseDown[0] = moment->down[0];
      ui.frame();
      if (ends) ui.desk.begin_gesture();
    }
    ui.frame();
  };
  // A press, a move and the release come within one picture. Lines of the panel are tried until the position follows.
  float y = 60;
  for (; y < 400 && x_of(1) == 0; y += 6) {
    mouse.take_move(890, y);
    give();
    mouse.take_button(0, true, 0);
    mouse.take_move(940, 700);  // a release beside a button does not press it
    mouse.take_button(0, false, 0);
    const std::size_t before = ui.desk.history().size();
    give();
    while (x_of(1) == 0 && ui.desk.history().size() > before && !ui.desk.undo().empty()) continue;
    ui.pause();
  }
  REQUIRE(x_of(1) > 0);
  CHECK(x_of(1) == doctest::Approx(1));  // 50 units, 2 cm each
  CHECK(x_of(0) == doctest::Approx(x_of(1) - 3));
  CHECK(x_of(2) == 3);
  CHECK(contains(ui.desk.undo(), "move 2 fixtures by"));
  CHECK(x_of(1) == 0);
  CHECK(x_of(0) == -3);
  y -= 6;
  ui.pause();
  ImGui::GetIO().KeyCtrl = true;
  ui.press(890, y);
  ImGui::GetIO().KeyCtrl = false;
  ui.type("2.5");
  CHECK(x_of(1) == 2.5);
  CHECK(x_of(0) == -0.5);
}

TEST_CASE("panels and values taken over rest while fixtures of another rig move") {
  EditUi ui(parsed_rig(kUiRig));
  ui.desk.select(0, false);
  ui.show(kInspector);
  const std::vector<std::uint8_t> levels(ui.desk.compiled().universes.size() * kSlotCountMax);
  ui.desk.take({0, 0}, 7, levels);
  CHECK(ui.desk.overlays());
  ui.desk.pause_overlay(true);
  ui.open.pause(true);
  CHECK(!ui.desk.overlays());
  const std::vector<std::uint8_t> of_more_universes(levels.size() + kSlotCountMax);
  ui.open.step(of_more_universes, kNsPerS, true);  // the inspector's head has fewer
  ui.desk.pause_overlay(false);
  ui.open.pause(false);
  CHECK(ui.desk.overlays());
  ui.open.step(levels, kNsPerS, true);
  ui.frame();
}

TEST_CASE("fixtures that share slots are marked while they do") {
  EditUi ui(parsed_rig(kUiRig));
  ui.show(kFixtures);
  CHECK(!contains(ui.words(), "share addresses"));
  ui.desk.select(3, false);
  REQUIRE(ui.desk.edit(fixtures::patch_fixtures(ui.desk.edited(), ui.desk.selected(), {1, 3})));
  CHECK(contains(ui.words(), "2 share addresses"));
  CHECK(contains(ui.words(), "1.3 !"));
  ui.desk.undo();
  CHECK(!contains(ui.words(), "share addresses"));
}

// The fixtures of kUiRig that the patch lists, in its order, by the first letters of their names.
std::string listed(EditUi& ui) {
  const std::string words = ui.words();
  std::vector<std::pair<std::size_t, const char*>> found;
  for (const auto& [name, brief] : {std::pair("Spot 1", "1"), std::pair("Spot 2", "2"), std::pair("Spot 3", "3"),
                                    std::pair("Far par", "F"), std::pair("Par", "P")}) {
    std::size_t at = words.find(name);
    while (at != std::string::npos && words.substr(0, at).ends_with("Generic "))
      at = words.find(name, at + 1);  // a type
    if (at != std::string::npos) found.emplace_back(at, brief);
  }
  std::sort(found.begin(), found.end());
  std::string order;
  for (const auto& one : found) order += one.second;
  return order;
}

TEST_CASE("the patch is narrowed by a text that is typed") {
  const auto filtered = [](const char* text) {
    EditUi ui(parsed_rig(kUiRig));
    ui.show(kFixtures);
    CHECK(listed(ui) == "123PF");
    const ImVec2 field = ui.click_down(60, 28, 60, [] { return ImGui::GetIO().WantTextInput; });
    REQUIRE(field.y > 0);
    ui.type(text);
    return std::pair(listed(ui), ui.words());
  };
  const auto [spots, words] = filtered("SPOT");
  CHECK(spots == "123");
  CHECK(contains(words, "3 of 5 fixtures"));
  CHECK(filtered("far").first == "F");
  CHECK(filtered("par").first == "PF");
  CHECK(filtered("2.508").first == "F");
  CHECK(filtered("nobody").first.empty());
}

TEST_CASE("boxes of the patch show only fixtures that share addresses, or that have none") {
  EditUi ui(parsed_rig(kUiRig));
  ui.show(kFixtures);
  CHECK(!contains(ui.words(), "no address"));
  const auto press = [&](const char* box) {
    testing::activate(kPatchWindow, {box});
    for (int i = 0; i < 2; ++i) ui.frame();
  };
  ui.desk.select(3, false);
  REQUIRE(ui.desk.edit(fixtures::patch_fixtures(ui.desk.edited(), ui.desk.selected(), {1, 3})));
  ui.desk.select(2, false);
  REQUIRE(ui.desk.edit(fixtures::unpatch_fixtures(ui.desk.edited(), ui.desk.selected())));
  CHECK(contains(ui.words(), "1 has no address"));
  press("###unpatched");
  CHECK(listed(ui) == "3");
  press("###conflicts");
  CHECK(listed(ui).empty());  // nobody is both
  press("###unpatched");
  CHECK(listed(ui) == "1P");
  press("###conflicts");
  press("###unpatched");
  CHECK(listed(ui) == "3");
  // When the last one has an address again, the box is gone, and with it what it hid.
  ui.desk.undo();
  CHECK(!contains(ui.words(), "no address"));
  CHECK(listed(ui).size() == 5);
}

TEST_CASE("a click on a heading sorts the patch by its column, another one the other way round") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  const std::array<const char*, 5> layers{"Back", "Front", "Middle", "Zenith", "Attic"};
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) rig.fixtures[i].labels.layer = layers[i];
  EditUi ui(std::move(rig));
  ui.show(kFixtures);
  CHECK(contains(ui.words(), "Layer"));
  CHECK(contains(ui.words(), "Zenith"));
  CHECK(listed(ui) == "123PF");
  ImGui::SetWindowSize(kPatchWindow, {1000, 400});
  // Along the headings, which are above the rows.
  std::set<std::string> orders;
  for (float y = 54; y < 76; y += 7) {
    for (float x = 20; x < 700; x += 20) {
      ui.press(x, y);
      orders.insert(listed(ui));
    }
  }
  CHECK(orders.contains("FP123"));  // by name
  CHECK(orders.contains("321PF"));  // by name downwards
  CHECK(orders.contains("F123P"));  // by layer
  CHECK(orders.contains("P321F"));  // by layer downwards
  CHECK(orders.contains("FP321"));  // by address downwards
}

TEST_CASE("fixtures are renumbered in the order of the patch from the menu of the selection") {
  EditUi ui(parsed_rig(kUiRig));
  ui.show(kFixtures);
  const ImVec2 row = ui.row_of(1, 60);
  REQUIRE(row.y > 0);
  ui.desk.select(0, false);
  ui.desk.select(1, true);
  ui.desk.select(4, true);
  REQUIRE(choose(ui, row, [&] { return contains(ui.words(), "Number of 3 fixtures"); }));
  ui.type("31");
  CHECK(ui.edit.fixture(0).labels.fixture_id_numeric == 31);
  CHECK(ui.edit.fixture(1).labels.fixture_id_numeric == 32);
  CHECK(ui.edit.fixture(4).labels.fixture_id_numeric == 33);
}

TEST_CASE("panels survive every edit of a rig that they show") {
  EditUi ui(parsed_rig(kUiRig));
  for (std::size_t i = 0; i < panels().size(); ++i) ui.show(i);
  const auto edit = [&](Result<fixtures::RigEdit> one) {
    CHECK(ui.desk.edit(std::move(one)));
    ui.frame();
    ui.frame();
  };
  ui.desk.select_all();
  ui.frame();
  CHECK(ui.desk.clone_selected({3, {0, 1, 0}}));
  ui.frame();
  edit(fixtures::patch_fixtures(ui.desk.edited(), ui.desk.selected(), {9, 1}));
  edit(fixtures::unpatch_fixtures(ui.desk.edited(), ui.desk.selected()));
  edit(fixtures::set_mode(ui.desk.edited(), std::vector{0}, "8 bit"));
  edit(fixtures::delete_fixtures(ui.desk.edited(), ui.desk.selected()));
  ui.desk.select_all();
  ui.frame();
  edit(fixtures::delete_fixtures(ui.desk.edited(), ui.desk.selected()));
  CHECK(ui.desk.edited().fixtures.empty());
  while (!ui.desk.undo().empty()) ui.frame();
  while (!ui.desk.redo().empty()) ui.frame();
}

TEST_CASE("Del deletes what is selected, and only if the rig can be edited") {
  EditUi ui(parsed_rig(kUiRig));
  CHECK(delete_selected(ui.desk).empty());
  ui.desk.select(1, false);
  CHECK(delete_selected(ui.desk) == "delete Spot 2 (Ctrl+Z brings it back)");
  CHECK(ui.desk.edited().fixtures.size() == 4);
  const auto rig = footlight::testing::compiled_rig(parsed_rig(kUiRig));
  UiDesk fixed(rig.rig, rig.compiled);
  fixed.select(1, false);
  CHECK(delete_selected(fixed).empty());
}

TEST_CASE("the question before closing has three answers, and goes away with one") {
  for (const auto expected : {CloseAnswer::kSave, CloseAnswer::kDiscard, CloseAnswer::kStay}) {
    EditUi ui(parsed_rig(kUiRig));
    ui.asks = true;
    for (int i = 0; i < 3; ++i) ui.frame();
    CHECK(contains(ui.words(), "/shows/club.toml"));
    CHECK(!ui.answer);
    // The buttons are in a line below the middle.
    for (float y = 350; y < 420 && ui.answer != expected; y += 5) {
      for (float x = 480; x < 800 && ui.answer != expected; x += 20) {
        ImGui::GetIO().MousePos = {x, y};
        ui.frame();
        ImGui::GetIO().MouseDown[0] = true;
        ui.frame();
        ImGui::GetIO().MouseDown[0] = false;
        ui.frame();
      }
    }
    CHECK(ui.answer == expected);
  }
}

TEST_CASE("the line about lost edits recovers, keeps or discards them by one click each") {
  for (const auto& [button, expected] :
       {std::pair("###Recover", LostAnswer::kRecover), std::pair("###Keep", LostAnswer::kKeep),
        std::pair("###Discard", LostAnswer::kDiscard)}) {
    EditUi ui(parsed_rig(kUiRig));
    std::optional<LostAnswer> answer;
    ui.more = [&] {
      if (const auto one = draw_lost_edits("12:31", false, 1)) answer = one;
    };
    for (int i = 0; i < 3; ++i) ui.frame();
    CHECK(contains(ui.words(), "automatic copy of 12:31."));
    CHECK(!answer);
    footlight::testing::activate("lost edits", {button});
    ui.frame();
    ui.frame();
    CHECK(answer == expected);
  }
}

TEST_CASE("10,000 fixtures are edited and listed") {
  EditUi ui(many_fixtures(10'000).rig);
  ui.show(kFixtures);
  ui.desk.select_all();
  CHECK(ui.desk.edit(fixtures::move_fixtures(ui.desk.edited(), ui.desk.selected(), {0, 0, 1})));
  ui.frame();
  CHECK(ui.edit.fixture(9'999).position_m.z == 6);
  CHECK(ui.desk.undo() == "move 10000 fixtures by 0.00, 0.00, 1.00 m");
}

}  // namespace
}  // namespace footlight::tools

// Edits of the rig on the desk of the window, without a window.
#include <algorithm>
#include <map>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/edit/rig_cameras.h"
#include "fixtures/files/definition_list.h"
#include "tests/support/definition_files.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/edit_desk.h"
#include "tools/footlight/preview/ui/channel_reading.h"

namespace footlight::tools {
namespace {

using footlight::testing::EditDesk;
using footlight::testing::kUiRig;
using footlight::testing::many_fixtures;
using footlight::testing::parsed_rig;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

struct Snapshot {
  std::vector<fixtures::PatchedFixture> fixtures;
  Selection selection;
  std::map<ChannelKey, std::uint32_t> taken;
  std::uint64_t revision = 0;
};
Snapshot snapshot(const UiDesk& desk) {
  return {desk.edited().fixtures, desk.state().selection, desk.state().taken, desk.state().revision};
}
bool same(const Snapshot& a, const Snapshot& b) {
  return a.selection == b.selection && a.taken == b.taken && a.revision == b.revision &&
         std::equal(a.fixtures.begin(), a.fixtures.end(), b.fixtures.begin(), b.fixtures.end(), fixtures::same_fixture);
}

// What every panel counts on.
void check_consistent(const UiDesk& desk) {
  const std::size_t count = desk.edited().fixtures.size();
  REQUIRE(desk.rig().fixtures.size() == count);
  REQUIRE(desk.compiled().head_first.size() == count + 1);
  const Selection& selection = desk.state().selection;
  for (const int fixture : selection.fixtures) REQUIRE(static_cast<std::size_t>(fixture) < count);
  REQUIRE((selection.lead < 0 || selection.has(selection.lead)));
  for (const auto& [key, raw] : desk.state().taken) {
    REQUIRE(static_cast<std::size_t>(key.fixture) < count);
    const auto& fixture = desk.rig().fixtures[static_cast<std::size_t>(key.fixture)];
    REQUIRE(static_cast<std::size_t>(key.channel) < fixtures::mode_of(desk.rig(), fixture).channels.size());
  }
}

TEST_CASE("edits of the rig, selections and values taken over are undone and done again in any order") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  std::mt19937 random(9);
  std::vector<Snapshot> states{snapshot(desk)};
  while (states.size() < 120) {
    desk.begin_gesture();
    const auto count = static_cast<int>(desk.edited().fixtures.size());
    const int fixture = count > 0 ? static_cast<int>(random() % static_cast<unsigned>(count)) : -1;
    const std::vector<std::uint8_t> levels(desk.compiled().universes.size() * kSlotCountMax);
    switch (random() % 9) {
      case 0: desk.select(fixture, random() % 2 == 0); break;
      case 1: desk.select_all(); break;
      case 2:
        if (fixture >= 0) desk.take({fixture, static_cast<int>(random() % 3)}, random() % 256, levels);
        break;
      case 3: (void)desk.clone_selected({1, {0, 1, 0}}); break;
      case 4:
        if (static_cast<int>(desk.selected().size()) < count && (count > 20 || random() % 3 == 0))
          (void)desk.edit(fixtures::delete_fixtures(desk.edited(), desk.selected()));
        break;
      case 5:
        (void)desk.edit(
            fixtures::patch_fixtures(desk.edited(), desk.selected(),
                                     {1 + static_cast<int>(random() % 3), 1 + static_cast<int>(random() % 300)}));
        break;
      case 6: (void)desk.edit(fixtures::set_mode(desk.edited(), desk.selected(), "8 bit")); break;
      case 7: (void)desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), {0, 0, 0.1})); break;
      default: (void)desk.edit(fixtures::unpatch_fixtures(desk.edited(), desk.selected())); break;
    }
    check_consistent(desk);
    if (!same(snapshot(desk), states.back())) states.push_back(snapshot(desk));
  }
  const std::size_t edits = desk.history().size();
  CHECK(edits == states.size() - 1);
  for (std::size_t i = states.size() - 1; i-- > 0;) {
    CHECK(!desk.undo().empty());
    check_consistent(desk);
    REQUIRE(same(snapshot(desk), states[i]));
  }
  CHECK(desk.state().revision == 0);
  for (std::size_t i = 1; i < states.size(); ++i) {
    CHECK(!desk.redo().empty());
    check_consistent(desk);
    REQUIRE(same(snapshot(desk), states[i]));
  }
}

fixtures::NewFixtures new_heads(const std::string& path, int count = 2) {
  auto type = fixtures::open_definition(path);
  REQUIRE_MESSAGE(type, type.error().message);
  fixtures::NewFixtures row;
  row.type = std::make_shared<const fixtures::FixtureType>(std::move(*type));
  row.count = count;
  return row;
}

TEST_CASE(
    "new fixtures are selected and shown with their type, and undo, redo and other types keep every index right") {
  const testing::TempFolder folder;
  const std::string one = folder.write("one.qxf", testing::qxf_head("Robe", "Spot One", {{"long", 4}}));
  const std::string two = folder.write("two.qxf", testing::qxf_head("Robe", "Spot Two", {{"short", 3}}));
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  const auto type_shown = [&](std::size_t fixture) {
    const auto& shown = desk.rig().fixtures[fixture];
    return fixtures::type_of(desk.rig(), shown).name;
  };
  desk.select(0, false);
  CHECK(desk.add(new_heads(one)));
  check_consistent(desk);
  CHECK(desk.state().selection.fixtures == std::vector<int>{5, 6});
  CHECK(type_shown(6) == "Spot One");
  const SharedScene with_one = edit.scene->scene();
  CHECK(desk.undo() == "add 2 Spot One from 1.43");
  check_consistent(desk);
  CHECK(desk.state().selection.fixtures == std::vector<int>{0});
  CHECK(desk.edited().types.size() == 2);
  CHECK(desk.rig().types.size() == 2);
  CHECK(edit.scene->file().imported().definitions.size() == 2);
  CHECK(with_one->rig.types.size() == 3);  // a frame may still be made from it
  // Another type in the same place, also in scenes that are used again.
  for (int round = 0; round < 4; ++round) {
    const std::string& path = round % 2 == 0 ? two : one;
    CHECK(desk.add(new_heads(path, 1)));
    check_consistent(desk);
    CHECK(type_shown(5) == (round % 2 == 0 ? "Spot Two" : "Spot One"));
    CHECK(edit.scene->file().imported().definitions.back().name == path);
    CHECK(!desk.undo().empty());
  }
  CHECK(!desk.redo().empty());
  CHECK(type_shown(5) == "Spot One");
  CHECK(desk.add(new_heads(two, 1)));
  CHECK(type_shown(6) == "Spot Two");
  while (!desk.undo().empty()) check_consistent(desk);
  while (!desk.redo().empty()) check_consistent(desk);
  CHECK(type_shown(6) == "Spot Two");
  CHECK(desk.rig().types.size() == 4);
}

TEST_CASE("a type whose rig cannot be made goes with the edit that is taken back") {
  const testing::TempFolder folder;
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  fixtures::NewFixtures row = new_heads(folder.write("one.qxf", testing::qxf_head("Robe", "One", {{"long", 4}})));
  fixtures::FixtureType broken = *row.type;
  broken.modes[0].channels[0].geometry = 99;
  broken.modes[0].geometries.clear();
  bool fails = true;
  desk.let_edit(edit.scene->file().rig(), [&]() -> Status {
    if (fails && desk.edited().types.size() > 2) return fail(ErrorCode::kBadInput, "not this one");
    FL_TRY(edit.scene->remake(desk.state().ids));
    desk.show(edit.scene->scene()->rig, edit.scene->scene()->compiled);
    return {};
  });
  CHECK(!desk.add(row));
  CHECK(desk.edited().types.size() == 2);
  check_consistent(desk);
  fails = false;
  CHECK(desk.add(row));
  check_consistent(desk);
}

TEST_CASE("the options of the scene act on types that are added, and VRSL's rigs take them") {
  const testing::TempFolder folder;
  SceneFiles files;
  files.smooth = "0.25";
  auto scene = testing::taken(EditedScene::make(
      RigFile::made(fixtures::as_imported(parsed_rig(kUiRig), "toml"), "not_written.toml"), files, 1.5, false));
  const auto row = new_heads(folder.write("one.qxf", testing::qxf_head("Robe", "One", {{"long", 4}})));
  testing::taken(fixtures::add_fixtures(scene->file().rig(), row)).apply(scene->file().rig());
  REQUIRE(scene->remake());
  REQUIRE(scene->scene()->rig.types.size() == 3);
  REQUIRE(scene->scene()->rig.types[2].smoothing.size() == 1);
  CHECK(scene->scene()->rig.types[2].smoothing[0].tau_s == 0.25);
  CHECK(scene->file().rig().types[2].smoothing.empty());

  EditDesk vrsl(
      parsed_rig("[rig]\nname = \"Club\"\n[vrsl]\n[[fixture]]\nname = \"Spot\"\ntype = \"vrsl/spot\"\n"
                 "universe = 1\naddress = 1\nposition = [0, 0, 5]\n"));
  CHECK(vrsl.desk.add(row));
  CHECK(vrsl.desk.add(new_heads("vrsl/wash")));
  check_consistent(vrsl.desk);
  while (!vrsl.desk.undo().empty()) check_consistent(vrsl.desk);
}

TEST_CASE("an edit that is undone before there is a picture of it leaves the picture the scene that it shows") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  edit.shown = edit.scene->scene();
  CHECK(!desk.edited_last());
  desk.select(1, false);
  CHECK(!desk.edited_last());
  REQUIRE(desk.clone_selected({1, {0, 0, 1}}));
  CHECK(desk.edited_last());
  CHECK(edit.scene->scene() != edit.shown);
  CHECK(!desk.undo().empty());
  CHECK(edit.scene->scene() == edit.shown);
  CHECK(&desk.rig() == &edit.shown->rig);
  check_consistent(desk);
  CHECK(!desk.redo().empty());
  CHECK(edit.scene->scene() != edit.shown);
  CHECK(desk.rig().fixtures.size() == edit.shown->rig.fixtures.size() + 1);
  check_consistent(desk);
  // An edit that adds a type and is undone: the next one has the types of its own.
  const testing::TempFolder folder;
  edit.shown = edit.scene->scene();
  REQUIRE(desk.add(new_heads(folder.write("one.qxf", testing::qxf_head("Robe", "One", {{"long", 4}})))));
  CHECK(!desk.undo().empty());
  CHECK(edit.scene->scene() == edit.shown);
  REQUIRE(desk.add(new_heads(folder.write("two.qxf", testing::qxf_head("Robe", "Two", {{"long", 4}})))));
  check_consistent(desk);
  CHECK(edit.scene->scene()->rig.types.back().name == desk.edited().types.back().name);
}

TEST_CASE("copies are selected, and what is deleted takes its values with it") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  const std::vector<std::uint8_t> levels(desk.compiled().universes.size() * kSlotCountMax);
  desk.take({0, 2}, 200, levels);
  desk.take({2, 2}, 100, levels);
  desk.select(1, false);
  desk.select(2, true);
  CHECK(desk.clone_selected({1, {0, 0, 1}}));
  CHECK(desk.state().selection.fixtures == std::vector<int>{5, 6});
  CHECK(edit.fixture(5).name == "Spot 4");
  CHECK(desk.undo() == "clone 2 fixtures");
  CHECK(desk.state().selection.fixtures == std::vector<int>{1, 2});

  desk.select(0, false);
  CHECK(desk.edit(fixtures::delete_fixtures(desk.edited(), desk.selected())));
  CHECK(desk.state().selection.fixtures.empty());
  CHECK(desk.state().taken.size() == 1);
  CHECK(desk.state().taken.at({1, 2}) == 100);
  CHECK(desk.undo() == "delete Spot 1");
  CHECK(desk.state().taken.at({2, 2}) == 100);
  CHECK(desk.state().taken.at({0, 2}) == 200);
}

TEST_CASE("faders and the chosen fixture follow their fixtures over deletions, copies and undo") {
  EditDesk edit(parsed_rig(kUiRig), true);
  UiDesk& desk = edit.desk;
  const SharedScene before = edit.scene->scene();
  HandLevels hand(before->rig, before->compiled);
  const auto attribute = hand.faders(2)[0].attribute;
  const double usual = hand.faders(2)[0].value;
  hand.set(2, attribute, usual == 0.25 ? 0.5 : 0.25);
  const double own = hand.faders(2)[0].value;
  desk.select(1, false);
  REQUIRE(desk.edit(fixtures::delete_fixtures(desk.edited(), desk.selected())));
  desk.select(0, false);
  REQUIRE(desk.clone_selected({1, {0, 1, 0}}));  // as many fixtures as before
  const SharedScene after = edit.scene->scene();
  CHECK(fixture_moves(*before, *after) == std::vector{0, -1, 1, 2, 3});
  const auto moved = moved_hand(hand, *before, *after);
  CHECK(moved->faders(1)[0].value == own);
  CHECK(moved->faders(2)[0].value != own);
  while (!desk.undo().empty()) continue;
  CHECK(fixture_moves(*before, *edit.scene->scene()) == std::vector{0, 1, 2, 3, 4});
  CHECK(fixture_moves(*after, *edit.scene->scene()) == std::vector{0, 2, 3, 4, -1});
  while (!desk.redo().empty()) continue;
  CHECK(fixture_moves(*after, *edit.scene->scene()) == std::vector{0, 1, 2, 3, 4});
}

TEST_CASE("undo names the channel of a VRSL fixture that was shown") {
  EditDesk edit(parsed_rig(R"([rig]
name = "Club"
[vrsl]
[[fixture]]
name = "Mover"
type = "vrsl/spot"
mode = "13 channels"
universe = 1
address = 1
position = [0, 0, 5]
)"));
  UiDesk& desk = edit.desk;
  const auto& shown = fixtures::mode_of(desk.rig(), desk.rig().fixtures[0]).channels;
  const auto& written = fixtures::mode_of(desk.edited(), desk.edited().fixtures[0]).channels;
  int channel = 0;
  while (static_cast<std::size_t>(channel) < std::min(shown.size(), written.size()) &&
         (name_of(shown[static_cast<std::size_t>(channel)]) == name_of(written[static_cast<std::size_t>(channel)]) ||
          !desk.index().place({0, channel}))) {
    ++channel;
  }
  REQUIRE(static_cast<std::size_t>(channel) < shown.size());
  const std::vector<std::uint8_t> levels(desk.compiled().universes.size() * kSlotCountMax);
  desk.take({0, channel}, 1, levels);
  CHECK(desk.undo() == "set " + name_of(shown[static_cast<std::size_t>(channel)]) + " of Mover");
}

TEST_CASE("edits of cameras and haze make no new scene, count as unsaved, and are undone") {
  EditDesk one(parsed_rig(kUiRig));
  UiDesk& desk = one.desk;
  const auto scene = one.scene->scene();
  fixtures::Camera view;
  view.position_m = {3, -9, 4};
  desk.begin_gesture();
  REQUIRE(desk.edit(fixtures::add_camera(desk.edited(), desk.cameras(), view)));
  REQUIRE(desk.cameras().size() == 2);
  CHECK(desk.cameras()[1].position_m == view.position_m);
  const double haze_per_m = desk.edited().haze.scattering_per_m;
  desk.begin_gesture();
  REQUIRE(desk.edit(fixtures::set_haze(desk.edited(), 0.1)));
  REQUIRE(desk.edit(fixtures::set_haze(desk.edited(), 0.2)));
  CHECK(desk.state().revision != 0);
  CHECK(one.scene->scene() == scene);
  CHECK(desk.undo() == "set the haze to 0.2000 /m");
  CHECK(desk.edited().haze.scattering_per_m == haze_per_m);
  CHECK(desk.undo() == "store the camera view 1");
  CHECK(desk.cameras().size() == 1);
  CHECK(desk.state().revision == 0);
  CHECK(one.scene->scene() == scene);
  CHECK(desk.redo() == "store the camera view 1");
  CHECK(desk.cameras().size() == 2);
  REQUIRE(desk.edit(fixtures::move_fixtures(desk.edited(), std::vector<int>{0}, {1, 0, 0})));
  CHECK(one.scene->scene() != scene);
  CHECK(desk.cameras().size() == 2);
}

TEST_CASE("a refused edit changes nothing and says why") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  desk.select(0, false);
  const std::size_t before = desk.history().size();
  const Status refused = desk.edit(fixtures::patch_fixtures(desk.edited(), desk.selected(), {1, 511}));
  REQUIRE(!refused);
  CHECK(contains(refused.error().message, "choose an address of at most 499"));
  CHECK(desk.history().size() == before);
  CHECK(desk.state().revision == 0);
  CHECK(desk.edit(fixtures::patch_fixtures(desk.edited(), desk.selected(), {1, 1})));  // where it is already
  CHECK(desk.history().size() == before);

  const auto rig = footlight::testing::compiled_rig(parsed_rig(kUiRig));
  UiDesk fixed(rig.rig, rig.compiled);
  CHECK(!fixed.can_edit());
  fixed.select(0, false);
  CHECK(!fixed.edit(fixtures::delete_fixtures(fixed.edited(), fixed.selected())));
}

TEST_CASE("an edit whose rig cannot be made is taken back as a whole") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  bool fails = false;
  desk.let_edit(edit.scene->file().rig(), [&]() -> Status {
    if (fails) return fail(ErrorCode::kBadInput, "not this one");
    FL_TRY(edit.scene->remake());
    desk.show(edit.scene->scene()->rig, edit.scene->scene()->compiled);
    return {};
  });
  desk.select(0, false);
  const Snapshot before = snapshot(desk);
  desk.begin_gesture();
  CHECK(desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), {1, 0, 0})));
  fails = true;
  const Status refused = desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), {1, 0, 0}));
  REQUIRE(!refused);
  CHECK(refused.error().message == "not this one");
  CHECK(same(snapshot(desk), before));
  CHECK(desk.history().next_redo() == nullptr);
}

TEST_CASE("a drag is one step, and undone to what was saved the rig counts as saved") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  desk.select(0, false);
  desk.begin_gesture();
  for (int i = 0; i < 10; ++i) {
    CHECK(desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), {0.1, 0, 0})));
  }
  desk.begin_gesture();
  CHECK(desk.history().size() == 2);
  CHECK(fixtures::position_of(edit.fixture(0)).x == doctest::Approx(-2));
  const std::uint64_t saved = desk.state().revision;
  CHECK(saved != 0);
  CHECK(desk.edit(fixtures::unpatch_fixtures(desk.edited(), desk.selected())));
  CHECK(desk.state().revision != saved);
  CHECK(desk.undo() == "unpatch Spot 1");
  CHECK(desk.state().revision == saved);
  CHECK(contains(desk.undo(), "move Spot 1 by"));
  CHECK(fixtures::position_of(edit.fixture(0)).x == -3);
  CHECK(desk.state().revision == 0);
}

TEST_CASE("fixtures that share slots are shown with both on them, and the rig itself is not marked") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  desk.select(3, false);
  CHECK(desk.edit(fixtures::patch_fixtures(desk.edited(), desk.selected(), {1, 3})));
  const auto shown = fixtures::patch_conflicts(desk.rig());
  REQUIRE(shown.size() == 2);
  CHECK(shown[1].fixture == 3);
  CHECK(shown[1].other == 0);
  CHECK(desk.index().uses(0, 2).size() == 2);
  CHECK(desk.rig().fixtures[3].shares_address);
  CHECK(!edit.fixture(3).shares_address);
  CHECK(fixtures::patch_conflicts(desk.edited()).size() == 2);
  desk.undo();
  CHECK(!desk.rig().fixtures[3].shares_address);
}

TEST_CASE("faders reach fixtures without an address, which stay without one in the rig") {
  EditDesk edit(parsed_rig(kUiRig), true);
  UiDesk& desk = edit.desk;
  desk.select(1, false);
  CHECK(desk.edit(fixtures::unpatch_fixtures(desk.edited(), desk.selected())));
  CHECK(edit.patch(1) == "-");
  CHECK(desk.rig().fixtures[1].patched);
  CHECK(HandLevels(desk.rig(), desk.compiled()).fixture_count() == 5);
}

TEST_CASE("a scene that a frame was made from stays as it is, and universes stay for the inputs") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  const SharedScene framed = edit.scene->scene();
  const glm::dvec3 before = framed->rig.fixtures[0].position_m;
  desk.select_all();
  for (int i = 0; i < 5; ++i) {
    CHECK(desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), {0, 0, 1})));
    CHECK(edit.scene->scene() != framed);
    CHECK(framed->rig.fixtures[0].position_m == before);
    CHECK(edit.scene->scene()->rig.fixtures[0].position_m.z == before.z + i + 1);
  }
  desk.select(4, false);
  CHECK(desk.edit(fixtures::delete_fixtures(desk.edited(), desk.selected())));
  CHECK(desk.compiled().universes == framed->compiled.universes);
  desk.select_all();
  CHECK(desk.edit(fixtures::delete_fixtures(desk.edited(), desk.selected())));
  CHECK(desk.compiled().universes == framed->compiled.universes);
  CHECK(desk.rig().fixtures.empty());
}

TEST_CASE("a rig with VRSL's decoding is edited, too") {
  EditDesk edit(parsed_rig(R"([rig]
name = "Club"
[vrsl]
grid = "horizontal"
[[fixture]]
name = "Spot {}"
type = "vrsl/spot"
universe = 1
address = 1
count = 2
position = [0, 0, 5]
position_step = [1, 0, 0]
)"));
  UiDesk& desk = edit.desk;
  REQUIRE(edit.scene->scene()->written);
  desk.select(1, false);
  CHECK(desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), {0, 2, 0})));
  CHECK(desk.rig().fixtures[1].position_m == glm::dvec3(1, 2, 5));
  CHECK(edit.scene->scene()->written->fixtures[1].position_m == glm::dvec3(1, 2, 5));
  CHECK(desk.clone_selected({1, {1, 0, 0}}));
  check_consistent(desk);
}

TEST_CASE("a locked desk refuses edits and levels with the way to unlock it, and takes cameras and selections") {
  EditDesk edit(parsed_rig(kUiRig));
  UiDesk& desk = edit.desk;
  const std::vector<std::uint8_t> levels(desk.compiled().universes.size() * kSlotCountMax);
  desk.select(1, false);
  desk.begin_gesture();
  desk.take({1, 0}, 200, levels);
  const std::uint64_t revision = desk.state().revision;
  const auto taken = desk.state().taken;
  const std::size_t steps = desk.history().size();
  desk.set_locked(true);
  desk.begin_gesture();
  const Status moved = desk.edit(fixtures::move_fixtures(desk.edited(), desk.selected(), {0, 0, 1}));
  REQUIRE(!moved);
  CHECK(moved.error().message == locked_words());
  CHECK(locked_words().find("Ctrl+Shift+L unlocks") != std::string::npos);
  CHECK(!desk.clone_selected({1, {0, 1, 0}}));
  desk.take({1, 1}, 100, levels);
  CHECK(desk.take_news() == locked_words());
  desk.take({1, 1}, 101, levels);
  CHECK(desk.take_news().empty());  // a drag says it once
  desk.begin_gesture();
  desk.release_all();
  CHECK(desk.take_news() == locked_words());
  desk.set_highlight(true);
  desk.set_locate(true);
  CHECK(!desk.overlays() == taken.empty());
  CHECK(!desk.highlights());
  CHECK(!desk.locates());
  CHECK(desk.undo() == locked_words());
  CHECK(desk.state().taken == taken);
  CHECK(desk.state().revision == revision);
  CHECK(desk.history().size() == steps);

  desk.select(0, false);
  CHECK(desk.selected().front() == 0);
  desk.jump_camera(OrbitCamera(fixtures::Camera{}), 7.0f);
  CHECK(desk.history().size() == steps + 2);
  CHECK(desk.undo() != locked_words());  // the camera
  CHECK(desk.add_marker(kNsPerS));
  desk.set_locked(false);
  desk.set_highlight(true);
  CHECK(desk.highlights());
  desk.set_locked(true);
  desk.begin_gesture();
  desk.select(2, false);  // would light another one
  CHECK(desk.selected().front() == 0);
  CHECK(desk.take_news() == locked_words());
}

}  // namespace
}  // namespace footlight::tools

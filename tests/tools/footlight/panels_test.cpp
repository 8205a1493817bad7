// The panels of the window without a window: Dear ImGui makes the lists that a GPU would draw.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/draw_universe_maps.h"
#include "tools/footlight/preview/ui/escape.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/stage_marks.h"

namespace footlight::tools {
namespace {

using footlight::testing::compiled_rig;
using footlight::testing::kUiRig;
using footlight::testing::many_fixtures;
using footlight::testing::parsed_rig;
using footlight::testing::UiRig;

constexpr std::size_t kKeys = 0;
constexpr std::size_t kUniverses = 1;
constexpr std::size_t kFixtures = 2;
constexpr std::size_t kInspector = 3;
constexpr std::size_t kTimeline = 4;

// A user interface of one size with a mouse.
class HeadlessUi final : public testing::DrawnUi {
 public:
  explicit HeadlessUi(const UiRig& rig, float width = 1280, float height = 720)
      : imgui(width, height), desk(rig.rig, rig.compiled), levels(rig.compiled.universes.size() * kSlotCountMax) {}

  // Returns the number of vertices that it draws.
  int frame() {
    DrawnUi::frame();
    return ImGui::GetDrawData()->TotalVtxCount;
  }
  void show(std::size_t panel) {
    open.set_open(panel, true, desk);
    for (int i = 0; i < 3; ++i) frame();  // sizes settle
  }
  void click(float x, float y) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {x, y};
    frame();
    desk.begin_gesture();
    io.MouseDown[0] = true;
    frame();
    io.MouseDown[0] = false;
    frame();
  }
  // Clicks down a line until `done`; the place, or a negative one.
  template <class Done>
  ImVec2 click_down(float x, float from_y, float to_y, Done done) {
    for (float y = from_y; y < to_y; y += 5) {
      click(x, y);
      if (done()) return {x, y};
    }
    return {-1, -1};
  }

  testing::HeadlessImGui imgui;
  Transport* transport = nullptr;
  const LightCurve* curve = nullptr;
  const LightCurve* selected_curve = nullptr;
  const Thumbnails* thumbnails = nullptr;
  UiDesk desk;
  UiPanels open;
  std::vector<std::uint8_t> levels;
  TimeNs now_ns = kNsPerS;

 private:
  void draw() override {
    now_ns += kNsPerS / 60;
    UiInput input;
    input.levels = levels;
    input.now_ns = now_ns;
    input.transport = transport;
    input.curve = curve;
    input.selected_curve = selected_curve;
    input.thumbnails = thumbnails;
    open.draw(desk, input, ImGui::GetIO().DisplaySize.x, ImGui::GetIO().DisplaySize.y);
  }
};

TEST_CASE("closed panels draw nothing and are not there") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  CHECK(!ui.open.any_open());
  CHECK(ui.frame() == 0);
  ui.show(kUniverses);
  CHECK(ui.frame() > 2 * kSlotCountMax);
  ui.open.set_open(kUniverses, false, ui.desk);
  CHECK(ui.frame() == 0);
}

TEST_CASE("every panel survives an empty rig, modes without channels, no levels and 10,000 fixtures, in any size") {
  fixtures::Rig none = parsed_rig(kUiRig);
  none.fixtures.clear();
  fixtures::Rig bare = parsed_rig(kUiRig);
  for (fixtures::FixtureType& type : bare.types) {
    for (fixtures::Mode& mode : type.modes) {
      mode.channels.clear();
      mode.relations.clear();
    }
  }
  std::vector<UiRig> rigs;
  rigs.push_back(compiled_rig(std::move(none)));
  rigs.push_back(compiled_rig(std::move(bare)));
  rigs.push_back(compiled_rig(parsed_rig(kUiRig)));
  rigs.push_back(many_fixtures(10'000));
  for (const UiRig& rig : rigs) {
    for (const ImVec2 size : {ImVec2(640, 400), ImVec2(1920, 1080), ImVec2(1, 1)}) {
      HeadlessUi ui(rig, size.x, size.y);
      for (std::size_t i = 0; i < panels().size(); ++i) ui.show(i);
      CHECK(ui.frame() > 0);
      ui.desk.select_all();
      ui.desk.set_highlight(true);
      ui.frame();
      if (!rig.rig.fixtures.empty() && ui.desk.index().channel_count(0) > 0) ui.desk.take({0, 0}, 3, ui.levels);
      ui.open.step(ui.levels, kNsPerMs, true);
      ui.open.restart();
      ui.levels.clear();
      ui.frame();
    }
  }
}

TEST_CASE("a slot of the grid says which fixture it belongs to and selects it") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.show(kUniverses);
  // In the middle of the third row are slots 65 and up: nobody's. The first row belongs to the spots.
  const ImVec2 at = ui.click_down(300, 250, 700, [&] { return ui.desk.state().selection.lead >= 0; });
  CHECK(at.y > 0);
  CHECK(ui.desk.state().selection.lead < 3);
}

TEST_CASE("a slot of the grid says which pixel of which display it belongs to") {
  const auto rig =
      compiled_rig(parsed_rig("[rig]\nname = \"r\"\n[[display]]\nname = \"Wall\"\nposition = [0, 0, 0]\nwidth_m = 1\n"
                              "height_m = 1\ncolumns = 10\nrows = 10\nuniverse = 1\n"));
  HeadlessUi ui(rig);
  ui.show(kUniverses);
  std::string words;
  ui.click_down(300, 100, 700, [&] {
    words = ui.words();
    return words.find("Wall: column") != std::string::npos;
  });
  CHECK_MESSAGE(words.find("Wall: column") != std::string::npos, words);
}

// Two profiles in each of so many universes.
UiRig many_universes(int count) {
  fixtures::Rig rig = parsed_rig(kUiRig);
  const fixtures::PatchedFixture first = rig.fixtures[0];
  rig.fixtures.clear();
  for (int i = 0; i < 2 * count; ++i) {
    fixtures::PatchedFixture one = first;
    one.name = fmt::format("Spot {}", i + 1);
    one.universe = 1 + i / 2;
    one.address = 1 + i % 2 * 100;
    rig.fixtures.push_back(std::move(one));
  }
  return compiled_rig(std::move(rig));
}

TEST_CASE("nine universes are shown at once by pages, and a click shows one of them alone") {
  const auto rig = many_universes(11);
  HeadlessUi ui(rig);
  ui.show(kUniverses);
  // The panel is at the lower left corner; its first line has the box.
  const auto has = [&](std::string_view part) {
    ImGui::GetIO().MousePos = {1000, 100};  // words behind a tip are not in the log
    return ui.words().find(part) != std::string::npos;
  };
  REQUIRE(has("{ universe 1 }"));
  CHECK(!has("universe 9: "));
  const ImVec2 box = [&] {
    for (float y = 410; y < 450; y += 8) {
      for (float x = 560; x > 430; x -= 10) {
        ui.click(x, y);
        if (has("[x] nine at once")) return ImVec2(x, y);
      }
    }
    return ImVec2(-1, -1);
  }();
  REQUIRE(box.x > 0);
  CHECK(has("universe 1: 0 not 0"));
  CHECK(has("universe 9: "));
  CHECK(!has("universe 10: "));
  ui.levels[4 * kSlotCountMax] = 9;
  CHECK(has("universe 5: 1 not 0"));
  // In the middle of the fifth map.
  ui.click(8 + 830 / 2, 585);
  CHECK(has("{ universe 5 }"));
  CHECK(!has("universe 9: "));
  ui.click(box.x, box.y);
  CHECK(has("universe 9: "));
  // The second page has the others.
  for (float x = 150; x < 200 && !has("universe 11: "); x += 8) ui.click(x, box.y);
  CHECK(has("universe 11: 0 not 0"));
  CHECK(!has("universe 9: "));
}

// Maps alone, of whichever desk.
class MapsUi final : public testing::DrawnUi {
 public:
  UiDesk* desk = nullptr;
  std::vector<std::uint8_t> levels;
  bool frozen = false;

 private:
  void draw() override {
    UiInput input;
    input.levels = levels;
    input.now_ns = now_ns_ += kNsPerS;
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({1200, 700});
    if (ImGui::Begin("maps")) (void)maps_.draw(*desk, input, frozen, {});
    ImGui::End();
  }
  testing::HeadlessImGui imgui_{1280, 720};
  UniverseMaps maps_;
  TimeNs now_ns_ = 0;
};

TEST_CASE("frozen maps stay, until an edit changes the universes of their page") {
  const auto many = many_universes(11);
  const auto few = many_universes(2);
  fixtures::Rig bare = parsed_rig(kUiRig);
  bare.fixtures.clear();
  const auto none = compiled_rig(std::move(bare));
  UiDesk before(many.rig, many.compiled);
  UiDesk after(few.rig, few.compiled);
  UiDesk empty(none.rig, none.compiled);
  MapsUi ui;
  ui.desk = &before;
  ui.levels.assign(11 * kSlotCountMax, 0);
  ui.frame();
  ui.frozen = true;
  ui.levels[0] = 9;
  CHECK(ui.words().find("universe 1: 0 not 0") != std::string::npos);
  ui.desk = &after;
  const std::string words = ui.words();
  CHECK(words.find("universe 1: 1 not 0") != std::string::npos);
  CHECK(words.find("universe 2: 0 not 0") != std::string::npos);
  CHECK(words.find("universe 3: ") == std::string::npos);
  ui.desk = &empty;
  CHECK(ui.words().find("universe 1: ") == std::string::npos);
}

TEST_CASE("levels are drawn as bars, until the grid is frozen") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.show(kUniverses);
  // Vertices with all levels down, and with all up.
  const auto drawn = [&] {
    std::array<int, 2> vertices{};
    for (std::size_t i = 0; i < 2; ++i) {
      std::fill(ui.levels.begin(), ui.levels.end(), static_cast<std::uint8_t>(200 * i));
      for (int frame = 0; frame < 2; ++frame) vertices[i] = ui.frame();
      ui.now_ns += 2 * kNsPerS;  // no change is recent
      vertices[i] = ui.frame();
    }
    return vertices;
  };
  const auto live = drawn();
  CHECK(live[1] > live[0] + kSlotCountMax * 4);
  // The box to tick is in the first line, behind the universe.
  bool frozen = false;
  for (float y = 410; y < 450 && !frozen; y += 8) {
    for (float x = 300; x > 180 && !frozen; x -= 10) {
      ui.click(x, y);
      const auto now = drawn();
      frozen = now[0] == now[1];
    }
  }
  CHECK(frozen);
}

TEST_CASE("Ctrl+A selects what the filter of the open patch lists, and all fixtures once the patch is closed") {
  auto some = parsed_rig(kUiRig);
  some.fixtures[1].patched = false;
  const auto rig = compiled_rig(std::move(some));
  HeadlessUi ui(rig);
  ui.show(kFixtures);
  const auto& selection = ui.desk.state().selection;
  ui.desk.select_all();
  CHECK(selection.fixtures.size() == rig.rig.fixtures.size());
  bool filtered = false;
  for (float y = 30; y < 700 && !filtered; y += 8) {  // the box of those without an address
    for (float x = 200; x < 1000 && !filtered; x += 12) {
      ui.click(x, y);
      ui.frame();
      filtered = ui.desk.lists_some();
    }
  }
  REQUIRE(filtered);
  ui.desk.select_all();
  CHECK(selection.fixtures == std::vector<int>{1});
  CHECK(selection.lead == 1);
  ui.open.set_open(kFixtures, false, ui.desk);
  ui.frame();
  ui.desk.select_all();
  CHECK(selection.fixtures.size() == rig.rig.fixtures.size());
}

TEST_CASE("rows of the patch select: a click one, Ctrl another one, Shift all between") {
  const auto rig = many_fixtures(200);
  HeadlessUi ui(rig);
  ui.show(kFixtures);
  const auto& selection = ui.desk.state().selection;
  // The clicks before meet the head of the names and sort by them: Spot 2 comes before Spot 10.
  const ImVec2 first = ui.click_down(100, 20, 300, [&] { return selection.lead >= 0; });
  REQUIRE(first.y > 0);
  CHECK(selection.fixtures == std::vector<int>{0});
  const ImVec2 second = ui.click_down(100, first.y, 300, [&] { return selection.lead == 3; });
  REQUIRE(second.y > first.y);
  ImGui::GetIO().KeyCtrl = true;
  ui.click(first.x, first.y);
  CHECK(selection.fixtures == std::vector<int>{0, 3});
  ImGui::GetIO().KeyCtrl = false;
  ImGui::GetIO().KeyShift = true;
  ui.click(second.x, second.y);
  CHECK(selection.fixtures == std::vector<int>{0, 1, 2, 3});
}

TEST_CASE("a slider of the inspector takes its channel over") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.desk.select(0, false);
  ui.show(kInspector);
  // A click into a slider sets it to where the mouse is. The second column begins behind a quarter of the panel.
  const ImVec2 at = ui.click_down(1280 - 8 - 440 + 200, 60, 500, [&] { return !ui.desk.state().taken.empty(); });
  REQUIRE(at.y > 0);
  CHECK(ui.desk.state().taken.begin()->first.fixture == 0);
  CHECK(ui.desk.undo().starts_with("set "));
  CHECK(ui.desk.state().taken.empty());
}

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST_CASE("the inspector has simulated values before the first step, as in a log that is paused") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  std::fill(ui.levels.begin(), ui.levels.end(), std::uint8_t{255});
  ui.show(kInspector);
  ui.desk.select(0, false);
  CHECK(contains(ui.words(), "tilt | 135 "));
  // Another fixture, and after a seek to other levels.
  std::fill(ui.levels.begin(), ui.levels.end(), std::uint8_t{0});
  ui.desk.select(1, false);
  CHECK(contains(ui.words(), "tilt | -135 "));
  std::fill(ui.levels.begin(), ui.levels.end(), std::uint8_t{255});
  ui.open.restart();
  CHECK(contains(ui.words(), "tilt | 135 "));
}

TEST_CASE("a log that begins anew keeps the head that was chosen, and the head begins anew") {
  const auto rig = compiled_rig(parsed_rig(R"([rig]
name = "Bar"
[[fixture]]
name = "Bar"
type = "vrsl/multi-bar"
universe = 1
address = 1
position = [0, 0, 5]
)"));
  HeadlessUi ui(rig);
  ui.desk.select(0, false);
  ui.show(kInspector);
  // What is below the channels: the shown head and its values.
  const auto simulated = [&] {
    const std::string words = ui.words();
    return words.substr(words.find("head "));
  };
  REQUIRE(simulated().starts_with("head 1 }"));
  // Clicks up the panel, whose lowest control is the slider of the heads.
  for (float y = 390; y > 200 && simulated().starts_with("head 1 }"); y -= 5) ui.click(1280 - 8 - 420 + 300, y);
  const std::string dark = simulated();
  const std::string chosen = dark.substr(0, dark.find('}'));
  REQUIRE(chosen != "head 1");
  std::fill(ui.levels.begin(), ui.levels.end(), std::uint8_t{255});
  ui.open.step(ui.levels, kNsPerS, true);
  const std::string lit = simulated();
  CHECK(lit.starts_with(chosen));
  CHECK(lit != dark);
  std::fill(ui.levels.begin(), ui.levels.end(), std::uint8_t{0});
  ui.open.restart();
  CHECK(simulated() == dark);
}

TEST_CASE("a slider is dragged from one function of its channel into the next, and from slots into angles") {
  fixtures::Rig one = parsed_rig(kUiRig);
  fixtures::Mode& mode = one.types[static_cast<std::size_t>(one.fixtures[0].type)].modes[0];
  fixtures::Channel gobo = mode.channels[8];
  REQUIRE(gobo.name == "Gobo");
  // A gobo below, and above that its angle.
  fixtures::ChannelFunction slots = gobo.functions[0];
  slots.dmx_from = 0;
  slots.dmx_to = 127;
  slots.sets = {{.name = "Dots", .dmx_from = 0, .dmx_to = 127, .wheel_slot = 2}};
  fixtures::ChannelFunction turn = slots;
  turn.attribute = "Gobo1Pos";
  turn.sets.clear();
  turn.wheel = fixtures::kNoIndex;
  turn.dmx_from = 128;
  turn.dmx_to = 255;
  turn.physical_from = 0;
  turn.physical_to = 360;
  gobo.functions = {slots, turn};
  mode.channels = {gobo};
  mode.relations.clear();
  const auto rig = compiled_rig(std::move(one));
  HeadlessUi ui(rig);
  ui.desk.select(0, false);
  ui.show(kInspector);
  const auto raw = [&] {
    const auto& taken = ui.desk.state().taken;
    return taken.empty() ? -1 : static_cast<int>(taken.begin()->second);
  };
  // As the window does: the fixtures get what was taken over.
  const auto move = [&](float x, float y) {
    ImGui::GetIO().MousePos = {x, y};
    for (int i = 0; i < 2; ++i) {
      ui.frame();
      ui.desk.overlay(ui.levels);
    }
  };
  const float left = 1280 - 8 - 420 + 160;
  const ImVec2 at = ui.click_down(left, 60, 300, [&] { return raw() >= 0; });
  REQUIRE(at.y > 0);
  ui.desk.undo();
  REQUIRE(raw() == -1);
  move(left, at.y);
  ui.desk.begin_gesture();
  ImGui::GetIO().MouseDown[0] = true;
  int highest = 0;
  for (float x = left; x < 1272; x += 8) {
    move(x, at.y);
    highest = std::max(highest, raw());
  }
  CHECK(highest == 255);
  for (float x = 1272; x > left - 120; x -= 8) move(x, at.y);
  CHECK(raw() == 0);
  ImGui::GetIO().MouseDown[0] = false;
  ui.frame();
  ui.desk.undo();
  CHECK(raw() == -1);
  // From an angle into slots it ends at the lowest angle: the slider of the angle has nothing else.
  std::fill(ui.levels.begin(), ui.levels.end(), std::uint8_t{200});
  move(left, at.y);
  ImGui::GetIO().MouseDown[0] = true;
  move(left, at.y);
  move(left - 120, at.y);
  CHECK(raw() == 128);
  move(1272, at.y);
  CHECK(raw() == 255);
  ImGui::GetIO().MouseDown[0] = false;
  ui.frame();
}

TEST_CASE("a slot is marked for every selected fixture that listens to it") {
  fixtures::Rig one = parsed_rig(kUiRig);
  one.fixtures[3].address = one.fixtures[1].address + 2;
  one.fixtures[3].shares_address = true;
  const auto rig = compiled_rig(std::move(one));
  HeadlessUi ui(rig);
  ui.show(kUniverses);
  const int nobody = ui.frame();
  ui.desk.select(3, false);
  CHECK(ui.frame() > nobody);
  ui.desk.select(-1, false);
  const int released = ui.frame();
  ui.desk.take({3, 0}, 0, ui.levels);
  CHECK(ui.frame() > released);
}

TEST_CASE(
    "Esc closes the open list only, then the list of keys, then flying, measuring, the selection, then the window") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.desk.select(0, false);
  ui.desk.measure().on = true;
  ui.desk.fly().set_on(true);
  ui.show(kKeys);
  // A menu with a list in it.
  bool menu = false;
  bool list = false;
  bool opens = true;
  const auto draw = [&](bool escapes) {
    bool closed = true;
    ImGui::NewFrame();
    ImGui::Begin("host");
    if (std::exchange(opens, false)) ImGui::OpenPopup("menu");
    menu = ImGui::BeginPopup("menu");
    if (menu) {
      if (!list && !escapes) ImGui::OpenPopup("list");
      list = ImGui::BeginPopup("list");
      if (list) ImGui::EndPopup();
      ImGui::EndPopup();
    }
    ImGui::End();
    if (escapes) closed = close_topmost(ui.open, ui.desk);
    ImGui::Render();
    return closed;
  };
  for (int i = 0; i < 3; ++i) draw(false);
  REQUIRE(menu);
  REQUIRE(list);
  CHECK(draw(true));
  CHECK(draw(true));
  CHECK(menu);
  CHECK(!list);
  CHECK(ui.open.is_open(kKeys));
  CHECK(draw(true));
  CHECK(!menu);
  CHECK(!ui.open.is_open(kKeys));
  CHECK(ui.desk.fly().on());
  CHECK(draw(true));
  CHECK(!ui.desk.fly().on());
  CHECK(ui.desk.measure().on);
  CHECK(draw(true));
  CHECK(!ui.desk.measure().on);
  CHECK(ui.desk.state().selection.lead == 0);
  CHECK(draw(true));
  CHECK(ui.desk.state().selection.lead == -1);
  CHECK(!draw(true));
}

TEST_CASE("the timeline has a line of its own for the selected fixtures, and says so") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  Transport transport;
  transport.duration_ns = transport.known_ns = 10 * kNsPerS;
  LightCurve curve(rig.rig, ui.desk.index());
  for (int s = 0; s < 10; ++s) curve.add(s * kNsPerS, ui.levels);
  ui.transport = &transport;
  ui.curve = &curve;
  ui.show(kTimeline);
  CHECK(ui.words().find("of the selected ones") == std::string::npos);
  const auto drawn = [&] {
    ui.frame();
    return ImGui::GetDrawData()->TotalVtxCount;
  };
  LightCurve point(rig.rig, ui.desk.index());
  point.add(0, ui.levels);
  ui.selected_curve = &point;
  ui.frame();
  const int without_line = drawn();
  ui.selected_curve = &curve;
  CHECK(drawn() > without_line + 9);  // from moment to moment
  CHECK(ui.words().find("of the selected ones") != std::string::npos);
}

TEST_CASE("a click on the timeline seeks to the time under it, and a slow seek waits for the release") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.show(kTimeline);
  CHECK(ui.words().find("No log plays") != std::string::npos);
  Transport transport;
  transport.duration_ns = transport.known_ns = 1'000 * kNsPerS;
  LightCurve curve(rig.rig, ui.desk.index());
  curve.add(0, ui.levels);
  curve.add(400 * kNsPerS, ui.levels);
  ui.transport = &transport;
  ui.curve = &curve;
  ui.show(kTimeline);
  CHECK(ui.words().find("0:00.0 of 16:40.0") != std::string::npos);
  const auto near_middle = [&] {
    return transport.seek_ns && std::abs(static_cast<double>(*transport.seek_ns) * 1e-9 - 500) < 10;
  };
  const ImVec2 place = ui.click_down(640, 550, 700, [&] { return transport.seek_ns.has_value(); });
  REQUIRE(place.x > 0);
  CHECK(near_middle());

  transport.known_ns = 100 * kNsPerS;
  transport.seek_ns.reset();
  ImGui::GetIO().MouseDown[0] = true;
  ui.frame();
  ui.frame();
  CHECK(!transport.seek_ns);
  ImGui::GetIO().MouseDown[0] = false;
  ui.frame();
  ui.frame();
  CHECK(near_middle());
  transport.repeat_from(200 * kNsPerS);
  ImGui::GetIO().MousePos = {1, 1};  // the end of a tooltip ends the log of words, too
  ui.frame();
  CHECK(ui.words().find("repeats 3:20.0 to 16:40.0") != std::string::npos);
  CHECK(ui.words().find("known up to 1:40.0") != std::string::npos);
  transport = {};  // a log without a length
  CHECK(ui.frame() > 0);
}

TEST_CASE("the timeline has a row of small pictures, a tooltip shows one, and a click on one seeks") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  Transport transport;
  transport.duration_ns = transport.known_ns = 1'000 * kNsPerS;
  ui.transport = &transport;
  ui.show(kTimeline);
  ImGui::GetIO().MousePos = {1, 1};
  ui.frame();
  const int without = ui.frame();
  Thumbnails thumbnails;
  ui.thumbnails = &thumbnails;
  CHECK(ui.frame() == without);
  constexpr int kMesh = Thumbnails::kWidth / 2 * Thumbnails::kHeight / 2;
  thumbnails.add(500 * kNsPerS, std::vector<std::uint8_t>(std::size_t{4} * Thumbnails::kWidth * Thumbnails::kHeight));
  CHECK(ui.frame() == without + kMesh);
  for (const TimeNs at_s : {0, 250, 750, 999}) {
    thumbnails.add(at_s * kNsPerS,
                   std::vector<std::uint8_t>(std::size_t{4} * Thumbnails::kWidth * Thumbnails::kHeight, 99));
  }
  CHECK(ui.frame() == without + 5 * kMesh);
  const ImVec2 place = ui.click_down(640, 550, 700, [&] { return transport.seek_ns.has_value(); });
  REQUIRE(place.x > 0);
  CHECK(std::abs(static_cast<double>(*transport.seek_ns) * 1e-9 - 500) < 10);
  ui.frame();
  CHECK(ui.words().find("picture of 8:20.0") != std::string::npos);
  CHECK(ui.frame() > without + 5 * kMesh + Thumbnails::kWidth * Thumbnails::kHeight);
}

TEST_CASE("a click on a marker goes to its time, and the right button names and deletes it") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  Transport transport;
  transport.duration_ns = transport.known_ns = 1'000 * kNsPerS;
  ui.transport = &transport;
  ui.desk.start_markers({{250 * kNsPerS, "Verse"}, {995 * kNsPerS, "End of it all"}});
  ui.show(kTimeline);
  const auto went = [&] { return transport.seek_ns == 250 * kNsPerS || transport.seek_ns == 995 * kNsPerS; };
  // The panel is 900 wide in the middle of 1280; its contents begin 12 from its edge.
  const ImVec2 verse = ui.click_down(202 + 0.25f * 876 + 20, 560, 640, went);
  REQUIRE(verse.x > 0);
  CHECK(transport.seek_ns == 250 * kNsPerS);
  // The name at the right end stands on the left of its time.
  ui.click(202 + 0.995f * 876 - 40, verse.y);
  CHECK(transport.seek_ns == 995 * kNsPerS);

  ImGuiIO& io = ImGui::GetIO();
  const auto right_click = [&] {
    io.MousePos = verse;
    ui.frame();
    io.MouseDown[1] = true;
    ui.frame();
    io.MouseDown[1] = false;
    for (int i = 0; i < 3; ++i) ui.frame();
  };
  const auto enter = [&](const char* text) {
    io.AddInputCharactersUTF8(text);
    ui.frame();
    io.KeyMap[ImGuiKey_Enter] = 1;
    io.KeysDown[1] = true;
    ui.frame();
    io.KeysDown[1] = false;
    ui.frame();
  };
  right_click();
  enter("Chorus");
  CHECK(ui.desk.state().markers[0].name == "Chorus");
  CHECK(ui.desk.undo() == "name the marker Chorus");
  CHECK(ui.desk.state().markers[0].name == "Verse");
  right_click();
  // The button is below the field.
  const ImVec2 gone =
      ui.click_down(verse.x + 20, verse.y + 20, 719, [&] { return ui.desk.state().markers.size() == 1; });
  CHECK(gone.x > 0);
  CHECK(ui.desk.state().markers[0].name == "End of it all");
}

TEST_CASE("panels are opened by their words, and a wrong word is refused with the right ones") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  UiPanels open;
  CHECK(open.open_words("universes,inspector", desk));
  CHECK(open.is_open(kUniverses));
  CHECK(open.is_open(kInspector));
  CHECK(!open.is_open(kFixtures));
  const Status wrong = check_panel_words("fixtures,nonsense");
  REQUIRE(!wrong);
  CHECK(wrong.error().message.find("nonsense") != std::string::npos);
  CHECK(wrong.error().message.find("universes") != std::string::npos);
  CHECK(check_panel_words(""));
}

TEST_CASE("the list of keys draws a line for every key") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.show(kKeys);
  CHECK(ui.frame() > static_cast<int>(key_rows().size()) * 4 * 8);
}

TEST_CASE("marks are drawn for what is selected and in the picture only") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  const StagePick pick(rig.rig);
  fixtures::Camera camera;
  const auto vertices = [&](const Selection& selection) {
    ImGui::NewFrame();
    draw_marks(rig.rig, pick, {render::view_of(camera), {1280, 720}}, selection, 1);
    ImGui::Render();
    return ImGui::GetDrawData()->TotalVtxCount;
  };
  CHECK(vertices({}) == 0);
  CHECK(vertices({{0}, 0}) > 16);
  CHECK(vertices({{0, 1}, 0}) > vertices({{0}, 0}));
  camera.target_m = camera.position_m + glm::dvec3(0, -1, 0);  // looks away
  CHECK(vertices({{0, 1}, 0}) == 0);
}

}  // namespace
}  // namespace footlight::tools

// The wheels of the inspector: what their slots look like, the shelf of their pictures, and buttons that take over.
#include <algorithm>
#include <cmath>
#include <future>
#include <string>
#include <utility>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/draw_wheels.h"
#include "tools/footlight/preview/ui/wheel_slots.h"

namespace footlight::tools {
namespace {

using footlight::testing::compiled_rig;
using footlight::testing::kUiRig;
using footlight::testing::parsed_rig;
using footlight::testing::UiRig;

// Made at once.
std::future<Result<ShelfPicture>> at_once(const std::function<Result<ShelfPicture>()>& make) {
  std::promise<Result<ShelfPicture>> done;
  done.set_value(make());
  return done.get_future();
}

Result<ShelfPicture> grey(std::uint8_t value) {
  return ShelfPicture{std::vector<std::uint8_t>(std::size_t{4} * kShelfPicturePx * kShelfPicturePx, value)};
}

TEST_CASE("the slots of a wheel have a name, a raw value and the image of their gobo") {
  const UiRig rig = compiled_rig(parsed_rig(kUiRig));
  const auto& one = rig.rig.fixtures[0];
  const auto choices = wheel_choices(fixtures::type_of(rig.rig, one), fixtures::mode_of(rig.rig, one));
  REQUIRE(choices.size() == 1);
  CHECK(choices[0].name == "Gobo");
  CHECK(choices[0].channel == 8);
  const auto& slots = choices[0].slots;
  REQUIRE(slots.size() == 9);  // open and eight gobos
  CHECK(slots[0].open);
  CHECK(!slots[0].image);
  CHECK(slots[3].number == 4);
  CHECK(slots[3].name == "star");
  REQUIRE(slots[3].image);
  CHECK(slots[3].image->name == "builtin:star");
  CHECK(slots[3].raw_from == 80);
  CHECK(slots[3].raw_to == 111);
  CHECK(slots[3].raw == 95);
  CHECK(!slots[3].coloured);
  // A par has none.
  const auto& par = rig.rig.fixtures[3];
  CHECK(wheel_choices(fixtures::type_of(rig.rig, par), fixtures::mode_of(rig.rig, par)).empty());
}

TEST_CASE("slots of a colour wheel have its colours, as bright as they can be") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  fixtures::FixtureType& type = rig.types[static_cast<std::size_t>(rig.fixtures[0].type)];
  auto& slots = type.wheels[0].slots;
  slots[1].image.clear();
  slots[1].color = {0.64, 0.33, 5};  // a dark red
  slots[2].image.clear();
  slots[2].facets.resize(3);
  const auto choices = wheel_choices(type, type.modes[0]);
  REQUIRE(choices.size() == 1);
  const auto& red = choices[0].slots[1];
  CHECK(red.coloured);
  CHECK(!red.open);
  CHECK(red.screen_rgb.x == doctest::Approx(1));
  CHECK(red.screen_rgb.y < 0.2);
  CHECK(choices[0].slots[2].facets == 3);
  CHECK(!choices[0].slots[2].coloured);
}

TEST_CASE("the picture of a gobo is a disc with its pattern, and a file that is missing is an error") {
  const auto star = gobo_picture({nullptr, "builtin:star", false});
  REQUIRE(star);
  REQUIRE(star->rgba.size() == std::size_t{4} * kShelfPicturePx * kShelfPicturePx);
  CHECK(star->rgba[3] == 0);  // beside the disc
  const std::size_t middle = std::size_t{4} * (kShelfPicturePx / 2 * kShelfPicturePx + kShelfPicturePx / 2);
  CHECK(star->rgba[middle + 3] == 255);
  CHECK(star->rgba != gobo_picture({nullptr, "builtin:bars", false})->rgba);
  CHECK(!gobo_picture({nullptr, "none.png", false}));
}

TEST_CASE("a picture is there after the frame in which it was made, and is made once") {
  PictureShelf shelf(at_once);
  int made = 0;
  const auto make = [&] {
    ++made;
    return grey(7);
  };
  CHECK(!shelf.find("a", make));  // there is no window
  shelf.step();
  CHECK(made == 0);
  shelf.area = {0.5f, 0, 1, 0.5f};
  CHECK(!shelf.find("a", make));
  CHECK(shelf.revision() == 0);
  shelf.step();  // begins
  CHECK(!shelf.find("a", make));
  shelf.step();  // takes
  CHECK(shelf.revision() == 1);
  const auto place = shelf.find("a", make);
  REQUIRE(place);
  CHECK(place->left == 0.5f);
  CHECK(place->right == 0.5f + 0.5f / PictureShelf::kSide);
  CHECK(shelf.rgba()[0] == 7);
  for (int i = 0; i < 3; ++i) shelf.step();
  CHECK(made == 1);
}

TEST_CASE("a picture that cannot be made is tried once") {
  PictureShelf shelf(at_once);
  shelf.area = {0, 0, 1, 1};
  int tried = 0;
  for (int i = 0; i < 5; ++i) {
    CHECK(!shelf.find("a", [&]() -> Result<ShelfPicture> {
      ++tried;
      return fail(ErrorCode::kBadInput, "a.png: damaged");
    }));
    shelf.step();
  }
  CHECK(tried == 1);
  CHECK(shelf.revision() == 0);
}

TEST_CASE("a full shelf gives the place of what was not shown for the longest time, never of what is shown") {
  PictureShelf shelf(at_once);
  shelf.area = {0, 0, 1, 1};
  constexpr int kAll = PictureShelf::kSide * PictureShelf::kSide;
  const auto ask = [&](int from, int to) {
    int there = 0;
    for (int i = from; i < to; ++i) {
      if (shelf.find(fmt::format("{:03}", i), [] { return grey(1); })) ++there;
    }
    shelf.step();
    return there;
  };
  for (int i = 0; i < kAll + 2; ++i) (void)ask(0, kAll);
  CHECK(ask(0, kAll) == kAll);
  int made = 0;
  for (int i = 0; i < 4; ++i) {
    CHECK(!shelf.find(fmt::format("{:03}", kAll), [&made] {
      ++made;
      return grey(1);
    }));  // one more has no place
    CHECK(ask(0, kAll) == kAll);
  }
  CHECK(made == 0);
  // Without the first one there is room.
  for (int i = 0; i < 4; ++i) (void)ask(1, kAll + 1);
  CHECK(made == 1);
  CHECK(ask(1, kAll + 1) == kAll);
  CHECK(ask(0, 1) == 0);
}

class WheelsUi final : public testing::DrawnUi {
 public:
  WheelsUi()
      : imgui_(600, 400),
        rig_(compiled_rig(parsed_rig(kUiRig))),
        desk(rig_.rig, rig_.compiled),
        levels(rig_.compiled.universes.size() * kSlotCountMax),
        shelf(at_once) {
    shelf.area = {0, 0, 1, 1};
  }

 private:
  void draw() override {
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({600, height});
    ImGui::SetNextItemOpen(true);
    UiInput input;
    input.levels = levels;
    input.pictures = &shelf;
    if (ImGui::Begin("wheels")) {
      ImGui::SetNextItemOpen(true);
      wheels_.draw(desk, input, 0);
    }
    ImGui::End();
    shelf.step();
  }

  testing::HeadlessImGui imgui_;
  UiRig rig_;
  InspectorWheels wheels_;

 public:
  UiDesk desk;
  std::vector<std::uint8_t> levels;
  PictureShelf shelf;
  float height = 400;
};

TEST_CASE("slots that are scrolled away ask for no pictures") {
  WheelsUi ui;
  ui.height = 40;
  for (int i = 0; i < 5; ++i) ui.frame();
  CHECK(ui.shelf.revision() == 0);
  ui.height = 400;
  for (int i = 0; i < 5; ++i) ui.frame();
  CHECK(ui.shelf.revision() > 0);
}

TEST_CASE("a click on a slot takes its channel over for all selected fixtures") {
  WheelsUi ui;
  ui.desk.select(0, false);
  ui.desk.select(1, true);
  for (int i = 0; i < 40; ++i) ui.frame();
  CHECK(ui.shelf.revision() == 8);  // each gobo has its picture
  const auto raw = [&](int fixture) {
    const auto& taken = ui.desk.state().taken;
    const auto at = taken.find({fixture, 8});
    return at == taken.end() ? -1 : static_cast<int>(at->second);
  };
  std::vector<int> seen;
  for (float x = 10; x < 590; x += 8) {
    ui.press(x, 80);
    if (raw(0) >= 0 && (seen.empty() || seen.back() != raw(0))) seen.push_back(raw(0));
  }
  REQUIRE(seen.size() == 9);
  CHECK(seen[3] == 95);  // the star
  CHECK(raw(1) == raw(0));
}

}  // namespace
}  // namespace footlight::tools

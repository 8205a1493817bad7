// The universes panel that compares two moments.
#include <string>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/draw_compare.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {
namespace {

using testing::compiled_rig;
using testing::kUiRig;
using testing::parsed_rig;

struct CompareUi : testing::DrawnUi {
  CompareUi() : rig(compiled_rig(parsed_rig(kUiRig))), desk(rig.rig, rig.compiled) {
    levels.resize(rig.compiled.universes.size() * kSlotCountMax);
    open.set_open(1, true, desk);
    for (int i = 0; i < 3; ++i) frame();
  }
  void draw() override {
    UiInput input;
    input.levels = levels;
    input.now_ns = now_ns += kNsPerS / 60;
    input.transport = transport;
    input.status = status;
    input.stamps = stamps;
    open.draw(desk, input, 1280, 1000);
  }
  // Clicks until `done`, over a part of the window.
  template <class Done>
  bool search(float from_x, float to_x, float from_y, float to_y, Done done) {
    for (float y = from_y; y < to_y; y += 7) {
      for (float x = from_x; x < to_x; x += 12) {
        press(x, y);
        if (done()) return true;
      }
    }
    return false;
  }
  [[nodiscard]] KeptLevels kept(std::optional<TimeNs> log_ns = std::nullopt) const {
    return keep_levels(rig.compiled.universes, levels, log_ns);
  }

  testing::HeadlessImGui imgui{1280, 1000};
  testing::UiRig rig;
  UiDesk desk;
  UiPanels open;
  Transport* transport = nullptr;
  const PumpStatus* status = nullptr;
  std::vector<FrameStamp> stamps;
  std::vector<std::uint8_t> levels;
  TimeNs now_ns = kNsPerS;
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_CASE("a compared log stands in the row with name, time and offset until another moment takes its place") {
  CompareUi ui;
  KeptLevels other;
  other.moment = ui.kept().moment;
  other.moment.levels[0] = 90;
  other.log = "monday.dmxlog";
  other.when = "1:23.4";
  other.offset_ns = -1500 * kNsPerMs;
  ui.desk.comparison().a = other;
  const std::string words = ui.words();
  CHECK(has(words, "monday.dmxlog"));
  CHECK(has(words, "1:23.4"));
  CHECK(has(words, "-1.50 s"));
  CHECK(has(words, "1 slot differs"));
  CHECK(ui.desk.comparison().a->offset_ns == -1500 * kNsPerMs);
  // The levels of the other log change, and those of now do not. A frozen grid keeps the differences.
  ui.desk.comparison().a->moment.levels[0] = 0;
  ui.frame();
  CHECK(has(ui.words(), "no slot differs"));
  testing::activate("###Universes", {"###freeze"});
  ui.frame();
  ui.frame();
  ui.desk.comparison().a->moment.levels[0] = 80;
  ui.frame();
  CHECK(has(ui.words(), "no slot differs"));
  testing::activate("###Universes", {"###freeze"});
  ui.frame();
  ui.frame();
  CHECK(has(ui.words(), "1 slot differs"));
  testing::activate("###Universes", {"a", "###here"});
  ui.frame();
  ui.frame();
  CHECK(ui.desk.comparison().a->log.empty());
  CHECK(!has(ui.words(), "monday.dmxlog"));
}

TEST_CASE("universes that were made up for faders do not differ from a log, which cannot have them") {
  CompareUi ui;
  KeptLevels other;
  other.moment = only_of(ui.kept().moment, std::vector<Universe>{1});
  other.log = "monday.dmxlog";
  ui.levels[1] = 5;
  ui.levels[kSlotCountMax + 507] = 9;  // universe 2
  ui.desk.comparison().a = other;
  const std::string words = ui.words();
  CHECK_MESSAGE(has(words, "1 slot differs, 1 in universe 1"), words);
  ui.desk.comparison().b = ui.kept();
  CHECK(has(ui.words(), "1 slot differs, 1 in universe 1"));
  ui.desk.comparison().a->log.clear();  // a moment has them
  CHECK(has(ui.words(), "2 slots differ"));
}

TEST_CASE("slots that differ from a kept moment are counted and listed with fixture, parameter and both levels") {
  CompareUi ui;
  ui.levels[1] = 40;
  ui.desk.comparison().a = ui.kept();
  CHECK(has(ui.words(), "no slot differs"));
  ui.levels[1] = 55;                   // the fine byte of Spot 1's pan
  ui.levels[kSlotCountMax + 507] = 9;  // universe 2
  const std::string words = ui.words();
  CHECK_MESSAGE(has(words, "2 slots differ, 1 in universe 1"), words);
  CHECK(has(words, "1.2"));
  CHECK(has(words, "Spot 1"));
  CHECK(has(words, "Pan, byte 2 of 2"));
  CHECK(has(words, "55 (+15)"));
  CHECK(has(words, "2.508"));
  CHECK(has(words, "Far par"));
  ui.desk.comparison() = {};
  CHECK(!has(ui.words(), "55 (+15)"));
}

TEST_CASE("a moment B that was kept stays what it is, and the grid shows it") {
  CompareUi ui;
  ui.desk.comparison().a = ui.kept();
  ui.levels[0] = 100;
  ui.desk.comparison().b = ui.kept();
  ui.levels[0] = 200;
  std::string words = ui.words();
  CHECK(has(words, "100 (+100)"));
  CHECK(has(words, "level 100"));
  ui.desk.comparison().b.reset();
  words = ui.words();
  CHECK(has(words, "200 (+200)"));
  CHECK(has(words, "level 200"));
}

TEST_CASE("a frozen comparison is made anew when A is replaced or B is cleared") {
  CompareUi ui;
  CompareView view;
  const auto take = [&](bool frozen) {
    UiInput input;
    input.levels = ui.levels;
    return view.take(ui.desk, input, frozen);
  };
  const auto b = [&] { return view.difference().slots.empty() ? -1 : int{view.difference().slots.front().b}; };
  ui.desk.comparison().a = ui.kept();
  ui.levels[0] = 10;
  CHECK(!take(false));
  ui.levels[0] = 20;
  CHECK(!take(true));
  CHECK(b() == 10);  // frozen
  ui.desk.comparison().a = ui.kept();
  CHECK(take(true));
  CHECK(b() == -1);
  ui.levels[0] = 30;
  CHECK(!take(true));
  CHECK(b() == -1);
  ui.desk.comparison().b = ui.kept();
  CHECK(!take(true));
  CHECK(b() == 30);
  ui.levels[0] = 40;
  ui.desk.comparison().b.reset();
  CHECK(take(true));
  CHECK(b() == 40);
  const auto a = ui.desk.comparison().a;
  ui.desk.comparison() = {};
  CHECK(!take(true));
  CHECK(b() == -1);
  ui.desk.comparison().a = a;
  CHECK(take(true));
  CHECK(b() == 40);
}

TEST_CASE("the buttons keep this moment, end the comparison, and go to the times of a log") {
  CompareUi ui;
  Transport transport;
  transport.duration_ns = 60 * kNsPerS;
  transport.now_ns = 12 * kNsPerS;
  ui.transport = &transport;
  const float top = 1000 - 8 - 430 + 20;  // where the panel opens
  REQUIRE(ui.search(180, 560, top, top + 40, [&] { return ui.desk.comparison().a.has_value(); }));
  CHECK(ui.desk.comparison().a->when == "0:12.0");
  transport.now_ns = 25 * kNsPerS;
  ui.levels[0] = 77;
  REQUIRE(ui.search(10, 130, top + 20, top + 100, [&] { return transport.seek_ns.has_value(); }));
  CHECK(*transport.seek_ns == ui.desk.comparison().a->log_ns);
  REQUIRE(ui.search(130, 300, top + 20, top + 100, [&] { return ui.desk.comparison().b.has_value(); }));
  CHECK(ui.desk.comparison().b->log_ns == 25 * kNsPerS);
  REQUIRE(ui.search(130, 700, top + 20, top + 100, [&] { return !ui.desk.comparison().a.has_value(); }));
  CHECK(!ui.desk.comparison().b);
}

TEST_CASE("a click on a slot that differs selects its fixture and shows its universe") {
  CompareUi ui;
  ui.desk.comparison().a = ui.kept();
  ui.levels[kSlotCountMax + 507] = 9;
  ui.frame();
  REQUIRE(ui.search(20, 40, 700, 980, [&] { return ui.desk.state().selection.lead == 4; }));
  CHECK(has(ui.words(), "1 in universe 2"));
}

TEST_CASE("the comparison survives a rig whose universes are others, and a moment without levels") {
  CompareUi ui;
  ui.desk.comparison().a = KeptLevels{{{7}, std::vector<std::uint8_t>(kSlotCountMax, 3)}, "0:01.0", kNsPerS};
  CHECK(has(ui.words(), "512 slots differ, 0 in universe 1"));
  ui.desk.comparison().a = KeptLevels{};
  CHECK(has(ui.words(), "no slot differs"));
  ui.levels.clear();
  CHECK(has(ui.words(), "no slot differs"));
}

TEST_CASE("the universes panel names what is set by hand as the sender, over a log and among live inputs") {
  CompareUi ui;
  PumpStatus status;
  status.universes.resize(1);
  status.universes[0].universe = ui.rig.compiled.universes[0];
  status.universes[0].senders = {{.name = "by hand", .priority = 150, .wins = true}, {.name = "log:a", .wins = true}};
  const auto has = [&](const char* part) { return ui.words().find(part) != std::string::npos; };
  CHECK(has("faders of the window"));
  ui.status = &status;
  CHECK(has("by hand (priority 150) + log:a (priority 100)"));
  CHECK(!has("faders of the window"));
  // Live, and nothing was sent for a minute: the hand is not lost, a console is.
  ui.stamps.resize(ui.rig.compiled.universes.size());
  ui.stamps[0].revision = 1;
  ui.now_ns = 60 * kNsPerS;
  CHECK(has("last change"));
  CHECK(!has("no signal since"));
  status.universes[0].senders[0].name = "desk";
  CHECK(has("no signal since"));
}

}  // namespace
}  // namespace footlight::tools

// What the window shows while its picture waits.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/panels_test_imgui.h"
#include "tools/footlight/preview/coming_settings.h"
#include "tools/footlight/preview/ui/draw_busy.h"

namespace footlight::tools {
namespace {

struct BusyUi : testing::DrawnUi {
  void draw() override { cancels = mark.draw(busy, now_ns += kNsPerS / 60, 640, 20, 1); }
  void wait(DurationNs ns) { now_ns += ns; }

  testing::HeadlessImGui imgui{640, 400};
  BusyMark mark;
  Busy busy;
  TimeNs now_ns = kNsPerS;
  bool cancels = false;
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_CASE("what the picture waits for is shown after half a second, with its share and a button that cancels") {
  BusyUi ui;
  ui.busy = busy_with({10 * kNsPerS, 40 * kNsPerS, 130 * kNsPerS});
  CHECK(!has(ui.words(), "going to"));
  CHECK(!ui.mark.can_cancel());
  ui.wait(BusyMark::kPatienceNs);
  const std::string words = ui.words();
  CHECK(has(words, "going to 2:10.0 of the log"));
  CHECK(has(words, "25%"));
  CHECK(ui.mark.can_cancel());
  ui.frame();
  CHECK(!ui.cancels);
  testing::activate("busy", {"###cancel (Esc)"});
  ui.frame();
  CHECK(ui.cancels);
  ui.busy = {};
  CHECK(!has(ui.words(), "going to"));
  CHECK(!ui.mark.can_cancel());
}

TEST_CASE("before the first picture the stage says that shaders are compiled, and with it the words are gone") {
  const testing::HeadlessImGui imgui(904, 600);
  const auto drawn = [&](std::uint64_t pictures, DurationNs waited_ns) {
    ImGui::NewFrame();
    draw_first_wait(pictures, waited_ns, 640);
    ImRect place(1e6f, 1e6f, -1e6f, -1e6f);
    for (const ImDrawVert& vertex : ImGui::GetBackgroundDrawList()->VtxBuffer) place.Add(vertex.pos);
    ImGui::Render();
    return place;
  };
  const ImRect soon = drawn(0, 100 * kNsPerMs);
  const ImRect later = drawn(0, 8 * kNsPerS);
  for (const ImRect& place : {soon, later}) {
    CHECK(place.GetCenter().x == doctest::Approx(320).epsilon(0.02));
    CHECK(place.GetCenter().y == doctest::Approx(300).epsilon(0.02));
    CHECK(place.GetWidth() > 100);
  }
  CHECK(later.GetWidth() < soon.GetWidth());  // other words
  CHECK(drawn(1, 8 * kNsPerS).Max.x < 0);
}

TEST_CASE("what cannot be cancelled has no button, and another thing to wait for has half a second of its own") {
  BusyUi ui;
  ui.busy = {BusyWith::kEdit, "preparing the picture", std::nullopt, false};
  ui.frame();
  ui.wait(3 * kNsPerS);
  const std::string words = ui.words();
  CHECK(has(words, "preparing the picture"));
  CHECK(has(words, "3 s"));
  CHECK(!has(words, "cancel"));
  CHECK(!ui.mark.can_cancel());
  ui.busy = {BusyWith::kKnobs, "measuring this machine", 0.5, true};
  CHECK(!has(ui.words(), "measuring"));
  ui.wait(BusyMark::kPatienceNs);
  CHECK(has(ui.words(), "measuring this machine"));
  CHECK(ui.mark.can_cancel());
}

TEST_CASE("of all that the picture waits for the first that must end is shown and cancelled") {
  BusyWork work;
  CHECK(busy_of(work).with == BusyWith::kNothing);
  work.compiles = true;
  CHECK(busy_of(work).with == BusyWith::kShaders);
  CHECK(!busy_of(work).can_cancel);
  work.seeking = Transport::Seeking{0, 5 * kNsPerS, 10 * kNsPerS};
  CHECK(busy_of(work).with == BusyWith::kSeek);
  CHECK(busy_of(work).can_cancel);
  work.makes_frame = true;
  CHECK(busy_of(work).with == BusyWith::kEdit);
  work.knobs_share = 0.25;
  CHECK(busy_of(work).with == BusyWith::kKnobs);
  CHECK(busy_of(work).can_cancel);
  CHECK(busy_of(work).share == 0.25);
}

TEST_CASE("an edit whose picture is prepared can be cancelled while it is the newest command, and once") {
  BusyWork work{.makes_frame = true, .can_undo = true};
  CHECK(busy_of(work).can_cancel);
  CHECK(!has(busy_of(work).words, "Ctrl+Z"));
  work.can_undo = false;
  CHECK(!busy_of(work).can_cancel);
  CHECK(has(busy_of(work).words, "Ctrl+Z"));
  work.can_undo = work.undone = true;  // the edit before it is not what the picture waits for
  CHECK(!busy_of(work).can_cancel);
  CHECK(has(busy_of(work).words, "undone"));
}

TEST_CASE("a frame of other settings begins when all is compiled, once, and other settings meanwhile begin anew") {
  ComingSettings coming;
  std::vector<int> begun;  // heights
  bool compiled = false;
  const auto come = [&](int height) {
    render::FrameSettings settings;
    settings.height = height;
    return coming.come(
        settings, [&](const render::FrameSettings& each) { begun.push_back(each.height); }, [&] { return compiled; });
  };
  CHECK(!coming.waits());
  CHECK(!come(100));
  CHECK(!come(100));
  CHECK(coming.waits());
  CHECK(!come(200));
  compiled = true;
  CHECK(come(200));
  CHECK(begun == std::vector<int>{100, 200});
  CHECK(!coming.waits());
  compiled = false;
  CHECK(!come(100));
  coming.leave();
  CHECK(!coming.waits());
  CHECK(!come(100));
  CHECK(begun == std::vector<int>{100, 200, 100, 100});
}

TEST_CASE("the share of a seek is between nothing and all of it, also where it ends where it begins") {
  CHECK(*busy_with({kNsPerS, kNsPerS, kNsPerS}).share == 0);
  CHECK(*busy_with({0, 5 * kNsPerS, 4 * kNsPerS}).share == 1);
  CHECK(*busy_with({4 * kNsPerS, 2 * kNsPerS, 8 * kNsPerS}).share == 0);
}

}  // namespace
}  // namespace footlight::tools

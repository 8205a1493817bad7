// The panel of inputs and outputs, and the band over the picture, without a window.
#include <algorithm>
#include <string>
#include <vector>

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/live_band.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kDevices = 5;
constexpr const char* kQuestion = "###Send to real lamps?";

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

OutputsView two_outputs() {
  OutputsView view;
  view.rows.resize(2);
  view.rows[0].endpoint = "sacn:1-2";
  view.rows[0].universes = {1, 2};
  view.rows[1].id = 1;
  view.rows[1].endpoint = "enttec-pro:EN1";
  view.rows[1].universes = {1};
  return view;
}

class Ui : public testing::DrawnUi {
 public:
  explicit Ui(OutputsView* view = nullptr, float width = 1280, float height = 720, float of_scale = 1)
      : imgui(width, height),
        scale(of_scale),
        rig(testing::compiled_rig(testing::parsed_rig(testing::kUiRig))),
        desk(rig.rig, rig.compiled),
        levels(rig.compiled.universes.size() * kSlotCountMax),
        outputs(view) {
    ImGui::GetIO().FontGlobalScale = scale;
    ImGui::GetStyle().ScaleAllSizes(scale);
    open.set_open(kDevices, true, desk);
    for (int i = 0; i < 3; ++i) frame();
  }

  void draw() override {
    UiInput input;
    input.levels = levels;
    input.status = status;
    input.now_ns = now_ns += kNsPerS / 60;
    input.outputs = outputs;
    input.inputs = inputs;
    input.scale = scale;
    open.draw(desk, input, ImGui::GetIO().DisplaySize.x, ImGui::GetIO().DisplaySize.y);
  }
  static ImRect place(const char* window) {
    const ImGuiWindow* found = ImGui::FindWindowByName(window);
    REQUIRE(found != nullptr);
    return found->Rect();
  }
  static bool asks() { return ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel); }
  // Clicks over a part of a window, row after row, from below if `up`, until `done`.
  template <class Done>
  bool click_over(ImRect where, bool up, Done done) {
    for (float y = 4; y < where.GetHeight(); y += 6) {
      for (float x = where.Min.x + 16; x < where.Max.x; x += 24) {
        press(x, up ? where.Max.y - y : where.Min.y + y);
        if (done()) return true;
      }
    }
    return false;
  }
  // The panel below its title, which has a button that closes it.
  static ImRect body() {
    ImRect where = place("###Devices");
    where.Min.y += 24;
    return where;
  }

  testing::HeadlessImGui imgui;
  float scale;
  testing::UiRig rig;
  UiDesk desk;
  UiPanels open;
  std::vector<std::uint8_t> levels;
  OutputsView* outputs;
  InputsView* inputs = nullptr;
  const PumpStatus* status = nullptr;
  TimeNs now_ns = kNsPerS;

  // Presses at one place, moves to the other and lets go there.
  void drag(ImVec2 from, ImVec2 to) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = from;
    frame();
    io.MouseDown[0] = true;
    frame();
    io.MousePos = {(from.x + to.x) / 2, (from.y + to.y) / 2};
    for (int i = 0; i < 2; ++i) frame();
    io.MousePos = to;
    for (int i = 0; i < 2; ++i) frame();
    io.MouseDown[0] = false;
    for (int i = 0; i < 2; ++i) frame();
  }

};

TEST_CASE("without outputs the panel says how to add one, and what drives the rig") {
  OutputsView view;
  Ui ui(&view);
  const std::string words = ui.words();
  CHECK(has(words, "--output ENDPOINT"));
  CHECK(has(words, "No DMX interface"));
  CHECK(has(words, "faders drive the rig"));
}

TEST_CASE("inputs are listed with state, rate and age, and what is wrong with them") {
  PumpStatus status;
  status.stamp_ns = 10 * kNsPerS;
  status.ports.resize(2);
  status.ports[0].name = "sacn:1-2";
  status.ports[0].state = PortState::kWorking;
  status.ports[0].frames = 880;
  status.ports[0].rate_hz = 88;
  status.ports[0].universes = {{.universe = 1, .frames = 440, .rate_hz = 44}, {.universe = 2, .frames = 440}};
  status.ports[0].port.rejected = 3;
  status.ports[1].name = "enttec-pro:EN7";
  status.ports[1].state = PortState::kGone;
  status.ports[1].trouble = "enttec-pro:EN7: unplugged; plug it in again";
  status.universes.resize(2);
  status.universes[0].universe = 1;
  status.universes[0].newest.stamp_ns = 10 * kNsPerS - 12 * kNsPerMs;
  Ui ui;
  ui.status = &status;
  std::string words = ui.words();
  for (const char* part :
       {"sacn:1-2", "working", "880", "88.0 /s", "12 ms", "3 rejected", "EN7", "gone", "unplugged"}) {
    INFO(part);
    CHECK(has(words, part));
  }
  CHECK_FALSE(has(words, "silent"));
  // A console that has gone quiet is not working, though its port is.
  status.ports[0].universes[0].rate_hz = 0;
  status.universes[0].newest.stamp_ns = 10 * kNsPerS - 2'499 * kNsPerMs;
  CHECK_FALSE(has(ui.words(), "silent"));
  status.universes[0].newest.stamp_ns = 10 * kNsPerS - 2'500 * kNsPerMs;
  CHECK(has(ui.words(), "silent"));
  status.ports[0].name = "by hand";
  CHECK_FALSE(has(ui.words(), "silent"));
  status.ports[0].name = "sacn:1-2";
  status.ports[0].frames = 0;
  status.ports[0].universes[0].frames = status.ports[0].universes[1].frames = 0;
  words = ui.words();
  CHECK(has(words, "no frames yet"));
  CHECK_FALSE(has(words, "silent"));
  CHECK(has(words, "footlight doctor"));
}

TEST_CASE("break and latency have columns where some output knows them, and none where nobody does") {
  OutputsView view = two_outputs();
  view.rows[1].state = ArmState::kArmed;
  view.rows[1].status = PortStatus{.name = "enttec-pro:EN1", .is_sink = true, .state = PortState::kWorking};
  Ui ui(&view);
  CHECK(!has(ui.words(), "latency"));
  CHECK(!has(ui.words(), "break"));
  view.rows[1].status->latency.count = 7;
  view.rows[1].status->latency.p50_ns = 1'250 * kNsPerUs;
  CHECK(has(ui.words(), "latency"));
  CHECK(has(ui.words(), "1.25 ms"));
  CHECK(!has(ui.words(), "break"));
  view.rows[1].status->figures.push_back({"break_us", 176.4});
  CHECK(has(ui.words(), "break"));
  CHECK(has(ui.words(), "176 us"));
}

TEST_CASE("clicks anywhere in the panel arm nothing: a question comes, whose button needs a tick") {
  OutputsView view = two_outputs();
  Ui ui(&view);
  REQUIRE(ui.click_over(Ui::body(), false, [] { return Ui::asks(); }));
  CHECK(view.arm.empty());
  for (int i = 0; i < 2; ++i) ui.frame();
  const ImRect question = Ui::place(kQuestion);
  // Only over the left button, which is below the tick: it is disabled.
  ImRect button = question;
  button.Min.y = question.Max.y - 28;
  button.Max.x = question.Min.x + 40;
  ui.click_over(button, true, [&] { return !view.arm.empty(); });
  CHECK(view.arm.empty());
  REQUIRE(Ui::asks());
  ImRect left = question;
  left.Max.x = question.Min.x + 40;
  ui.click_over(left, true, [&] { return !view.arm.empty(); });  // up to the tick
  CHECK(view.arm.empty());
  CHECK(ui.click_over(button, true, [&] { return !view.arm.empty(); }));
  CHECK(view.arm == std::vector<OutputId>{0, 1});  // the first button is that of all
  ui.frame();
  CHECK(!Ui::asks());
}

TEST_CASE("with a dead man's switch the question says that lamps get levels only while its key is held") {
  for (const bool holds : {false, true}) {
    OutputsView view = two_outputs();
    view.needs_hold = holds;
    Ui ui(&view);
    REQUIRE(ui.click_over(Ui::body(), false, [] { return Ui::asks(); }));
    const std::string words = ui.words();
    CHECK(has(words, "at once") != view.needs_hold);
    CHECK(has(words, "Real lamps get zeros, and while End is held") == view.needs_hold);
  }
}

TEST_CASE("a panel that is closed takes its question along, and arms nothing when it is back") {
  OutputsView view = two_outputs();
  Ui ui(&view);
  REQUIRE(ui.click_over(Ui::body(), false, [] { return Ui::asks(); }));
  for (int i = 0; i < 2; ++i) ui.frame();
  ui.open.set_open(kDevices, false, ui.desk);
  ui.open.set_open(1, true, ui.desk);  // another panel
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(!Ui::asks());
  ui.open.set_open(1, false, ui.desk);
  ui.open.set_open(kDevices, true, ui.desk);
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(!Ui::asks());
  CHECK(ui.click_over(Ui::body(), false, [&] { return view.blackout.has_value() || Ui::asks(); }));
  CHECK(view.arm.empty());
}

TEST_CASE("armed outputs are disarmed and blacked out by one click") {
  OutputsView view = two_outputs();
  view.rows[1].state = ArmState::kArmed;
  view.rows[1].status = PortStatus{.name = "enttec-pro:EN1", .is_sink = true, .state = PortState::kWorking};
  view.rows[1].status->frames = 123;
  view.rows[1].status->rate_hz = 40;
  view.rows[0].trouble = "sacn:1-2: no route";
  view.rows[0].left_out = {2};
  Ui ui(&view);
  const std::string words = ui.words();
  for (const char* part : {"LIVE", "123", "40.0 /s", "not armed", "no route", "universe 2 is not sent"}) {
    INFO(part);
    CHECK(has(words, part));
  }
  bool disarmed = false;
  bool darkened = false;
  ui.click_over(Ui::body(), false, [&] {
    if (Ui::asks()) ImGui::ClosePopupToLevel(0, true);
    disarmed = disarmed || view.disarm == std::vector<OutputId>{1};
    darkened = darkened || view.blackout == true;
    view.disarm.clear();
    view.blackout.reset();
    return disarmed && darkened;
  });
  CHECK(disarmed);
  CHECK(darkened);
  CHECK(view.arm.empty());
  view.darkness = Darkness::kAsked;
  const std::string dark = ui.words();
  CHECK(has(dark, "end the blackout"));
  CHECK(has(dark, "zeros"));
  CHECK(!has(dark, "LIVE"));
}

TEST_CASE("interfaces that are plugged in are listed with their fix, and a click adds one for a universe of the rig") {
  OutputsView view;
  view.universes = {3, 5};
  view.devices.resize(2);
  view.devices[0] = {"enttec-pro:EN1", "ENTTEC DMX USB Pro", "ready", "", true};
  view.devices[1] = {"udmx:port-1", "uDMX", "no-permission", "not yours: sudo something", false};
  Ui ui(&view);
  CHECK(view.looks);
  const std::string words = ui.words();
  for (const char* part : {"There are none", "enttec-pro:EN1", "ready", "udmx:port-1", "sudo something", "Universes"}) {
    INFO(part);
    CHECK(has(words, part));
  }
  CHECK(ui.click_over(Ui::body(), false, [&] {
    if (Ui::asks()) ImGui::ClosePopupToLevel(0, true);  // the list of universes
    if (view.add == "mock:enttec-pro=3") view.add.reset();
    return view.add.has_value();
  }));
  CHECK(view.add == "enttec-pro:EN1=3");
  view.refusal = "enttec-pro:EN1=3: it is in the list already";
  CHECK(has(ui.words(), "in the list already"));
}

TEST_CASE("one click adds a made-up input, and another one removes it") {
  OutputsView view;
  InputsView made_up;
  Ui ui(&view);
  ui.inputs = &made_up;
  CHECK(has(ui.words(), "or made up:"));
  REQUIRE(ui.click_over(Ui::body(), false, [&] { return made_up.add.has_value(); }));
  CHECK(made_up.add == "mock:chase");
  made_up.add.reset();

  made_up.inputs = made_up.made_up = {"mock:chase"};
  const std::string words = ui.words();
  CHECK(has(words, "MADE UP: mock:chase"));
  CHECK(!has(words, "add chase"));  // it is there
  CHECK(has(words, "add sine"));
  REQUIRE(ui.click_over(Ui::body(), false, [&] { return made_up.remove.has_value(); }));
  CHECK(made_up.remove == "mock:chase");
}

TEST_CASE("a made-up input that must not be added says why, and no click adds it") {
  OutputsView view;
  InputsView made_up;
  made_up.why_not = "A log drives the rig; start the window without it to add inputs.";
  Ui ui(&view);
  ui.inputs = &made_up;
  CHECK(has(ui.words(), "A log drives the rig"));
  CHECK(!ui.click_over(Ui::body(), false, [&] { return made_up.add.has_value(); }));
}

TEST_CASE("an endpoint that is typed becomes an input, or an output, with Enter") {
  OutputsView view;
  InputsView inputs;
  Ui ui(&view);
  ui.inputs = &inputs;
  ImGuiIO& io = ImGui::GetIO();
  const auto enter = [&] {
    io.KeyMap[ImGuiKey_Enter] = 1;
    io.KeysDown[1] = true;
    ui.frame();
    io.KeysDown[1] = false;
    ui.frame();
  };
  // The fields, from above: a click into one takes the keyboard.
  const auto type_into_field = [&](ImGuiID before, const char* text) -> ImGuiID {
    ImGuiID field = 0;
    CHECK(ui.click_over(Ui::body(), false, [&] {
      inputs.add.reset();  // a button
      view.add.reset();
      field = ImGui::GetActiveID();
      return field != 0 && field != before && ImGui::GetInputTextState(field) != nullptr;
    }));
    io.AddInputCharactersUTF8(text);
    ui.frame();
    enter();
    return field;
  };
  const ImGuiID first = type_into_field(0, "sacn:2%lo");
  CHECK(view.add == "sacn:2%lo");
  CHECK(!inputs.add);
  (void)type_into_field(first, "sacn:1-2");
  CHECK(inputs.add == "sacn:1-2");
  CHECK(!view.add);
  inputs.add.reset();
  inputs.refusal = "sacn:1-2: no such thing";
  view.refusal = "sacn:2%lo: it is in the list already";
  const std::string words = ui.words();
  CHECK(has(words, "no such thing"));
  CHECK(has(words, "in the list already"));
  CHECK(inputs.add == std::nullopt);
}

TEST_CASE("a made-up interface is one click away, and is called so in its row and in the question") {
  OutputsView view;
  view.universes = {3, 5};
  InputsView made_up;
  made_up.made_up = {"mock:sine"};
  Ui ui(&view);
  REQUIRE(ui.click_over(Ui::body(), false, [&] { return view.add.has_value(); }));
  CHECK(view.add == "mock:enttec-pro=3");
  view.rows.resize(1);
  view.rows[0].endpoint = "mock:enttec-pro=3";
  view.rows[0].universes = {3};
  view.rows[0].made_up = true;
  const std::string words = ui.words();
  CHECK(has(words, "mock:enttec-pro=3 (made up)"));
  CHECK(!has(words, "add a made-up interface"));
  view.rows[0].state = ArmState::kArmed;
  CHECK(live_words(view) == "LIVE: 1 output (made up)");
  view.rows.push_back(view.rows[0]);
  view.rows[1].made_up = false;
  CHECK(live_words(view) == "LIVE: 2 outputs");
  view.rows[0].state = view.rows[1].state = ArmState::kOff;
  ui.inputs = &made_up;
  REQUIRE(ui.click_over(Ui::body(), false, [] { return Ui::asks(); }));
  for (int i = 0; i < 2; ++i) ui.frame();
  const std::string question = ui.words();
  CHECK(has(question, "no lamp gets it"));
  CHECK(has(question, "A made-up input moves them: mock:sine"));
}

TEST_CASE("a tag over the picture says what is made up, beside the one of outputs") {
  const testing::HeadlessImGui imgui(800, 600);
  InputsView made_up;
  // The place of what is drawn, or nothing.
  const auto tag = [&](float y) {
    ImGui::NewFrame();
    StageTags tags(536);
    if (y > 0) tags.draw({"LIVE", "", y, 1, 1});
    const int before = ImGui::GetForegroundDrawList()->VtxBuffer.Size;
    draw_input_tags(made_up, tags);
    ImRect place(1e6f, 1e6f, -1e6f, -1e6f);
    const auto& drawn = ImGui::GetForegroundDrawList()->VtxBuffer;
    for (int i = before; i < drawn.Size; ++i) place.Add(drawn[i].pos);
    ImGui::Render();
    return place;
  };
  CHECK(tag(0).Max.x < 0);
  CHECK(made_up_words(made_up).empty());
  made_up.inputs = made_up.made_up = {"mock:chase"};
  CHECK(made_up_words(made_up) == "MADE UP: mock:chase");
  CHECK(tag(0).Min.y == 0);
  CHECK(tag(0).GetCenter().x == doctest::Approx(268).epsilon(0.01));
  CHECK(tag(0).GetWidth() > 100);
  CHECK(tag(30).Min.y == 0);  // beside another tag
  CHECK(tag(30).GetCenter().x != doctest::Approx(268).epsilon(0.1));
  made_up.made_up.push_back("mock:sine");
  CHECK(made_up_words(made_up) == "MADE UP: 2 inputs");
}

TEST_CASE("a blackout by hand has a tag of its own with the way to end it, beside that of made-up inputs") {
  const testing::HeadlessImGui imgui(800, 600);
  InputsView inputs;
  const auto tags_end = [&] {
    ImGui::NewFrame();
    StageTags tags(536);
    draw_input_tags(inputs, tags);
    ImGui::Render();
    return tags.bottom();
  };
  CHECK(tags_end() == 0);
  inputs.inputs = inputs.made_up = {"mock:chase"};
  const float made_up = tags_end();
  inputs.dark_by_hand = true;
  CHECK(made_up_words(inputs) == "MADE UP: mock:chase");
  CHECK(hand_blackout_words(inputs) == "BLACKOUT by hand");
  CHECK(has(hand_blackout_end(), "footlight blackout off"));
  CHECK(tags_end() > 1.5f * made_up);
  OutputsView outputs = two_outputs();
  outputs.darkness = Darkness::kAsked;
  CHECK(has(blackout_words(outputs), "Shift+B ends the blackout of outputs"));  // and not the one by hand
  CHECK(!has(hand_blackout_end(), "Shift+B"));
}

TEST_CASE("no tag covers a panel or a line with buttons, wherever on the stage they are") {
  testing::HeadlessImGui imgui(1280, 720);
  OutputsView outputs = two_outputs();
  outputs.rows[0].state = ArmState::kArmed;
  outputs.darkness = Darkness::kAsked;
  InputsView inputs;
  inputs.inputs = inputs.made_up = {"mock:chase"};
  inputs.dark_by_hand = true;
  for (float left = -200; left < 1016; left += 40) {
    for (const float width : {200.0f, 560.0f}) {
      for (const bool titled : {true, false}) {
        ImRect free;
        for (int frame = 0; frame < 2; ++frame) {
          ImGui::NewFrame();
          ImGui::SetNextWindowPos({left, 8});
          ImGui::SetNextWindowSize({width, titled ? 300.0f : 34.0f});
          ImGui::Begin("one", nullptr, titled ? 0 : ImGuiWindowFlags_NoTitleBar);
          const ImGuiWindow* const window = ImGui::GetCurrentWindow();
          free = window->Rect();
          ImGui::End();
          StageTags tags(1016);
          draw_live_band(outputs, tags, 1);
          draw_input_tags(inputs, tags);
          draw_lock(tags, 1);
          ImGui::Render();
        }
        // Corners of rectangles and letters; those of the frame around the window are at its edges.
        free.Expand(-1);
        const ImRect inside(16, 16, 1264, 704);
        int covers = 0;
        for (const ImDrawVert& vertex : ImGui::GetForegroundDrawList()->VtxBuffer) {
          covers += inside.Contains(vertex.pos) && free.Contains(vertex.pos) ? 1 : 0;
        }
        INFO(left, " ", width, " ", titled);
        CHECK(covers == 0);
      }
    }
  }
}

TEST_CASE("what is set by hand is counted and released by one click, and its blackout is ended by one") {
  OutputsView view;
  InputsView inputs;
  Ui ui(&view);
  ui.inputs = &inputs;
  CHECK(!has(ui.words(), "release all"));
  inputs.by_hand = "3 slots by hand";
  CHECK(has(ui.words(), "3 slots by hand"));
  REQUIRE(ui.click_over(Ui::body(), false, [&] { return inputs.release_hand; }));
  CHECK(!inputs.end_hand_blackout);
  inputs = {};
  inputs.dark_by_hand = true;
  CHECK(has(ui.words(), "BLACKOUT by hand"));
  REQUIRE(ui.click_over(Ui::body(), false, [&] { return inputs.end_hand_blackout; }));
  CHECK(!inputs.release_hand);
}

TEST_CASE("with a made-up input the tempo is shown and tapped, and with a control the next one that moves is learnt") {
  OutputsView view;
  InputsView inputs;
  Ui ui(&view);
  ui.inputs = &inputs;
  CHECK(!has(ui.words(), "beats a minute"));
  CHECK(!has(ui.words(), "learn"));
  inputs.has_patterns = true;
  inputs.beats_a_minute = 127.5;
  CHECK(has(ui.words(), "127.5 beats a minute"));
  REQUIRE(ui.click_over(Ui::body(), false, [&] { return inputs.tap; }));
  inputs = {};
  inputs.has_controls = true;
  CHECK(has(ui.words(), "learn a control"));
  inputs.learns = true;
  CHECK(has(ui.words(), "Move one fader"));
  REQUIRE(ui.click_over(Ui::body(), false, [&] { return inputs.stop_learning; }));
}

TEST_CASE("of a locked window's requests of inputs and outputs those stay that arm, disarm and darken") {
  OutputsView outputs = two_outputs();
  outputs.arm = {0};
  outputs.disarm = {1};
  outputs.blackout = true;
  CHECK(!outputs.drop_requests());
  outputs.add = "sacn:3";
  outputs.remove = {1};
  outputs.move = OutputsView::Move{0, 2};
  CHECK(outputs.drop_requests());
  CHECK(!outputs.add);
  CHECK(!outputs.move);
  CHECK(outputs.remove.empty());
  CHECK(outputs.arm == std::vector<OutputId>{0});
  CHECK(outputs.disarm == std::vector<OutputId>{1});
  CHECK(outputs.blackout == true);
  InputsView inputs;
  inputs.end_hand_blackout = true;
  CHECK(!inputs.drop_requests());
  const auto dropped = [&](auto ask) {
    ask();
    return inputs.drop_requests() && !inputs.drop_requests();
  };
  CHECK(dropped([&] { inputs.add = "sacn:1"; }));
  CHECK(dropped([&] { inputs.remove = "sacn:1"; }));
  CHECK(dropped([&] { inputs.move = InputsView::Move{"enttec-pro=1", 2}; }));
  CHECK(dropped([&] { inputs.learn = "1.17"; }));
  CHECK(dropped([&] { inputs.release_hand = true; }));
  CHECK(dropped([&] { inputs.tap = true; }));
  CHECK(inputs.end_hand_blackout);
}

TEST_CASE("a locked window has a blue frame and a tag at the top, inside the red frame of what is live") {
  const testing::HeadlessImGui imgui(800, 600);
  ImGui::NewFrame();
  StageTags tags(536);
  draw_lock(tags, 1);
  const float below = tags.bottom();
  std::vector<bool> edges(4);
  bool tag = false;
  for (const ImDrawVert& vertex : ImGui::GetForegroundDrawList()->VtxBuffer) {
    if (vertex.col != IM_COL32(0, 114, 178, 255)) continue;
    edges[0] = edges[0] || (vertex.pos.x > 3 && vertex.pos.x < 8);
    edges[1] = edges[1] || (vertex.pos.y > 3 && vertex.pos.y < 8);
    edges[2] = edges[2] || (vertex.pos.x > 792 && vertex.pos.x < 797);
    edges[3] = edges[3] || (vertex.pos.y > 592 && vertex.pos.y < 597);
    tag = tag || (vertex.pos.y <= below && vertex.pos.x > 150 && vertex.pos.x < 400);
  }
  ImGui::Render();
  CHECK(edges == std::vector<bool>(4, true));
  CHECK(tag);
  CHECK(below > 10);
}

TEST_CASE("a recording is a red dot with its time at the top left") {
  const testing::HeadlessImGui imgui(800, 600);
  ImGui::NewFrame();
  draw_recording_mark(65 * kNsPerS, 1);
  ImRect place(1e6f, 1e6f, -1e6f, -1e6f);
  bool red = false;
  for (const ImDrawVert& vertex : ImGui::GetForegroundDrawList()->VtxBuffer) {
    place.Add(vertex.pos);
    red = red || vertex.col == IM_COL32(214, 28, 28, 255);
  }
  ImGui::Render();
  CHECK(red);
  CHECK(place.Min.x >= 0);
  CHECK(place.Max.x < 200);
  CHECK(place.Max.y < 60);
}

TEST_CASE("an interface or an output that is dragged to a universe is patched to it") {
  OutputsView view;
  view.universes = {3, 5, 8};
  view.devices.resize(1);
  view.devices[0] = {"enttec-pro:EN1", "ENTTEC DMX USB Pro", "ready", "", true};
  view.rows.resize(2);
  view.rows[0].endpoint = "enttec-pro:EN2=3";
  view.rows[0].universes = {3};
  view.rows[0].can_move = true;
  view.rows[1].id = 1;
  view.rows[1].endpoint = "sacn:3";
  view.rows[1].universes = {3};
  Ui ui(&view);
  const ImRect body = Ui::body();
  // From every row of the panel to every row below, since the test has no places of names and universes.
  bool added = false;
  bool moved = false;
  for (float from = body.Min.y; from < body.Max.y && !(added && moved); from += 8) {
    for (float to = from + 20; to < body.Max.y && !(added && moved); to += 8) {
      view.add.reset();
      view.move.reset();
      ui.drag({body.Min.x + 30, from}, {body.Min.x + 24, to});
      if (Ui::asks()) ImGui::ClosePopupToLevel(0, true);
      added = added || view.add == "enttec-pro:EN1=3";
      moved = moved || (view.move && view.move->id == 0 && view.move->to == 3);
      CHECK(!(view.move && view.move->id == 1));  // its endpoint names its universes
    }
  }
  CHECK(added);
  CHECK(moved);
}

TEST_CASE("an input that is dragged to a universe is moved to it") {
  OutputsView view;
  view.universes = {3, 5, 8};
  InputsView inputs;
  inputs.inputs = {"sacn:3", "enttec-pro:EN7=5"};
  inputs.movable = {"enttec-pro:EN7=5"};
  Ui ui(&view);
  ui.inputs = &inputs;
  for (int i = 0; i < 3; ++i) ui.frame();
  const ImRect body = Ui::body();
  bool moved = false;
  for (float from = body.Min.y; from < body.Max.y && !moved; from += 8) {
    for (float to = from + 20; to < body.Max.y && !moved; to += 8) {
      inputs.move.reset();
      ui.drag({body.Min.x + 30, from}, {body.Min.x + 24, to});
      moved = inputs.move.has_value();
    }
  }
  REQUIRE(moved);
  CHECK(inputs.move->input == "enttec-pro:EN7=5");
  CHECK(inputs.move->to == 3);
}

TEST_CASE("an output that is off is removed by one click, and a live one after a question") {
  OutputsView view = two_outputs();
  view.rows[1].state = ArmState::kArmed;
  Ui ui(&view);
  const auto remove = [&](int row) {
    const ImGuiWindow* const panel = ImGui::FindWindowByName("###Devices");
    REQUIRE(panel != nullptr);
    const ImGuiID table = ImHashStr("outputs", 0, panel->ID);
    ImGui::ActivateItem(ImHashStr("###remove", 0, ImHashData(&row, sizeof(row), table)));
    for (int i = 0; i < 3; ++i) ui.frame();
  };
  remove(0);
  CHECK(view.remove == std::vector<OutputId>{0});
  CHECK(!Ui::asks());
  view.remove.clear();
  remove(1);
  CHECK(view.remove.empty());
  REQUIRE(Ui::asks());
  CHECK(has(ui.words(), "enttec-pro:EN1 is live. Its lamps get zeros, and it is closed."));
  testing::activate("###Remove a live output?", {"###Leave it"});
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(view.remove.empty());
  CHECK(!Ui::asks());
  remove(1);
  testing::activate("###Remove a live output?", {"###Remove it"});
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(view.remove == std::vector<OutputId>{1});
  CHECK(!Ui::asks());
}

TEST_CASE("a question about an output that leaves the list meanwhile is closed") {
  OutputsView view = two_outputs();
  Ui ui(&view);
  testing::activate("###Devices", {"###arm all ..."});
  for (int i = 0; i < 3; ++i) ui.frame();
  REQUIRE(Ui::asks());
  view.rows.erase(view.rows.begin());
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(Ui::asks());  // about all that there are
  testing::activate("###Send to real lamps?", {"###Leave it"});
  for (int i = 0; i < 3; ++i) ui.frame();
  view = two_outputs();
  view.rows.push_back(view.rows[1]);
  view.rows[2].id = 2;
  view.rows[2].endpoint = "enttec-pro:EN2";
  const OutputId row = 1;
  const ImGuiID table = ImHashStr("outputs", 0, ImGui::FindWindowByName("###Devices")->ID);
  ui.frame();
  ImGui::ActivateItem(ImHashStr("###arm ...", 0, ImHashData(&row, sizeof(row), table)));
  for (int i = 0; i < 3; ++i) ui.frame();
  REQUIRE(Ui::asks());
  view.rows.erase(view.rows.begin());
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(Ui::asks());  // another one left the list, and its row has moved
  view.rows.erase(view.rows.begin());
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(!Ui::asks());
  CHECK(view.arm.empty());
}

ImGuiID output_item(OutputId id, const char* label) {
  const ImGuiID table = ImHashStr("outputs", 0, ImGui::FindWindowByName("###Devices")->ID);
  return ImHashStr(label, 0, ImHashData(&id, sizeof(id), table));
}
ImGuiID input_item(const char* endpoint, const char* label) {
  const ImGuiID table = ImHashStr("inputs", 0, ImGui::FindWindowByName("###Devices")->ID);
  return ImHashStr(label, 0, ImHashStr(endpoint, 0, table));
}

TEST_CASE("the blackout can be clicked in a panel that is too narrow for a line of all buttons") {
  OutputsView view = two_outputs();
  view.rows[1].state = ArmState::kArmed;
  Ui ui(&view, 440, 700, 2);
  ImRect body = Ui::body();
  REQUIRE(body.GetWidth() < 440);
  body.Min.y += 24;  // the title is twice as high
  const bool darkened = ui.click_over(body, false, [&] {
    if (Ui::asks()) ImGui::ClosePopupToLevel(0, true);
    return view.blackout == true;
  });
  CHECK(darkened);
}

TEST_CASE("no button of an output or an input moves when an output is armed, something fails or an input comes") {
  OutputsView view = two_outputs();
  view.universes = {1, 2};
  InputsView inputs;
  inputs.inputs = {"sacn:1", "mock:chase"};
  inputs.made_up = {"mock:chase"};
  Ui ui(&view, 1280, 1000);
  ui.inputs = &inputs;
  for (int i = 0; i < 3; ++i) ui.frame();
  const auto at = [&](ImVec2 place) {
    ImGui::GetIO().MousePos = place;
    for (int i = 0; i < 2; ++i) ui.frame();
    return ImGui::GetHoveredID();
  };
  const auto place_of = [&](ImGuiID item) {
    const ImRect body = Ui::body();
    for (float y = body.Min.y; y < body.Max.y; y += 4) {
      for (float x = body.Max.x; x > body.Min.x; x -= 16) {
        if (at({x, y}) == item) return ImVec2(x, y);
      }
    }
    return ImVec2(-1, -1);
  };
  const std::vector<ImGuiID> items{output_item(0, "###remove"), output_item(1, "###remove"),
                                   output_item(1, "###arm ..."), input_item("sacn:1", "###remove"),
                                   input_item("mock:chase", "###remove")};
  std::vector<ImVec2> places;
  for (const ImGuiID item : items) {
    places.push_back(place_of(item));
    REQUIRE(places.back().x > 0);
  }
  PumpStatus status;
  status.stamp_ns = 10 * kNsPerS;
  status.ports.resize(2);
  status.ports[0].name = "by hand";
  status.ports[0].trouble = "a trouble of some words";
  status.ports[1].name = "sacn:1";
  ui.status = &status;
  inputs.by_hand = "3 slots by hand";
  inputs.dark_by_hand = true;
  inputs.refusal = "sacn:7: no such thing";
  inputs.why_not = "Disarm the outputs to add inputs: real lamps would follow them.";
  view.refusal = "sacn:9: none of the rig";
  view.notice = "enttec-pro:EN1: armed: it sends the levels of the picture to real lamps";
  view.darkness = Darkness::kSilence;
  view.rows[0].trouble = "sacn:1-2: no route";
  view.rows[0].left_out = {2};
  view.rows[0].state = ArmState::kArmed;
  view.rows[0].status = PortStatus{.name = "sacn:1-2", .is_sink = true, .state = PortState::kGone};
  view.rows[0].status->latency.count = 7;
  view.rows[0].status->figures.push_back({"break_us", 176.4});
  for (std::size_t i = 0; i < items.size(); ++i) {
    INFO(i);
    CHECK(at(places[i]) == items[i]);
  }
  view.rows[1].state = ArmState::kArmed;
  CHECK(at(places[2]) == output_item(1, "###disarm"));
  view.rows[1].state = ArmState::kClosing;  // a second click on `disarm` does not fall on `remove`
  CHECK(at(places[1]) == items[1]);
}

TEST_CASE("the endpoint of an armed output can be read beside all its figures, and whole under the mouse") {
  for (const float scale : {1.0f, 2.0f}) {
    INFO(scale);
    OutputsView view = two_outputs();
    view.rows[1].endpoint = "mock:enttec-pro=3";
    view.rows[1].made_up = true;
    view.rows[1].state = ArmState::kArmed;
    view.rows[1].status = PortStatus{.name = "mock:enttec-pro=3", .is_sink = true, .state = PortState::kWorking};
    view.rows[1].status->frames = 4'711;
    view.rows[1].status->latency.count = 7;
    view.rows[1].status->figures.push_back({"break_us", 176.4});
    Ui ui(&view, 1280 - 264 * scale, 720, scale);  // beside the side panel
    const ImGuiTable* const table =
        ImGui::TableFindByID(ImHashStr("outputs", 0, ImGui::FindWindowByName("###Devices")->ID));
    REQUIRE(table != nullptr);
    CHECK(table->Columns[0].WidthGiven >= ImGui::GetFontSize() * 7 / 13 * 17);  // of the test's font, 17 letters
    const ImGuiWindow* const panel = ImGui::FindWindowByName("###Devices");
    bool tip = false;
    for (float y = panel->Pos.y; y < panel->Pos.y + panel->Size.y && !tip; y += 4) {
      ImGui::GetIO().MousePos = {table->Columns[0].MinX + 8, y};
      ui.frame();
      const std::string words = ui.words();
      tip = has(words, "mock:enttec-pro=3 (made up)") && has(words, "4711 frames");
    }
    CHECK(tip);
  }
}

TEST_CASE("the band names what is live, and a blackout") {
  OutputsView view = two_outputs();
  CHECK(live_words(view).empty());
  view.rows[0].state = ArmState::kOpening;
  CHECK(live_words(view).empty());
  view.rows[0].state = ArmState::kArmed;
  CHECK(live_words(view) == "LIVE: 1 output");
  view.rows[1].state = ArmState::kArmed;
  CHECK(live_words(view) == "LIVE: 2 outputs");
  CHECK(blackout_words(view).empty());
  view.darkness = Darkness::kAsked;
  CHECK(live_words(view) == "BLACKOUT of outputs: 2 send zeros");
  CHECK(has(blackout_words(view), "Shift+B"));
  view.darkness = Darkness::kSilence;
  CHECK(has(blackout_words(view), "no levels for 2.5 s"));
  view.darkness = Darkness::kNotHeld;
  CHECK(live_words(view) == "BLACKOUT of outputs: 2 send zeros");
  CHECK(blackout_words(view) == "Lamps are live while End is held");
  view.rows[0].state = view.rows[1].state = ArmState::kOff;
  CHECK(live_words(view).empty());  // nothing waits for the key
  view.darkness = Darkness::kAsked;
  CHECK(live_words(view) == "BLACKOUT of outputs: none is armed");
}

TEST_CASE("a box of the panel asks for the dead man's switch, in whose darkness a blackout can still be asked for") {
  OutputsView view = two_outputs();
  view.rows[1].state = ArmState::kArmed;
  Ui ui(&view);
  CHECK(has(ui.words(), "live only while End is held"));
  CHECK(!view.needs_hold);
  CHECK(ui.click_over(Ui::body(), false, [&] {
    if (Ui::asks()) ImGui::ClosePopupToLevel(0, true);
    return view.needs_hold;
  }));
  view.darkness = Darkness::kNotHeld;
  CHECK(has(ui.words(), "BLACKOUT"));
  CHECK(!has(ui.words(), "end the blackout"));
}

TEST_CASE("the band is a red frame at the edges of the window, over everything, only while something is live") {
  const testing::HeadlessImGui imgui(800, 600);
  OutputsView view = two_outputs();
  // Whether something red is drawn at each edge of the window.
  const auto red_edges = [&] {
    ImGui::NewFrame();
    StageTags tags(536);
    draw_live_band(view, tags, 1);
    const ImDrawList& draw = *ImGui::GetForegroundDrawList();
    std::vector<bool> edges(4);
    for (const ImDrawVert& vertex : draw.VtxBuffer) {
      if ((vertex.col & 0xff) < 180 || (vertex.col >> 8 & 0xff) > 60 || (vertex.col >> 24) < 200) continue;
      edges[0] = edges[0] || vertex.pos.x < 6;
      edges[1] = edges[1] || vertex.pos.y < 6;
      edges[2] = edges[2] || vertex.pos.x > 794;
      edges[3] = edges[3] || vertex.pos.y > 594;
    }
    const int count = draw.VtxBuffer.Size;
    ImGui::Render();
    return std::pair(edges, count);
  };
  CHECK(red_edges().second == 0);
  view.rows[1].state = ArmState::kArmed;
  CHECK(red_edges().first == std::vector<bool>(4, true));
  const int live = red_edges().second;
  view.darkness = Darkness::kAsked;
  CHECK(red_edges().first == std::vector<bool>(4, true));
  CHECK(red_edges().second > live);
  view.rows[1].state = ArmState::kOff;
  for (const std::size_t edge : {std::size_t{0}, std::size_t{2}, std::size_t{3}})
    CHECK(!red_edges().first[edge]);  // only its text, at the top
  view.darkness = Darkness::kNone;
  CHECK(red_edges().second == 0);
}

}  // namespace
}  // namespace footlight::tools

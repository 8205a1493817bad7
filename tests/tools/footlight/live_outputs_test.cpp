// Outputs of the window on their own thread: arming, disarming, blackout and the end, with sinks that keep what they
// get, and with a model of a widget.
#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/mock_usb.h"
#include "fixtures/edit/patch_slots.h"
#include "sim/system_clock.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/preview/live_outputs.h"
#include "tools/footlight/preview/ui/rig_index.h"

namespace footlight::tools {
namespace {

using footlight::testing::kUiRig;
using footlight::testing::parsed_rig;
using namespace std::chrono_literals;

// What lamps got: outlives the sink that sent it.
struct Wire {
  std::mutex mutex;
  std::vector<int> levels;  // of slot 1 of universe 1, of each frame
  int closed = 0;

  std::vector<int> so_far() {
    const std::lock_guard lock(mutex);
    return levels;
  }
  int last() {
    const std::lock_guard lock(mutex);
    return levels.empty() ? -1 : levels.back();
  }
  int closed_count() {
    const std::lock_guard lock(mutex);
    return closed;
  }
};

class WireSink final : public Sink {
 public:
  explicit WireSink(std::shared_ptr<Wire> wire) : wire_(std::move(wire)) {}
  std::string name() const override { return "wire"; }
  PortState state() const override { return PortState::kWorking; }
  PortCounters counters() const override { return {}; }
  std::span<const Universe> universes() const override { return universes_; }
  Status send(TimeNs, std::span<const FrameView> frames) override {
    const std::lock_guard lock(wire_->mutex);
    for (const FrameView& frame : frames) {
      if (frame.universe == 1) wire_->levels.push_back(frame.slots[0]);
    }
    return {};
  }
  Status poll(TimeNs) override { return {}; }
  void close(TimeNs) override {
    const std::lock_guard lock(wire_->mutex);
    ++wire_->closed;
  }

 private:
  std::array<Universe, 2> universes_{1, 2};
  std::shared_ptr<Wire> wire_;
};

PreviewScene scene_of(const char* rig) {
  PreviewScene scene;
  scene.rig = parsed_rig(rig);
  scene.compiled = testing::taken(fixtures::compile(scene.rig));
  scene.own_universes = scene.compiled.universes;
  return scene;
}

struct Window {
  explicit Window(std::vector<std::string> texts = {"sacn:1-2", "artnet:1"}) {
    auto plan = plan_outputs(texts, scene_of(kUiRig));
    REQUIRE_MESSAGE(plan, plan.error().message);
    outputs = testing::taken(LiveOutputs::start(
        std::move(*plan), [this](const PlannedOutput& output) { return open(output); }, clock));
    outputs->follow(view);
  }
  Result<std::unique_ptr<Sink>> open(const PlannedOutput& output) {
    while (waits.load()) std::this_thread::sleep_for(1ms);
    ++opened;
    if (refuses) return fail(ErrorCode::kNotFound, "{}: it is not plugged in", output.endpoint.text);
    return std::make_unique<WireSink>(wires[output.endpoint.text == "sacn:1-2" ? 0 : 1]);
  }
  void picture(std::uint8_t level) {
    const std::vector<std::uint8_t> levels(2 * kSlotCountMax, level);
    outputs->give(rig, levels, rig);
    outputs->follow(view);
  }
  // Pictures until `done`, or 30 s.
  template <class Done>
  bool until(std::uint8_t level, Done done) {
    const TimeNs end_ns = clock.now_ns() + 30 * kNsPerS;
    while (clock.now_ns() < end_ns) {
      picture(level);
      if (done()) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }
  bool armed(std::size_t index) const { return view.rows[index].state == ArmState::kArmed; }
  bool off(std::size_t index) const { return view.rows[index].state == ArmState::kOff; }

  SystemClock clock;
  std::array<Universe, 2> rig{1, 2};
  std::array<std::shared_ptr<Wire>, 2> wires{std::make_shared<Wire>(), std::make_shared<Wire>()};
  std::atomic<int> opened = 0;
  std::atomic<bool> waits = false;
  std::atomic<bool> refuses = false;
  OutputsView view;
  std::unique_ptr<LiveOutputs> outputs;
};

TEST_CASE("before an output is armed it is not even opened") {
  Window window;
  for (int i = 0; i < 100; ++i) {
    window.picture(200);
    std::this_thread::sleep_for(1ms);
  }
  CHECK(window.opened == 0);
  REQUIRE(window.view.rows.size() == 2);
  CHECK(window.view.live_count() == 0);
  window.outputs.reset();
  CHECK(window.opened == 0);
  CHECK(window.wires[0]->so_far().empty());
}

TEST_CASE("an armed output sends what the picture shows, and the others send nothing") {
  Window window;
  window.view.arm.push_back(0);
  CHECK(window.until(200, [&] { return window.wires[0]->last() == 200; }));
  CHECK(window.armed(0));
  CHECK(window.view.live_count() == 1);
  CHECK(window.until(17, [&] { return window.wires[0]->last() == 17; }));
  CHECK(window.off(1));
  CHECK(window.wires[1]->so_far().empty());
  CHECK(window.until(17, [&] { return window.view.rows[0].status && window.view.rows[0].status->rate_hz > 30; }));
}

TEST_CASE("disarming sends zeros, closes the output and sends nothing more, arming again begins with the new levels") {
  Window window;
  window.view.arm.push_back(0);
  REQUIRE(window.until(200, [&] { return window.wires[0]->last() == 200; }));
  window.view.disarm_all();
  REQUIRE(window.until(200, [&] { return window.off(0); }));
  CHECK(window.wires[0]->last() == 0);
  CHECK(window.wires[0]->closed_count() == 1);
  const std::size_t sent = window.wires[0]->so_far().size();
  for (int i = 0; i < 100; ++i) {
    window.picture(100);
    std::this_thread::sleep_for(1ms);
  }
  REQUIRE(window.wires[0]->so_far().size() == sent);
  window.view.arm.push_back(0);
  REQUIRE(window.until(100, [&] { return window.wires[0]->last() == 100; }));
  const auto levels = window.wires[0]->so_far();
  CHECK(levels[sent] == 100);  // not 200, which the pump had last
}

TEST_CASE("an output that cannot be opened is not armed, says why, and can be tried again") {
  Window window;
  window.refuses = true;
  window.view.arm.push_back(1);
  CHECK(window.until(200, [&] { return window.off(1) && !window.view.rows[1].trouble.empty(); }));
  CHECK(window.view.rows[1].trouble.find("not plugged in") != std::string::npos);
  window.refuses = false;
  window.view.arm.push_back(1);
  CHECK(window.until(200, [&] { return window.wires[1]->last() == 200; }));
  CHECK(window.view.rows[1].trouble.empty());
}

TEST_CASE("an output that is disarmed while it opens sends nothing") {
  Window window;
  window.waits = true;
  window.view.arm.push_back(0);
  window.picture(200);
  REQUIRE(window.view.rows[0].state == ArmState::kOpening);
  CHECK(window.view.live_count() == 0);
  window.view.disarm.push_back(0);
  window.picture(200);
  window.waits = false;
  CHECK(window.until(200, [&] { return window.off(0); }));
  for (int i = 0; i < 50; ++i) {
    window.picture(200);
    std::this_thread::sleep_for(1ms);
  }
  CHECK(window.opened == 1);
  CHECK(window.wires[0]->so_far().empty());
}

TEST_CASE("a blackout darkens all armed outputs, also those that are armed during it, and only the user ends it") {
  Window window;
  window.view.arm = {0};
  REQUIRE(window.until(200, [&] { return window.wires[0]->last() == 200; }));
  window.view.blackout = true;
  REQUIRE(window.until(200, [&] { return window.wires[0]->last() == 0; }));
  CHECK(window.view.darkness == Darkness::kAsked);
  window.view.arm = {1};
  REQUIRE(window.until(200, [&] { return window.wires[1]->last() >= 0; }));
  for (int i = 0; i < 100; ++i) {
    window.picture(200);
    std::this_thread::sleep_for(1ms);
  }
  CHECK(window.wires[0]->last() == 0);
  for (const int level : window.wires[1]->so_far()) CHECK(level == 0);
  window.view.blackout = false;
  CHECK(window.until(200, [&] { return window.wires[0]->last() == 200 && window.wires[1]->last() == 200; }));
  CHECK(window.view.darkness == Darkness::kNone);
}

TEST_CASE("a window that hangs leaves lamps dark, and says so when it goes on") {
  Window window;
  window.view.arm = {0};
  REQUIRE(window.until(200, [&] { return window.wires[0]->last() == 200; }));
  const TimeNs hung_ns = window.clock.now_ns();
  while (window.wires[0]->last() != 0 && window.clock.now_ns() - hung_ns < 30 * kNsPerS) {
    std::this_thread::sleep_for(10ms);
  }
  CHECK(window.wires[0]->last() == 0);
  CHECK(window.clock.now_ns() - hung_ns >= OutputFeed::kSilenceMaxNs - 100 * kNsPerMs);
  window.picture(200);
  CHECK(window.view.darkness == Darkness::kSilence);
  CHECK(window.armed(0));
  std::string all;
  for (const std::string& notice : window.outputs->notices()) all += notice + "\n";
  CHECK(all.find("gave no levels for 2.5 s") != std::string::npos);
}

TEST_CASE("with a dead man's switch an armed output sends the picture from the press of its key to the release") {
  Window window;
  window.view.arm = {0};
  window.view.needs_hold = true;
  bool held = false;
  const auto turns_until = [&](auto done) {
    return window.until(200, [&] {
      window.outputs->hold(held);
      return done();
    });
  };
  REQUIRE(turns_until([&] { return window.wires[0]->so_far().size() >= 3; }));
  for (const int level : window.wires[0]->so_far()) CHECK(level == 0);
  CHECK(window.view.darkness == Darkness::kNotHeld);
  held = true;
  CHECK(turns_until([&] { return window.wires[0]->last() == 200; }));
  held = false;
  CHECK(turns_until([&] { return window.wires[0]->last() == 0; }));
  const std::vector<std::string> notices = window.outputs->notices();
  REQUIRE(!notices.empty());
  CHECK(notices[0] ==
        "sacn:1-2: armed: it sends zeros until End is held, then the levels of the picture to real lamps");
  for (const std::string& notice : notices) CHECK(notice.find("blackout") == std::string::npos);  // not at each press
}

TEST_CASE("an output that is removed while it is live ends dark, is closed, and only then leaves the list") {
  Window window;
  window.view.arm = {0, 1};
  REQUIRE(window.until(200, [&] { return window.wires[0]->last() == 200 && window.wires[1]->last() == 200; }));
  window.view.remove = {0};
  window.picture(200);
  REQUIRE(window.until(200, [&] { return window.view.rows.size() == 1; }));
  CHECK(window.wires[0]->last() == 0);
  CHECK(window.wires[0]->closed_count() == 1);
  CHECK(window.view.rows[0].endpoint == "artnet:1");
  CHECK(window.armed(0));
  CHECK(window.view.rows[0].id == 1);
  window.view.disarm = {1};
  REQUIRE(window.until(200, [&] { return window.off(0); }));
  window.view.remove = {1};
  window.picture(200);
  CHECK(window.view.rows.empty());
  auto plan = plan_outputs(std::vector<std::string>{"sacn:1-2"}, scene_of(kUiRig));
  REQUIRE(plan);
  CHECK(window.outputs->add(std::move(plan->outputs[0])));
  window.picture(200);
  REQUIRE(window.view.rows.size() == 1);
  CHECK(window.off(0));
}

TEST_CASE("what is asked of an output that has left the list is done to no other one") {
  Window window({"sacn:1-2", "enttec-pro=1", "enttec-pro:EN7=1"});
  const std::vector<OutputRow> before = window.view.rows;
  window.view.remove = {before[0].id};
  window.picture(200);
  REQUIRE(window.view.rows.size() == 2);
  CHECK(window.view.rows[0].id == before[1].id);
  window.view.remove = {before[0].id};  // a click of the turn before
  window.view.arm = {before[0].id};
  window.picture(200);
  REQUIRE(window.view.rows.size() == 2);
  CHECK(window.off(0));
  CHECK(window.off(1));
  auto plan = plan_outputs(std::vector<std::string>{"enttec-pro:EN8=2"}, scene_of(kUiRig));
  REQUIRE(plan);
  const Status gone = window.outputs->replace(before[0].id, plan->outputs[0]);
  REQUIRE(!gone);
  CHECK(gone.error().message.find("removed meanwhile") != std::string::npos);
  REQUIRE(window.outputs->replace(before[2].id, plan->outputs[0]));
  window.picture(200);
  CHECK(window.view.rows[1].id == before[2].id);
  CHECK(window.view.rows[1].endpoint == "enttec-pro:EN8=2");
}

TEST_CASE("the next window has an output that was removed and added again, and none that was removed") {
  Window window;
  const auto planned = [](const char* text) {
    return plan_outputs(std::vector<std::string>{text}, scene_of(kUiRig)).value().outputs[0];
  };
  window.view.remove = {0};
  window.picture(200);
  CHECK(window.view.staying() == std::vector<std::string>{"artnet:1"});
  REQUIRE(window.outputs->add(planned("sacn:1-2")));
  window.picture(200);
  CHECK(window.view.staying() == std::vector<std::string>{"artnet:1", "sacn:1-2"});
  window.view.arm = {1};
  REQUIRE(window.until(200, [&] { return window.armed(0); }));
  window.view.remove = {1};
  window.picture(200);  // it ends dark, and is still in the list
  CHECK(window.view.staying() == std::vector<std::string>{"sacn:1-2"});
}

TEST_CASE("after the last output is removed there is no blackout, and one for another universe can be added") {
  Window window({"sacn:1-2"});
  window.view.blackout = true;
  window.view.remove = {0};
  CHECK(!end_without_outputs(window.outputs, window.view));
  window.picture(200);
  CHECK(window.view.darkness == Darkness::kAsked);
  CHECK(end_without_outputs(window.outputs, window.view));
  CHECK(window.outputs == nullptr);
  CHECK(window.view.darkness == Darkness::kNone);
  CHECK(live_words(window.view).empty());
  PreviewScene scene = scene_of(kUiRig);
  scene.own_universes = {9};  // as after an edit of the rig
  auto plan = plan_outputs(std::vector<std::string>{"sacn:9"}, scene);
  REQUIRE(plan);
  auto again = LiveOutputs::start(
      std::move(*plan), [&](const PlannedOutput& output) { return window.open(output); }, window.clock);
  REQUIRE(again);
  (*again)->follow(window.view);
  REQUIRE(window.view.rows.size() == 1);
  CHECK(window.view.rows[0].endpoint == "sacn:9");
  CHECK(window.view.darkness == Darkness::kNone);
}

TEST_CASE("an output that is removed while it opens is never armed") {
  Window window;
  window.waits = true;
  window.view.arm = {0};
  window.picture(200);
  window.view.remove = {0};
  window.picture(200);
  CHECK(window.view.rows.size() == 2);
  window.waits = false;
  REQUIRE(window.until(200, [&] { return window.view.rows.size() == 1; }));
  CHECK(window.wires[0]->so_far().empty());
}

TEST_CASE("the end of the window leaves lamps dark and closes what was armed") {
  Window window;
  window.view.arm = {0, 1};
  REQUIRE(window.until(200, [&] { return window.wires[0]->last() == 200 && window.wires[1]->last() == 200; }));
  window.outputs.reset();
  for (const auto& wire : window.wires) {
    CHECK(wire->last() == 0);
    CHECK(wire->closed_count() == 1);
  }
}

TEST_CASE("a widget gets nothing before arming, then the levels of the picture, and zeros when the window closes") {
  auto target = drivers::mock::mock_of_target("enttec-pro/window", true);
  REQUIRE(target);
  drivers::mock::MockUsb& usb = *target->usb;
  SystemClock clock;
  PortOpener opener(clock);
  auto plan = plan_outputs(std::vector<std::string>{"mock:enttec-pro/window=1"}, scene_of(kUiRig));
  REQUIRE_MESSAGE(plan, plan.error().message);
  auto outputs = testing::taken(LiveOutputs::start(
      std::move(*plan), [&](const PlannedOutput& one) { return opener.open_sink(one.endpoint, one.universes); },
      clock));
  OutputsView view;
  const std::array<Universe, 2> rig{1, 2};
  const std::vector<std::uint8_t> levels(2 * kSlotCountMax, 77);
  const auto picture = [&] {
    outputs->give(rig, levels, rig);
    outputs->follow(view);
    std::this_thread::sleep_for(1ms);
  };
  const auto frame = [&] { return usb.with_model([](const auto& model) { return model.line(0).frame; }); };
  for (int i = 0; i < 50; ++i) picture();
  CHECK(!usb.claimed());
  CHECK(frame().empty());
  view.arm = {0};
  const TimeNs end_ns = clock.now_ns() + 30 * kNsPerS;
  while (clock.now_ns() < end_ns && (frame().size() < 2 || frame()[1] != 77)) picture();
  REQUIRE(frame().size() > 1);
  CHECK(frame()[1] == 77);
  outputs.reset();
  CHECK(!usb.claimed());
  for (std::size_t i = 1; i < frame().size(); ++i) REQUIRE(frame()[i] == 0);
}

TEST_CASE("outputs that cannot be meant are refused before the window opens, with the next step") {
  PreviewScene scene = scene_of(kUiRig);
  const auto refusal = [&](std::vector<std::string> texts) {
    const auto plan = plan_outputs(texts, scene);
    return plan ? std::string() : plan.error().message;
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  CHECK(refusal({"sacn:1-2", "enttec-pro=2", "log:levels.dmxlog"}).empty());
  CHECK(has(refusal({"nonsense:1"}), "nonsense"));
  CHECK(has(refusal({"gpio:mock/2=1.25"}), "this is an input"));
  CHECK(has(refusal({"osc:8000"}), "this is an input"));
  CHECK(has(refusal({"mock:chase=1"}), "this is an input"));
  CHECK(has(refusal({"audio:mock=1.25"}), "this is an input"));
  CHECK(has(refusal({"vrsl:1-2@window"}), "footlight run"));
  CHECK(has(refusal({"sacn:1", "sacn:1"}), "named twice"));
  CHECK(has(refusal({"sacn:7-9"}), "have addresses in universe 1-2, and this output carries 7-9"));
  // Universe 2 is one that faders made up.
  scene.own_universes = {1};
  CHECK(has(refusal({"sacn:2"}), "have addresses in universe 1,"));
  const auto partly = plan_outputs(std::vector<std::string>{"sacn:1-3"}, scene);
  REQUIRE(partly);
  REQUIRE(partly->warnings.size() == 1);
  CHECK(has(partly->warnings[0], "universe 2-3 is not sent"));
  CHECK(has(partly->warnings[0], "made-up"));
  scene.own_universes = {};
  CHECK(has(refusal({"sacn:1"}), "made-up ones of its faders are not sent"));
  scene.own_universes = {1, 2};
  scene.written = scene.rig;
  CHECK(has(refusal({"sacn:1"}), "VR Stage Lighting"));
}

TEST_CASE("an output is added while others are armed, and is not armed itself") {
  Window window({"sacn:1-2"});
  window.view.arm = {0};
  REQUIRE(window.until(200, [&] { return window.wires[0]->last() == 200; }));
  auto more = plan_outputs(std::vector<std::string>{"artnet:1"}, scene_of(kUiRig));
  REQUIRE(more);
  const PlannedOutput planned = more->outputs[0];
  REQUIRE(window.outputs->add(planned));
  for (int i = 0; i < 50; ++i) window.picture(200);
  REQUIRE(window.view.rows.size() == 2);
  CHECK(window.off(1));
  CHECK(window.opened == 1);
  CHECK(!window.outputs->add(planned));  // twice
  PlannedOutput unknown = planned;
  unknown.endpoint.text = "artnet:7";
  unknown.universes = {7};
  CHECK(!window.outputs->add(unknown));
  window.view.arm = {1};
  CHECK(window.until(30, [&] { return window.wires[1]->last() == 30 && window.wires[0]->last() == 30; }));
}

TEST_CASE("a device with one connector gets another universe while it is off, and only then") {
  const auto moved = [](const char* text) { return moved_endpoint(parse_port(text).value(), 2).value_or(""); };
  CHECK(moved("enttec-pro") == "enttec-pro=2");
  CHECK(moved("enttec-pro:EN1=1") == "enttec-pro:EN1=2");
  CHECK(moved("mock:enttec-pro/A=1") == "mock:enttec-pro/A=2");
  CHECK(moved("enttec-pro:EN1=1,2").empty());
  CHECK(moved("sacn:1").empty());
  CHECK(moved("log:a=1").empty());

  Window window({"sacn:1-2", "enttec-pro=1"});
  CHECK(window.view.rows[1].can_move);
  CHECK(!window.view.rows[0].can_move);
  const auto planned = [](const char* text) {
    return plan_outputs(std::vector<std::string>{text}, scene_of(kUiRig)).value().outputs[0];
  };
  REQUIRE(window.outputs->replace(1, planned("enttec-pro=2")));
  window.picture(9);
  CHECK(window.view.rows[1].endpoint == "enttec-pro=2");
  CHECK(window.view.rows[1].universes == std::vector<Universe>{2});
  CHECK(!window.outputs->replace(1, planned("sacn:1-2")));  // it is there already
  window.view.arm = {1};
  REQUIRE(window.until(50, [&] { return window.armed(1); }));
  CHECK(!window.view.rows[1].can_move);
  const Status refused = window.outputs->replace(1, planned("enttec-pro=1"));
  REQUIRE(!refused);
  CHECK(refused.error().message.find("disarm it") != std::string::npos);
  CHECK(window.view.rows[1].endpoint == "enttec-pro=2");
}

TEST_CASE("devices that are plugged in can be outputs only if they are ready and have one") {
  drivers::DeviceList list;
  list.devices.resize(4);
  list.devices[0].endpoint = "enttec-pro:EN1";
  list.devices[0].capabilities = drivers::kCanOutput | drivers::kCanInput;
  list.devices[1] = list.devices[0];
  list.devices[1].readiness = drivers::Readiness::kNoPermission;
  list.devices[1].reason = "not yours";
  list.devices[1].remedy = "sudo install the rules";
  list.devices[2] = list.devices[0];
  list.devices[2].capabilities = drivers::kCanInput;
  list.devices[3].readiness = drivers::Readiness::kNotDmx;
  const auto plugged = plugged_devices(list);
  REQUIRE(plugged.size() == 4);
  CHECK(plugged[0].can_send);
  CHECK(plugged[0].state == "ready");
  CHECK(plugged[0].fix.empty());
  CHECK(!plugged[1].can_send);
  CHECK(plugged[1].fix == "not yours: sudo install the rules");
  CHECK(!plugged[2].can_send);
  CHECK(!plugged[3].can_send);
}

TEST_CASE("what an edit deletes is dark in the next picture of the rig from before, but for slots that others share") {
  PreviewScene before = scene_of(kUiRig);
  for (std::size_t i = 0; i < before.rig.fixtures.size(); ++i) before.ids.push_back(static_cast<int>(i));
  const std::vector<std::uint8_t> full(before.compiled.universes.size() * kSlotCountMax, 200);
  const RigIndex slots(before.rig, before.compiled);
  std::vector<std::uint8_t> levels = full;
  darken_deleted(before, before, levels);
  CHECK(levels == full);
  PreviewScene after;
  after.ids = {before.ids[0], before.ids[2]};
  darken_deleted(before, after, levels);
  const auto raw = [&](int fixture) { return slots.read({fixture, 0}, levels); };
  CHECK(raw(0) == slots.read({0, 0}, full));
  CHECK(raw(1) == 0);
  CHECK(raw(2) == slots.read({2, 0}, full));
  after.ids.clear();
  darken_deleted(before, after, levels);
  for (std::size_t i = 0; i < before.rig.fixtures.size(); ++i) CHECK(raw(static_cast<int>(i)) == 0);
  before.rig.fixtures[1] = before.rig.fixtures[0];  // both at one address
  fixtures::share_conflicting_addresses(before.rig);
  before.compiled = testing::taken(fixtures::compile(before.rig));
  after.ids = {before.ids[0]};
  levels = full;
  darken_deleted(before, after, levels);
  CHECK(RigIndex(before.rig, before.compiled).read({0, 0}, levels) == slots.read({0, 0}, full));
}

TEST_CASE("a rig whose fixtures have no address has no universe of its own, whatever its faders use") {
  fixtures::Rig rig = parsed_rig(kUiRig);
  for (auto& fixture : rig.fixtures) {
    if (fixture.name == "Far par") fixture.patched = false;
  }
  auto partly = EditedScene::make(RigFile::made(fixtures::as_imported(rig, "toml"), "ui.toml"), {}, 1.5, true);
  REQUIRE(partly);
  CHECK((*partly)->scene()->own_universes == std::vector<Universe>{1});
  CHECK((*partly)->scene()->compiled.universes == std::vector<Universe>{1, 2});
  CHECK(logged_universes(*(*partly)->scene()) == std::vector<Universe>{1});  // a log has no others
  for (auto& fixture : rig.fixtures) fixture.patched = false;
  auto none = EditedScene::make(RigFile::made(fixtures::as_imported(rig, "toml"), "ui.toml"), {}, 1.5, true);
  REQUIRE(none);
  CHECK((*none)->scene()->own_universes.empty());
  CHECK(!(*none)->scene()->compiled.universes.empty());
}

}  // namespace
}  // namespace footlight::tools

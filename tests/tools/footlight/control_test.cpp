// Controls without a network or a device: OSC packets and MIDI events to commands of the hand.
#include <doctest/doctest.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "drivers/midi/midi_device.h"
#include "fixtures/model/rig.h"
#include "tests/support/fake_ports.h"
#include "tests/support/temp_folder.h"
#include "tools/footlight/hand/control_map.h"
#include "tools/footlight/hand/learn.h"
#include "tools/footlight/hand/midi_hand.h"
#include "tools/footlight/hand/osc_hand.h"
#include "tools/footlight/hand/tempo_taps.h"

namespace footlight::tools {
namespace {

using testing::FakeClock;
using testing::FakeSource;
using testing::FakeWaiter;
using testing::TempFolder;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

// Keeps what it is told.
struct Taker final : HandTaker {
  std::vector<HandCommand> commands;
  std::vector<SceneCall> scenes;
  bool black = false;
  Status take(const HandCommand& command, TimeNs /*now_ns*/) override {
    commands.push_back(command);
    if (command.action == HandAction::kBlackout) black = true;
    if (command.action == HandAction::kLift) black = false;
    return {};
  }
  void recall(const SceneCall& call) override { scenes.push_back(call); }
  [[nodiscard]] bool blacked_out() const override { return black; }
  // The last command's levels as values.
  std::vector<std::uint32_t> values() const {
    std::vector<std::uint32_t> values;
    for (const HandLevel& level : commands.back().levels) values.push_back(level.value);
    return values;
  }
};

struct NoFrames final : FrameReceiver {
  void receive(const FrameView& /*frame*/) override { CHECK(false); }
};

double others_of(const Source& source) {
  std::vector<PortFigure> figures;
  source.take_figures(figures);
  return figures.at(0).value;
}

constexpr const char* kRig =
    "[rig]\nname = \"r\"\n[[fixture]]\nname = \"Mover 3\"\ntype = \"generic/profile\"\nmode = \"16 bit\"\nposition = "
    "[0, 0, 5]\nuniverse = "
    "2\n"
    "address = 1\n";

struct Phone {
  explicit Phone(ControlMap map = {}) {
    link->taker = &taker;
    auto opened = OscHand::open({.name = "osc", .address = "127.0.0.1", .map = std::move(map), .link = link});
    REQUIRE_MESSAGE(opened.has_value(), (opened ? "" : opened.error().message));
    source = std::move(*opened);
  }
  void say(std::string_view address, std::initializer_list<std::int32_t> numbers) {
    std::array<std::uint8_t, 256> packet;
    const std::vector<std::int32_t> list(numbers);
    source->take(std::span(packet).first(drivers::build_osc(address, list, packet)), 0);
  }
  void say_float(std::string_view address, float number) {
    std::array<std::uint8_t, 256> packet;
    source->take(std::span(packet).first(drivers::build_osc_float(address, number, packet)), 0);
  }

  Taker taker;
  std::shared_ptr<HandLink> link = std::make_shared<HandLink>();
  std::unique_ptr<OscHand> source;
};

TEST_CASE("OSC sets slots: integers are levels, floats are shares, further arguments are the next addresses") {
  Phone phone;
  phone.say("/footlight/1/17", {128});
  REQUIRE(phone.taker.commands.size() == 1);
  CHECK(phone.taker.commands[0].levels[0] == HandLevel{.universe = 1, .slots = {16}, .value = 128});
  CHECK(phone.taker.commands[0].priority == kHandPriorityDefault);
  phone.say_float("/footlight/1/17", 0.5F);
  CHECK(phone.taker.values() == std::vector<std::uint32_t>{128});
  phone.say_float("/footlight/1/17", 1.0F);
  CHECK(phone.taker.values() == std::vector<std::uint32_t>{255});
  phone.say("/footlight/1/17", {1});
  CHECK(phone.taker.values() == std::vector<std::uint32_t>{1});
  phone.say("/footlight/3/510", {1, 2, 300});
  CHECK(phone.taker.values() == std::vector<std::uint32_t>{1, 2, 255});
  phone.say_float("/footlight/1/17", -7.0F);
  CHECK(phone.taker.values() == std::vector<std::uint32_t>{0});
  CHECK(phone.source->counters().frames == 6);
}

TEST_CASE("OSC addresses without a meaning and damaged packets do nothing and are counted") {
  Phone phone;
  for (const char* address : {"/footlight/0/17", "/footlight/1/513", "/footlight/1", "/footlight/1/2/3", "/footlight/",
                              "/footlight/1/x", "/other/1/17", "/footlight/64000/1", "/footlight/99999999999/1"}) {
    phone.say(address, {5});
  }
  phone.say("/footlight/1/512", {1, 2});
  phone.say_float("/footlight/1/17", std::numeric_limits<float>::quiet_NaN());
  CHECK(phone.taker.commands.empty());
  CHECK(others_of(*phone.source) == 11);
  const std::array<std::uint8_t, 3> damaged = {'/', 'a', 0};
  phone.source->take(damaged, 0);
  phone.source->take({}, 0);
  CHECK(phone.source->counters().rejected == 2);
}

TEST_CASE("OSC buttons do their job once for each press") {
  Phone phone;
  phone.say("/footlight/blackout", {1});
  CHECK(phone.taker.commands.back().action == HandAction::kBlackout);
  phone.say("/footlight/blackout", {0});
  CHECK(phone.taker.commands.back().action == HandAction::kLift);
  phone.say("/footlight/blackout", {});
  CHECK(phone.taker.commands.back().action == HandAction::kBlackout);
  const std::size_t before = phone.taker.commands.size();
  phone.say("/footlight/release", {0});
  CHECK(phone.taker.commands.size() == before);
  phone.say("/footlight/release", {1});
  CHECK(phone.taker.commands.back().action == HandAction::kReleaseAll);
  phone.say("/footlight/release/1/17", {1});
  CHECK(phone.taker.commands.back().action == HandAction::kRelease);
  CHECK(phone.taker.commands.back().levels[0].slots[0] == 16);
  phone.say("/footlight/scene/Warm", {1});
  phone.say("/footlight/scene/Warm", {0});
  REQUIRE(phone.taker.scenes.size() == 1);
  CHECK(phone.taker.scenes[0].name == "Warm");
}

TEST_CASE("OSC taps the tempo once for each press, and sets it as a number") {
  Phone phone;
  phone.say("/footlight/tap", {1});
  phone.say("/footlight/tap", {0});
  phone.say("/footlight/tap", {});
  REQUIRE(phone.taker.commands.size() == 2);
  for (const HandCommand& command : phone.taker.commands) {
    CHECK(command.action == HandAction::kTempo);
    CHECK(command.beats_a_minute == 0);
  }
  phone.say("/footlight/tempo", {128});
  CHECK(phone.taker.commands.back().beats_a_minute == 128);
  phone.say_float("/footlight/tempo", 93.5F);
  CHECK(phone.taker.commands.back().beats_a_minute == 93.5);
  phone.say("/footlight/tempo", {});
  phone.say("/footlight/tempo", {0});
  phone.say("/footlight/tempo", {90, 100});
  CHECK(phone.taker.commands.size() == 4);
}

TEST_CASE("the next control that moves is learnt and does nothing, the one after it works") {
  Phone phone;
  HandLearner& osc = phone.link->learner;
  osc.begin();
  phone.say("/1/fader1", {3});
  phone.say("/footlight/1/17", {9});
  CHECK(phone.taker.commands.size() == 1);
  auto moved = osc.moved();
  REQUIRE(moved.has_value());
  CHECK(moved->port == "osc");
  CHECK(moved->input == "/1/fader1");
  CHECK(!osc.moved().has_value());
  osc.begin();
  osc.end();
  phone.say("/footlight/1/17", {9});
  CHECK(phone.taker.commands.size() == 2);
  CHECK(!osc.moved().has_value());
  osc.begin();
  phone.say("/1/fader1", {3});
  osc.end();  // before the window has asked
  CHECK(!osc.moved().has_value());
}

TEST_CASE("a line that is on at the start, or when its device is back, is no tap of the tempo") {
  FakeClock clock;
  FakeWaiter waiter(clock);
  auto lines = std::make_unique<FakeSource>(waiter, "lines", std::vector<Universe>{1});
  FakeSource& line = *lines;
  const auto tempo = std::make_shared<Tempo>();
  TempoTaps taps(std::move(lines), tempo);
  struct Nowhere final : FrameReceiver {
    void receive(const FrameView&) override { FAIL("lines that tap deliver no frames"); }
  } nowhere;
  const auto turns = [&](std::uint8_t level, TimeNs at_ns) {
    line.give(1, level, kPriorityDefault, at_ns);
    REQUIRE(taps.poll(at_ns, nowhere));
  };
  turns(255, 1 * kNsPerS);
  turns(0, 1'100 * kNsPerMs);
  turns(255, 1'600 * kNsPerMs);  // the first tap
  CHECK(tempo->beats_a_minute() == kTempoDefault);
  line.end(1);
  turns(0, 2 * kNsPerS);
  line.end(1);
  turns(255, 2'100 * kNsPerMs);  // it was on before the device was back
  turns(0, 2'200 * kNsPerMs);
  CHECK(tempo->beats_a_minute() == kTempoDefault);
  turns(255, 2'350 * kNsPerMs);  // the second one, 750 ms after the first
  CHECK(tempo->beats_a_minute() == doctest::Approx(80));
}

TEST_CASE("a map gives OSC addresses a target, and its rig the attributes of fixtures") {
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kRig;
  std::ofstream(folder.file("map.toml"))
      << "port = 8000\nrig = \"rig.toml\"\npriority = 170\n[[control]]\ninput = \"/1/fader1\"\nto = \"1.1-2\"\nlow = "
         "\"10\"\nhigh = \"20\"\n[[control]]\ninput = \"/1/push1\"\nto = \"blackout\"\ntoggle = true\n[[control]]\n"
         "input = \"/1/tilt\"\nto = \"Mover 3:Tilt\"\nlow = \"-45\"\nhigh = \"45\"\n";
  const auto map = load_control_map(folder.file("map.toml"));
  REQUIRE_MESSAGE(map.has_value(), (map ? "" : map.error().message));
  Phone phone(*map);
  phone.say_float("/1/fader1", 0.5F);
  CHECK(phone.taker.values() == std::vector<std::uint32_t>{15, 15});
  CHECK(phone.taker.commands.back().priority == 170);
  phone.say_float("/1/push1", 1);
  CHECK(phone.taker.commands.back().action == HandAction::kBlackout);
  const std::size_t before = phone.taker.commands.size();
  phone.say_float("/1/push1", 0);
  CHECK(phone.taker.commands.size() == before);
  phone.say_float("/1/push1", 1);
  CHECK(phone.taker.commands.back().action == HandAction::kLift);

  phone.say_float("/footlight/fixture/Mover_3/Tilt", 0.0F);
  CHECK(phone.taker.values() == std::vector<std::uint32_t>{0});
  CHECK(phone.taker.commands.back().levels[0].count == 2);
  phone.say_float("/footlight/fixture/Mover_3/Tilt", 1.0F);
  CHECK(phone.taker.values() == std::vector<std::uint32_t>{65'535});
  phone.say_float("/1/tilt", 0.5F);
  CHECK(phone.taker.values()[0] == doctest::Approx(32'768).epsilon(0.0001));
}

TEST_CASE("OSC buttons of a map are pressed by the integer 1, and by messages without arguments each time") {
  const auto map = parse_control_map(
      "[[control]]\ninput = \"/scene\"\nto = \"scene Warm\"\n[[control]]\ninput = \"/dark\"\nto = \"blackout\"\n"
      "[[control]]\ninput = \"/release\"\nto = \"release\"\n[[control]]\ninput = \"/toggle\"\nto = \"blackout\"\n"
      "toggle = true\n",
      "m.toml");
  REQUIRE(map.has_value());
  Phone phone(*map);
  phone.say("/scene", {1});
  phone.say("/scene", {0});
  phone.say("/scene", {});
  phone.say("/scene", {});
  CHECK(phone.taker.scenes.size() == 3);
  phone.say("/release", {1});
  REQUIRE(phone.taker.commands.size() == 1);
  CHECK(phone.taker.commands[0].action == HandAction::kReleaseAll);
  phone.say("/dark", {1});
  CHECK(phone.taker.black);
  phone.say("/dark", {0});
  CHECK_FALSE(phone.taker.black);
  phone.say("/dark", {});
  CHECK(phone.taker.black);
  phone.say("/dark", {0});
  CHECK(phone.taker.black);  // it has no end
  phone.say("/toggle", {});
  CHECK_FALSE(phone.taker.black);
  phone.say("/toggle", {});
  CHECK(phone.taker.black);
}

TEST_CASE("a control of the blackout follows the bridge, and ends no blackout that another one began") {
  const auto map = parse_control_map(
      "[[control]]\ninput = \"/dark\"\nto = \"blackout\"\n[[control]]\ninput = \"/toggle\"\nto = \"blackout\"\n"
      "toggle = true\n",
      "m.toml");
  Phone phone(*map);
  phone.taker.black = true;  // by 'footlight blackout'
  phone.say_float("/dark", 1);
  CHECK(phone.taker.commands.back().action == HandAction::kBlackout);
  phone.say_float("/dark", 0);
  CHECK(phone.taker.black);
  phone.say_float("/toggle", 1);
  phone.say_float("/toggle", 0);
  CHECK_FALSE(phone.taker.black);
  phone.say_float("/dark", 1);  // the end of this press is lost
  phone.taker.black = false;    // 'footlight blackout off'
  phone.say_float("/dark", 1);
  CHECK(phone.taker.black);
  phone.say_float("/dark", 0);
  CHECK_FALSE(phone.taker.black);
}

TEST_CASE("errors of a control map name the file, the line and what was expected") {
  const auto refused = [](const std::string& text) {
    const auto map = parse_control_map(text, "m.toml");
    if (!map) return map.error().message;
    const RigOf none = [](const std::string&) -> Result<const fixtures::Rig*> {
      return fail(ErrorCode::kBadInput, "no rig");
    };
    const auto control = Control::make(map->controls.at(0), *map, none);
    REQUIRE_FALSE(control.has_value());
    return control.error().message;
  };
  CHECK(contains(refused("[[control]]\ninput = \"/a\"\n"), "to"));
  CHECK(contains(refused("[[control]]\ninput = \"/a\"\nto = \"1.600\"\n"), "m.toml:1:1: 1.600"));
  CHECK(contains(refused("[[control]]\ninput = \"/a\"\nto = \"Mover 3:Tilt\"\n"), "no rig"));
  CHECK(contains(refused("[[control]]\ninput = \"/a\"\nto = \"1.1\"\nlow = \"x\"\n"), "0 to 255"));
  CHECK(contains(refused("[[control]]\ninput = \"/a\"\nto = \"1.1\"\nover = \"25h\"\n"), "m.toml:4"));
  CHECK(contains(refused("[[control]]\ninput = \"/a\"\nto = \"1.1\"\n[[control]]\ninput = \"/a\"\nto = \"1.1\"\n"),
                 "already, at line 1"));
  CHECK(contains(refused("prot = 8000\n"), "port"));
  const auto osc = OscHand::open({.name = "osc:x", .address = "300.0.0.1"});
  REQUIRE_FALSE(osc.has_value());
  CHECK(contains(osc.error().message, "IPv4"));
}

TEST_CASE("a UDP port that another program has is refused with its next step") {
  const Phone phone;
  const auto second = OscHand::open({.name = "osc:x", .address = "127.0.0.1", .udp_port = phone.source->udp_port()});
  REQUIRE_FALSE(second.has_value());
  CHECK(contains(second.error().message, "another program"));
}

// A device whose events the test gives.
struct Box final : drivers::MidiDevice {
  std::vector<drivers::MidiEvent> waiting;
  bool unplugged = false;
  [[nodiscard]] int poll_fd() const override { return -1; }
  Status read(std::vector<drivers::MidiEvent>& into, TimeNs /*now_ns*/) override {
    if (unplugged) return fail(ErrorCode::kDisconnected, "midi:box: unplugged");
    into.insert(into.end(), waiting.begin(), waiting.end());
    waiting.clear();
    return {};
  }
  Status reconnect() override {
    if (unplugged) return fail(ErrorCode::kNotFound, "midi:box: not there");
    return {};
  }
};

struct Faders {
  explicit Faders(const std::string& map_text = "") {
    link->taker = &taker;
    MidiHandOptions options{.name = "midi", .universe = 4, .first_address = 101, .link = link};
    auto map = parse_control_map(map_text, "m.toml");
    REQUIRE_MESSAGE(map.has_value(), (map ? "" : map.error().message));
    options.map = std::move(*map);
    auto device = std::make_unique<Box>();
    box = device.get();
    auto made = MidiHand::make(std::move(options), std::move(device));
    REQUIRE_MESSAGE(made.has_value(), (made ? "" : made.error().message));
    source = std::move(*made);
  }
  void move(drivers::MidiKind kind, int channel, int number, int value) {
    box->waiting.push_back({kind, channel, number, value});
    CHECK(source->poll(0, none).has_value());
  }

  Taker taker;
  NoFrames none;
  std::shared_ptr<HandLink> link = std::make_shared<HandLink>();
  Box* box = nullptr;
  std::unique_ptr<MidiHand> source;
};

constexpr auto kController = drivers::MidiKind::kController;
constexpr auto kNote = drivers::MidiKind::kNote;

TEST_CASE("without a map controller n sets the address n after the first") {
  Faders faders;
  faders.move(kController, 9, 7, 127);
  REQUIRE(faders.taker.commands.size() == 1);
  CHECK(faders.taker.commands[0].levels[0] == HandLevel{.universe = 4, .slots = {107}, .value = 255});
  faders.move(kController, 1, 7, 64);
  CHECK(faders.taker.values() == std::vector<std::uint32_t>{129});
  faders.move(kNote, 1, 60, 100);
  CHECK(faders.taker.commands.size() == 2);
  CHECK(others_of(*faders.source) == 1);
}

TEST_CASE("a map of MIDI has controllers of 7 and 14 bits, keys and pitch bend") {
  Faders faders(
      "[[control]]\ninput = \"cc 1 7\"\nto = \"1.17\"\n[[control]]\ninput = \"cc14 2 1\"\nto = \"1.1+2\"\n[[control]]\n"
      "input = \"note 1 60\"\nto = \"scene Warm\"\nover = \"3s\"\n[[control]]\ninput = \"note 1 61\"\nto = "
      "\"blackout\"\n[[control]]\ninput = \"pitch 1\"\nto = \"1.20\"\n");
  faders.move(kController, 1, 7, 127);
  CHECK(faders.taker.values() == std::vector<std::uint32_t>{255});
  faders.move(kController, 2, 33, 5);  // the lower half without the upper one
  faders.move(kController, 2, 7, 127);
  CHECK(faders.taker.commands.size() == 1);
  faders.move(kController, 2, 1, 127);
  CHECK(faders.taker.commands.size() == 1);
  faders.move(kController, 2, 33, 127);
  CHECK(faders.taker.values() == std::vector<std::uint32_t>{65'535});
  faders.move(kNote, 1, 60, 1);
  faders.move(kNote, 1, 60, 0);
  REQUIRE(faders.taker.scenes.size() == 1);
  CHECK(faders.taker.scenes[0].name == "Warm");
  CHECK(faders.taker.scenes[0].over_ns == 3 * kNsPerS);
  faders.move(kNote, 1, 61, 30);
  CHECK(faders.taker.commands.back().action == HandAction::kBlackout);
  faders.move(kNote, 1, 61, 0);
  CHECK(faders.taker.commands.back().action == HandAction::kLift);
  faders.move(drivers::MidiKind::kPitchBend, 1, 0, 8'192);
  CHECK(faders.taker.values() == std::vector<std::uint32_t>{128});
}

TEST_CASE("a key that is mapped to the tempo is a tap with each press, and a fader one with each way up") {
  Faders faders(
      "[[control]]\ninput = \"note 1 60\"\nto = \"tempo\"\n[[control]]\ninput = \"cc 1 7\"\nto = \"tempo\"\n");
  faders.move(kNote, 1, 60, 9);
  faders.move(kNote, 1, 60, 0);
  faders.move(kNote, 1, 60, 127);
  CHECK(faders.taker.commands.size() == 2);
  for (const int value : {10, 60, 70, 127, 20, 80}) faders.move(kController, 1, 7, value);
  REQUIRE(faders.taker.commands.size() == 4);
  CHECK(faders.taker.commands.back() == HandCommand{.action = HandAction::kTempo, .levels = {}});
}

TEST_CASE("the press of a key is learnt, and its end before is not") {
  Faders faders;
  faders.link->learner.begin();
  faders.move(kNote, 1, 60, 0);
  CHECK(!faders.link->learner.moved().has_value());
  faders.move(kNote, 1, 61, 5);
  const auto moved = faders.link->learner.moved();
  REQUIRE(moved.has_value());
  CHECK(moved->input == "note 1 61");
  CHECK(faders.taker.commands.empty());
}

TEST_CASE("a MIDI device that is unplugged is gone, and works again when it is back") {
  Faders faders;
  faders.box->unplugged = true;
  CHECK(faders.source->poll(0, faders.none).has_value());
  CHECK(faders.source->state() == PortState::kGone);
  CHECK(contains(faders.source->trouble(), "unplugged"));
  CHECK(faders.source->next_deadline_ns() == kNsPerS);
  CHECK(faders.source->poll(kNsPerS, faders.none).has_value());
  CHECK(faders.source->state() == PortState::kGone);
  faders.box->unplugged = false;
  faders.box->waiting.push_back({kController, 1, 0, 127});
  CHECK(faders.source->poll(2 * kNsPerS, faders.none).has_value());
  CHECK(faders.source->state() == PortState::kWorking);
  CHECK(faders.taker.commands.size() == 1);
}

TEST_CASE("texts of MIDI inputs are read strictly") {
  CHECK(drivers::parse_midi_input("cc 1 7") == drivers::MidiInput{kController, false, 1, 7});
  CHECK(drivers::parse_midi_input("cc14 16 31") == drivers::MidiInput{kController, true, 16, 31});
  CHECK(drivers::parse_midi_input("note 1 127") == drivers::MidiInput{kNote, false, 1, 127});
  CHECK(drivers::parse_midi_input("pitch 3") == drivers::MidiInput{drivers::MidiKind::kPitchBend, false, 3, 0});
  for (const char* text : {"", "cc", "cc 0 7", "cc 17 7", "cc 1 128", "cc 1", "cc14 1 32", "pitch 1 2", "cc  1 7",
                           "cc 1 7 ", "note 1 -1", "cc1 7", "/a"}) {
    CAPTURE(text);
    CHECK_FALSE(drivers::parse_midi_input(text).has_value());
  }
}

TEST_CASE("the model of a MIDI device moves a controller over its whole range and plays a key") {
  const auto model = drivers::make_midi_model(0);
  std::vector<drivers::MidiEvent> events;
  for (TimeNs now_ns = 0; now_ns <= 6 * kNsPerS; now_ns = model->next_event_ns()) {
    CHECK(model->read(events, now_ns).has_value());
  }
  int lowest = 127, highest = 0, keys = 0;
  for (const drivers::MidiEvent& event : events) {
    if (event.kind == kNote) keys += event.value > 0 ? 1 : 0;
    if (event.kind != kController) continue;
    lowest = std::min(lowest, event.value);
    highest = std::max(highest, event.value);
  }
  CHECK(lowest == 0);
  CHECK(highest == 127);
  CHECK(keys == 6);
}

TEST_CASE("what is learnt is added to a map that keeps its other lines") {
  const TempFolder folder;
  const std::string path = folder.file("map.toml");
  REQUIRE(append_control(path, "device = \"mock\"\n", "cc 1 7", "1.17").has_value());
  REQUIRE(append_control(path, "device = \"other\"\n", "note 1 60", "scene Warm").has_value());
  const auto map = load_control_map(path);
  REQUIRE(map.has_value());
  CHECK(map->device == "mock");
  REQUIRE(map->controls.size() == 2);
  CHECK(map->controls[1].to == "scene Warm");
  CHECK_FALSE(append_control(path, "", "cc 1 7", "1.17").has_value());  // twice
  const std::string phone = folder.file("phone.toml");
  REQUIRE(append_control(phone, map_head(phone, "", 8'000, "a \"rig\".toml"), "/1/tap", "tempo").has_value());
  const auto of_phone = load_control_map(phone);
  REQUIRE(of_phone.has_value());
  CHECK(of_phone->port == 8'000);
  CHECK(of_phone->device.empty());
  CHECK(of_phone->rig == folder.file("a \"rig\".toml"));
}

TEST_CASE("what is learnt of a port without a map makes one beside the rig, and the port is opened with it") {
  const TempFolder folder;
  const std::string rig = folder.file("rig.toml");
  std::ofstream(rig) << kRig;
  const Endpoint port = parse_endpoint("midi:nano 2=1.1", {}).value();
  const LearnPlan plan = plan_learning(port, rig);
  CHECK(plan.map == folder.file("nano_2.toml"));
  CHECK(plan.endpoint == "midi:" + plan.map);
  const auto refuse = [](const std::string&) -> Status { return fail(ErrorCode::kBadInput, "no such fixture"); };
  REQUIRE(!learn_control(plan, "cc 1 7", "Mover 9:Tilt", refuse).has_value());
  CHECK(!std::filesystem::exists(plan.map));
  std::string opened;
  const auto open = [&](const std::string& endpoint) -> Status {
    opened = endpoint;
    return {};
  };
  CHECK(learn_control(plan, "cc 1 7", "Mover 3:Tilt", open).has_value());
  CHECK(opened == plan.endpoint);
  const auto map = load_control_map(plan.map);
  REQUIRE(map.has_value());
  CHECK(map->device == "nano 2");
  CHECK(map->rig == rig);
  REQUIRE(map->controls.size() == 1);
  // The next one goes to the same map.
  const LearnPlan next = plan_learning(parse_endpoint(opened, {}).value(), rig);
  CHECK(next.map == plan.map);
  REQUIRE(!learn_control(next, "cc 1 8", "nothing", refuse).has_value());
  CHECK(load_control_map(plan.map)->controls.size() == 1);
  CHECK(learn_control(next, "note 1 60", "tempo", open).has_value());
  CHECK(load_control_map(plan.map)->controls.size() == 2);
  CHECK(plan_learning(parse_endpoint("osc:8000@127.0.0.1", {}).value(), "").map == "osc-8000.toml");
}

}  // namespace
}  // namespace footlight::tools

// The rules of a bridge for several desks, and its behaviour when desks, synchronisation or an output fail: real
// sockets, the real pump, and a clock that jumps to the next event. Every datagram of a desk is written here, so that
// it may do what no sink of ours does. The numbers of rules of priorities per address (start code 0xDD) are those of
// ETC's list (ETCLabs/sACN, docs/pages/per_address_priority.md).
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <list>
#include <map>
#include <memory>
#include <vector>

#include "drivers/net/artnet_packet.h"
#include "drivers/net/artnet_source.h"
#include "drivers/net/sacn_packet.h"
#include "drivers/net/sacn_port.h"
#include "sim/pump.h"
#include "sim/universes.h"
#include "tests/drivers/net/jumping_waiter.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using testing::enter_private_network;
using testing::FakeClock;
using testing::JumpingWaiter;
using testing::KeepingReceiver;
using testing::must;
using testing::send_bytes;
using testing::stranger;
using Bytes = std::vector<std::uint8_t>;

constexpr DurationNs kFrameNs = kNsPerS / 44;
constexpr DurationNs kClaimAgainNs = 900 * kNsPerMs;
constexpr std::uint32_t kThisMachine = 0x7F00'0001;

// A desk in one universe: repeats its levels at 44 Hz while it is active, and its priorities per address, if it has
// any, every 0.9 s.
struct Desk {
  std::uint8_t number = 0;  // the first octet of its CID
  std::uint8_t priority = kPriorityDefault;
  int universe = 1;
  Bytes levels;
  Bytes claims;  // empty: sends none
  bool talks = true;
  bool sends_claims = true;
  int sync_universe = 0;
  bool force_sync = false;
  std::uint8_t sequence = 0, sync_sequence = 0;
  TimeNs claims_due_ns = 0;
};

struct Received {
  TimeNs at_ns = 0;
  Universe universe = 0;
  Bytes levels;
};

// Universes 1 and 2 come in by sACN, 3 by Art-Net; they are sent as 101 to 103.
struct Bridge {
  FakeClock clock;
  JumpingWaiter waiter{clock};
  std::unique_ptr<Universes> universes = must(Universes::make(std::vector<Universe>{1, 2, 3}));
  std::unique_ptr<SacnSource> in;
  std::unique_ptr<ArtnetSource> artnet_in;
  std::unique_ptr<SacnSink> out;
  std::unique_ptr<SacnSource> listener;
  std::unique_ptr<Pump> pump;
  std::list<Desk> desks;
  Fd wire = must(open_sender({.port_name = "desks"}));
  std::vector<Received> output;

  Bridge() {
    const auto own_senders = std::make_shared<OwnSenders>();
    SacnSourceOptions in_options;
    in_options.name = "sacn:1-2";
    in_options.universes = testing::universes_from(1, 2, 1);
    in_options.kernel_stamps = false;
    in_options.own_senders = own_senders;
    in = must(SacnSource::create(in_options));
    in_options.universes = testing::universes_from(101, 3, 101);
    in_options.own_senders = nullptr;
    listener = must(SacnSource::create(in_options));
    ArtnetSourceOptions artnet_options;
    artnet_options.name = "artnet:3";
    artnet_options.universes = {{3, 3}};
    artnet_options.kernel_stamps = artnet_options.request_names = false;
    artnet_in = must(ArtnetSource::create(artnet_options));
    SacnSinkOptions out_options;
    out_options.name = "sacn:101-103=1-3";
    out_options.universes = testing::universes_from(101, 3, 1);
    out_options.own_senders = own_senders;
    out = must(SacnSink::create(out_options));
    pump = std::make_unique<Pump>(*universes, clock, waiter);
    pump->add_source(*in);
    pump->add_source(*artnet_in);
    pump->add_sink(*out);
    pump->start();
  }

  Desk& add_desk(std::uint8_t priority, Bytes levels, Bytes claims = {}, int universe = 1) {
    Desk& desk = desks.emplace_back();
    desk.number = static_cast<std::uint8_t>(desks.size());
    desk.priority = priority;
    desk.universe = universe;
    desk.levels = std::move(levels);
    desk.claims = std::move(claims);
    return desk;
  }
  void send(Desk& desk, std::uint8_t start_code, const Bytes& slots, bool terminated = false) {
    SacnData data;
    data.cid[0] = desk.number;
    data.source_name = "desk";
    data.priority = desk.priority;
    data.sync_universe = start_code == kStartCodeLevels ? desk.sync_universe : 0;
    data.force_sync = desk.force_sync;
    data.sequence = desk.sequence++;
    data.terminated = terminated;
    data.universe = desk.universe;
    data.start_code = start_code;
    data.slots = slots;
    std::array<std::uint8_t, kSacnDataBytesMax> packet = {};
    const std::size_t size = build_sacn_data(data, packet);
    REQUIRE(send_bytes(wire, sacn_group_ipv4(desk.universe), kSacnPort, std::span(packet).first(size)));
  }
  void claim(Desk& desk, Bytes claims) {
    desk.claims = std::move(claims);
    desk.claims_due_ns = 0;
  }
  void synchronise(Desk& desk) {
    std::array<std::uint8_t, kSacnSyncBytes> packet = {};
    Cid cid = {};
    cid[0] = desk.number;
    build_sacn_sync({cid, desk.sync_sequence++, desk.sync_universe}, packet);
    REQUIRE(send_bytes(wire, sacn_group_ipv4(desk.sync_universe), kSacnPort, packet));
  }

  void run_for(DurationNs duration_ns) {
    const TimeNs end_ns = clock.now_ns() + duration_ns;
    while (clock.now_ns() < end_ns) {
      for (Desk& desk : desks) {
        if (desk.sends_claims && !desk.claims.empty() && clock.now_ns() >= desk.claims_due_ns) {
          send(desk, kStartCodePriorities, desk.claims);
          desk.claims_due_ns = clock.now_ns() + kClaimAgainNs;
        }
        if (desk.talks) send(desk, kStartCodeLevels, desk.levels);
      }
      pump_for(kFrameNs);
    }
  }
  // Runs with silent desks.
  void pump_for(DurationNs duration_ns) {
    waiter.limit_ns = clock.now_ns() + duration_ns;
    while (clock.now_ns() < waiter.limit_ns) {
      pump->step();
      KeepingReceiver frames;
      REQUIRE(testing::drain(*listener, clock.now_ns(), frames));
      for (auto& frame : frames.frames)
        if (frame.view.start_code == kStartCodeLevels && !frame.slots.empty())
          output.push_back({clock.now_ns(), frame.view.universe, std::move(frame.slots)});
    }
  }
  // The newest level received; -1: none yet.
  [[nodiscard]] int level(std::size_t address, Universe universe = 101) const {
    for (auto one = output.rbegin(); one != output.rend(); ++one)
      if (one->universe == universe) return one->levels[address - 1];
    return -1;
  }
  // When a level was first received, from now on; kTimeNever: not within `patience_ns`.
  [[nodiscard]] TimeNs when(std::size_t address, int level_wanted, DurationNs patience_ns) {
    output.clear();
    const TimeNs end_ns = clock.now_ns() + patience_ns;
    while (clock.now_ns() < end_ns && level(address) != level_wanted) run_for(kFrameNs);
    for (const Received& one : output)
      if (one.levels[address - 1] == level_wanted) return one.at_ns;
    return kTimeNever;
  }
};

}  // namespace

// --- Priorities per address

TEST_CASE("rule 1: 0xDD values are never shown as levels") {
  if (!enter_private_network()) return;
  Bridge bridge;
  bridge.add_desk(100, {50, 50}, {200, 199});
  bridge.run_for(3 * kNsPerS);
  REQUIRE_FALSE(bridge.output.empty());
  for (const Received& one : bridge.output) CHECK(one.levels[0] == 50);
}

TEST_CASE("rule 2: priorities per address of one universe have no effect in another") {
  if (!enter_private_network()) return;
  Bridge bridge;
  bridge.add_desk(100, {10}, {200});
  bridge.add_desk(100, {20});
  bridge.add_desk(100, {10}, {}, 2).number = 1;
  bridge.add_desk(100, {20}, {}, 2).number = 2;
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1, 101) == 10);
  CHECK(bridge.level(1, 102) == 20);  // highest level, as before
}

TEST_CASE("rule 3: priorities per address from 1 to 200 rank in this order, and values above 200 are refused") {
  if (!enter_private_network()) return;
  Bridge bridge;
  Desk& first = bridge.add_desk(100, {10}, {200});
  bridge.add_desk(100, {20}, {199});
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1) == 10);
  bridge.claim(first, {255});
  bridge.run_for(kNsPerS);
  CHECK(bridge.level(1) == 10);  // its earlier priorities still apply
  bridge.claim(first, {1});
  bridge.run_for(kNsPerS);
  CHECK(bridge.level(1) == 20);
}

TEST_CASE("rule 4: a level of priority 0 is ignored, even if the others are low") {
  if (!enter_private_network()) return;
  Bridge bridge;
  bridge.add_desk(200, {250}, {0});
  bridge.add_desk(1, {20});
  bridge.run_for(3 * kNsPerS);
  CHECK(bridge.level(1) == 20);
}

TEST_CASE("rule 5: the highest priority wins an address whatever its level, and equal ones show the highest level") {
  if (!enter_private_network()) return;
  Bridge bridge;
  bridge.add_desk(100, {10, 10}, {150, 150});
  Desk& other = bridge.add_desk(200, {250, 5}, {149, 150});
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1) == 10);
  CHECK(bridge.level(2) == 10);
  bridge.claim(other, {150, 150});
  bridge.run_for(kNsPerS);
  CHECK(bridge.level(1) == 250);
}

TEST_CASE("rule 6: addresses past the end of the priorities have 0") {
  if (!enter_private_network()) return;
  Bridge bridge;
  bridge.add_desk(100, {10, 10}, {200});
  bridge.add_desk(1, {20, 20});
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1) == 10);
  CHECK(bridge.level(2) == 20);
}

TEST_CASE("rule 7: a desk without priorities per address has its packets' priority in each") {
  if (!enter_private_network()) return;
  Bridge bridge;
  bridge.add_desk(100, {10, 10}, {110, 130});
  bridge.add_desk(120, {20, 20});
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1) == 20);
  CHECK(bridge.level(2) == 10);
}

TEST_CASE(
    "rules 9, 10 and 16: an address is claimed with a priority and released with 0, to the next highest, at once") {
  if (!enter_private_network()) return;
  Bridge bridge;
  Desk& desk = bridge.add_desk(100, {30}, {0});
  bridge.add_desk(90, {20});
  bridge.add_desk(80, {10});
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1) == 20);
  bridge.claim(desk, {150});
  const TimeNs taken_ns = bridge.clock.now_ns();
  CHECK(bridge.when(1, 30, kNsPerS) == taken_ns);
  bridge.claim(desk, {0});
  const TimeNs given_up_ns = bridge.clock.now_ns();
  CHECK(bridge.when(1, 20, kNsPerS) == given_up_ns);
}

TEST_CASE("rule 11: an address without claims keeps its level, whatever is sent for it") {
  if (!enter_private_network()) return;
  Bridge bridge;
  Desk& desk = bridge.add_desk(100, {30}, {150});
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1) == 30);
  bridge.claim(desk, {0});
  desk.levels = {99};
  bridge.run_for(4 * kNsPerS);
  CHECK(bridge.level(1) == 30);
}

TEST_CASE("rule 13: a new desk's levels wait up to 1.5 s for its priorities if others send theirs") {
  if (!enter_private_network()) return;
  Bridge bridge;
  bridge.add_desk(100, {10}, {100});
  bridge.run_for(2 * kNsPerS);
  SUBCASE("and are never shown if those do not claim them") {
    Desk& desk = bridge.add_desk(150, {250});
    bridge.run_for(kNsPerS);
    bridge.claim(desk, {0});
    bridge.run_for(3 * kNsPerS);
    for (const Received& one : bridge.output) CHECK(one.levels[0] == 10);
  }
  SUBCASE("and use their packets' priority if there are none") {
    const TimeNs came_ns = bridge.clock.now_ns();
    bridge.add_desk(150, {250});
    const DurationNs waited_ns = bridge.when(1, 250, 3 * kNsPerS) - came_ns;
    CHECK(waited_ns >= 1'500 * kNsPerMs);
    CHECK(waited_ns <= 1'500 * kNsPerMs + kFrameNs);
  }
}

TEST_CASE(
    "rule 14: a desk whose priorities stop while its levels continue returns to its packets' priority after 2.5 s") {
  if (!enter_private_network()) return;
  Bridge bridge;
  Desk& desk = bridge.add_desk(50, {10}, {200});
  bridge.add_desk(100, {20});
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1) == 10);
  const TimeNs last_ns = desk.claims_due_ns - kClaimAgainNs;
  desk.sends_claims = false;
  const DurationNs held_ns = bridge.when(1, 20, 4 * kNsPerS) - last_ns;
  CHECK(held_ns >= 2'500 * kNsPerMs);
  CHECK(held_ns <= 2'500 * kNsPerMs + kFrameNs);
}

TEST_CASE(
    "rule 15: a desk whose levels stop is removed after 2.5 s although its priorities continue, and at once when it "
    "ends") {
  if (!enter_private_network()) return;
  Bridge bridge;
  Desk& desk = bridge.add_desk(100, {10}, {200});
  bridge.add_desk(100, {20});
  bridge.run_for(2 * kNsPerS);
  CHECK(bridge.level(1) == 10);
  const TimeNs stopped_ns = bridge.clock.now_ns();
  desk.talks = false;
  SUBCASE("it is silent") {
    const DurationNs held_ns = bridge.when(1, 20, 4 * kNsPerS) - stopped_ns;
    CHECK(held_ns >= 2'500 * kNsPerMs - kFrameNs);
    CHECK(held_ns <= 2'500 * kNsPerMs);
  }
  SUBCASE("it sends its end") {
    desk.sends_claims = false;
    for (int i = 0; i < 3; ++i) bridge.send(desk, kStartCodeLevels, desk.levels, true);
    CHECK(bridge.when(1, 20, kNsPerS) == stopped_ns);
  }
}

// --- Synchronisation (E1.31-2018 sections 6.2.6 and 11)

TEST_CASE("synchronised levels are sent with their synchronisation packet and not before") {
  if (!enter_private_network()) return;
  Bridge bridge;
  Desk& desk = bridge.add_desk(100, {10});
  desk.sync_universe = 7000;
  bridge.run_for(kFrameNs);  // nothing has been synchronised yet: shown, and the group of 7000 is joined
  bridge.synchronise(desk);
  bridge.run_for(kFrameNs);
  bridge.synchronise(desk);
  bridge.pump_for(kFrameNs);
  CHECK(bridge.level(1) == 10);
  desk.levels = {20};
  bridge.run_for(10 * kFrameNs);
  CHECK(bridge.level(1) == 10);
  bridge.synchronise(desk);
  const TimeNs set_free_ns = bridge.clock.now_ns();
  bridge.output.clear();
  bridge.pump_for(kFrameNs);
  REQUIRE(bridge.level(1) == 20);
  CHECK(bridge.output.front().at_ns == set_free_ns);
}

TEST_CASE(
    "2.5 s after the last synchronisation packet levels continue if the desk's flag allows, else they stay frozen") {
  if (!enter_private_network()) return;
  for (const bool goes_on : {true, false}) {
    CAPTURE(goes_on);
    Bridge bridge;
    Desk& desk = bridge.add_desk(100, {10});
    desk.sync_universe = 7000;
    desk.force_sync = goes_on;
    for (int i = 0; i < 3; ++i) {
      bridge.run_for(kFrameNs);
      bridge.synchronise(desk);
    }
    const TimeNs last_ns = bridge.clock.now_ns();
    bridge.pump_for(1);
    CHECK(bridge.level(1) == 10);
    desk.levels = {20};
    const TimeNs shown_ns = bridge.when(1, 20, 6 * kNsPerS);
    if (goes_on) {
      CHECK(shown_ns - last_ns >= 2'500 * kNsPerMs);
      CHECK(shown_ns - last_ns <= 2'500 * kNsPerMs + kFrameNs);
    } else {
      CHECK(shown_ns == kTimeNever);
      bridge.synchronise(desk);
      bridge.pump_for(kFrameNs);
      CHECK(bridge.level(1) == 20);
    }
  }
}

TEST_CASE("a desk that ends while its levels wait for synchronisation is replaced at once") {
  if (!enter_private_network()) return;
  Bridge bridge;
  Desk& desk = bridge.add_desk(150, {10});
  bridge.add_desk(100, {20});
  desk.sync_universe = 7000;
  for (int i = 0; i < 3; ++i) {
    bridge.run_for(kFrameNs);
    bridge.synchronise(desk);
  }
  bridge.pump_for(1);
  CHECK(bridge.level(1) == 10);
  desk.levels = {30};
  bridge.run_for(3 * kFrameNs);
  desk.talks = false;
  bridge.send(desk, kStartCodeLevels, desk.levels, true);
  const TimeNs ended_ns = bridge.clock.now_ns();
  CHECK(bridge.when(1, 20, kNsPerS) == ended_ns);
  for (const Received& one : bridge.output) CHECK(one.levels[0] != 30);
}

// --- Art-Net

TEST_CASE("two Art-Net desks are merged by the highest level until one has been silent for ten seconds") {
  if (!enter_private_network()) return;
  Bridge bridge;
  const Fd first = stranger(0x7F00'0002, 0), second = stranger(0x7F00'0003, 0);
  const auto send = [&](const Fd& from, const Bytes& levels) {
    ArtnetDmx dmx;
    dmx.port_address = artnet_port_address(3);
    dmx.slots = levels;
    Bytes packet(kArtnetDmxBytesMax);
    packet.resize(build_artnet_dmx(dmx, packet));
    REQUIRE(send_bytes(from, kThisMachine, kArtnetPort, packet));
  };
  send(first, {10, 200});
  send(second, {100, 20});
  bridge.pump_for(kFrameNs);
  CHECK(bridge.level(1, 103) == 100);
  CHECK(bridge.level(2, 103) == 200);
  // Four seconds between two frames of unchanged levels are allowed by the protocol.
  for (int i = 0; i < 3; ++i) {
    bridge.pump_for(4 * kNsPerS - kFrameNs);
    CHECK(bridge.level(1, 103) == (i < 2 ? 100 : 10));  // the second desk's last frame was at the start
    send(first, {10, 200});
    bridge.pump_for(kFrameNs);
    CHECK(bridge.level(2, 103) == 200);
  }
  CHECK(bridge.level(1, 103) == 10);
}

// --- Outputs

TEST_CASE("when the interface of an sACN output fails, its standby takes over at once, until it is back") {
  if (!enter_private_network()) return;
  if (!testing::add_interface("stage", "10.9.0.1")) return;
  FakeClock clock;
  JumpingWaiter waiter(clock);
  const auto universes = must(Universes::make(std::vector<Universe>{1}));
  const auto own_senders = std::make_shared<OwnSenders>();
  SacnSourceOptions in_options;
  in_options.name = "sacn:1";
  in_options.universes = {{1, 1}};
  in_options.interface_names = {"lo"};
  in_options.kernel_stamps = false;
  in_options.own_senders = own_senders;
  const auto in = must(SacnSource::create(in_options));
  SacnSourceOptions listener_options;
  listener_options.name = "listener of the standby";
  listener_options.universes = {{101, 1}};
  listener_options.addresses = {"127.0.0.1"};
  const auto listener = must(SacnSource::create(listener_options));
  SacnSinkOptions main_options;
  main_options.name = "main";
  main_options.universes = {{101, 1}};
  main_options.interface_names = {"stage"};
  main_options.own_senders = own_senders;
  const auto main_sink = must(SacnSink::create(main_options));
  SacnSinkOptions standby_options = main_options;
  standby_options.name = "standby";
  standby_options.interface_names = {};
  standby_options.addresses = {"127.0.0.1"};
  const auto standby = must(SacnSink::create(standby_options));
  SacnSinkOptions desk_options;
  desk_options.name = "desk";
  desk_options.universes = {{1, 1}};
  desk_options.interface_names = {"lo"};
  const auto desk = must(SacnSink::create(desk_options));
  Pump pump(*universes, clock, waiter);
  pump.add_source(*in);
  pump.add_sink(*main_sink);
  pump.add_sink(*standby, {.standby_for = main_sink.get()});
  pump.start();

  const auto step = [&](std::uint8_t level) {
    const Bytes levels(4, level);
    FrameView frame;
    frame.universe = 1;
    frame.slots = levels;
    REQUIRE(desk->send(clock.now_ns(), {&frame, 1}).has_value());
    waiter.limit_ns = clock.now_ns() + kFrameNs;
    KeepingReceiver output;
    while (clock.now_ns() < waiter.limit_ns) {
      pump.step();
      REQUIRE(testing::drain(*listener, clock.now_ns(), output));
    }
    std::vector<int> levels_heard;
    for (const auto& one : output.frames)
      if (!one.view.terminated && !one.slots.empty()) levels_heard.push_back(one.slots[0]);
    return levels_heard;
  };
  for (std::uint8_t level = 1; level <= 20; ++level) REQUIRE(step(level).empty());
  CHECK(main_sink->state() == PortState::kWorking);
  testing::remove_interface("stage");
  for (std::uint8_t level = 21; level <= 40; ++level) {
    CAPTURE(static_cast<int>(level));
    const auto output = step(level);
    REQUIRE_FALSE(output.empty());  // the frame that the main could not send
    CHECK(output.back() == level);
  }
  REQUIRE(testing::add_interface("stage", "10.9.0.1"));
  for (std::uint8_t level = 41; level <= 140; ++level) (void)step(level);  // within its pause between two attempts
  CHECK(main_sink->state() == PortState::kWorking);
  for (std::uint8_t level = 141; level <= 150; ++level) CHECK(step(level).empty());
}

}  // namespace footlight::drivers

// The hand alone and in a pump, with an injected clock: who has a slot, what a fade is worth, what a blackout leaves.
#include "sim/hand.h"

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "sim/pump.h"
#include "tests/sim/allocation_count.h"
#include "tests/support/fake_ports.h"

using namespace footlight;
using footlight::testing::FakeClock;
using footlight::testing::FakeSink;
using footlight::testing::FakeSource;
using footlight::testing::FakeWaiter;

namespace {

HandLevel level(Universe universe, Address address, std::uint32_t value) {
  HandLevel level;
  level.universe = universe;
  level.slots[0] = static_cast<std::uint16_t>(address - 1);
  level.value = value;
  return level;
}

HandLevel pair(Address coarse, Address fine, std::uint32_t value) {
  HandLevel level;
  level.count = 2;
  level.slots = {static_cast<std::uint16_t>(coarse - 1), static_cast<std::uint16_t>(fine - 1)};
  level.value = value;
  return level;
}

HandCommand set(std::vector<HandLevel> levels, DurationNs over_ns = 0) {
  return {.action = HandAction::kSet, .over_ns = over_ns, .levels = std::move(levels)};
}
HandCommand only(HandAction action, DurationNs over_ns = 0) {
  return {.action = action, .over_ns = over_ns, .levels = {}};
}
HandCommand release(std::vector<HandLevel> levels) {
  return {.action = HandAction::kRelease, .levels = std::move(levels)};
}

// A pump with a hand and a desk of consoles.
struct World {
  FakeClock clock;
  FakeWaiter waiter{clock};
  std::shared_ptr<Universes> universes = std::make_shared<Universes>();
  Pump pump{universes, clock, waiter};
  HandSource hand{universes};
  FakeSource desk{waiter, "desk", {1, 2}};
  FakeSink sink{waiter, "dongle", {1}};

  World() {
    pump.add_source(desk);
    pump.add_source(hand, {.may_override = true});
    pump.add_sink(sink);
    pump.start();
  }
  ~World() { pump.stop(); }
  void run_until(TimeNs time_ns) {
    waiter.at(time_ns, [this] { waiter.interrupt(); });
    while (clock.now_ns() < time_ns) pump.step();
  }
  void run_for(DurationNs duration_ns) { run_until(clock.now_ns() + duration_ns); }
  void apply(const HandCommand& command) {
    const auto applied = hand.apply(command, clock.now_ns());
    REQUIRE_MESSAGE(applied.has_value(), (applied ? "" : applied.error().message));
    run_for(1);
  }
  void give(std::uint8_t value, std::uint8_t priority = kPriorityDefault) {
    desk.give(1, value, priority);
    run_for(1);
  }
  int at(Address address, Universe universe = 1) const {
    Slots levels;
    FrameStamp stamp;
    universes->snapshot(universes->index_of(universe), levels, stamp);
    return levels[static_cast<std::size_t>(address - 1)];
  }
  std::vector<std::string> winners() const {
    std::vector<std::string> names;
    const PumpStatus status = pump.status();
    for (const SenderStatus& sender : status.universes[0].senders)
      if (sender.wins) names.push_back(sender.name);
    return names;
  }
};

}  // namespace

TEST_CASE("only the slots that were set belong to the hand, a released slot is the console's again") {
  World world;
  world.give(10);
  world.apply(set({level(1, 17, 255), level(1, 18, 0)}));
  CHECK(world.at(17) == 255);
  CHECK(world.at(18) == 0);  // a priority above 100 wins with a low level, too
  CHECK(world.at(16) == 10);
  CHECK(world.winners() == std::vector<std::string>{"by hand", "desk"});
  world.give(20);
  CHECK(world.at(17) == 255);
  CHECK(world.at(16) == 20);
  world.apply(release({level(1, 17, 0)}));
  CHECK(world.at(17) == 20);
  CHECK(world.at(18) == 0);
  world.apply(only(HandAction::kReleaseAll));
  CHECK(world.at(18) == 20);
  CHECK(world.winners() == std::vector<std::string>{"desk"});
  CHECK(world.pump.status().universes[0].senders.size() == 1);
  CHECK(unaccounted(world.pump.status().universes[0]) == 0);
}

TEST_CASE("a console with a higher priority than the hand has the slot") {
  World world;
  world.give(10, 180);
  world.apply(set({level(1, 17, 255)}));
  CHECK(world.at(17) == 10);
  HandCommand strong = set({level(1, 17, 99)});
  strong.priority = 190;
  world.apply(strong);
  CHECK(world.at(17) == 99);
}

TEST_CASE("without another sender a released slot keeps its level") {
  World world;
  world.apply(set({level(1, 17, 200)}));
  world.apply(only(HandAction::kReleaseAll));
  CHECK(world.at(17) == 200);
}

TEST_CASE("a fade is the nearest integer to the exact fraction, for any ends, times and durations") {
  std::mt19937_64 random(7);
  __extension__ using Wide = __int128;
  for (int i = 0; i < 20'000; ++i) {
    const int bytes = 1 + static_cast<int>(random() % 4);
    const std::uint64_t range = std::uint64_t{hand_value_max(bytes)} + 1;
    const auto from = static_cast<std::uint32_t>(random() % range);
    const auto to = static_cast<std::uint32_t>(random() % range);
    const auto over = static_cast<DurationNs>(1 + random() % static_cast<std::uint64_t>(kHandFadeMaxNs));
    const auto elapsed = static_cast<DurationNs>(random() % (static_cast<std::uint64_t>(over) + 1));
    const Wide value = faded_value(from, to, elapsed, over);
    const Wide exact = Wide{from} * over + (Wide{to} - from) * elapsed;  // times over
    const Wide twice = 2 * (value * over - exact);
    REQUIRE(twice <= over);
    REQUIRE(twice > -over);  // halves are rounded up
  }
  CHECK(faded_value(0, 255, 0, 1) == 0);
  CHECK(faded_value(0, 255, 1, 1) == 255);
  CHECK(faded_value(std::numeric_limits<std::uint32_t>::max(), 0, kHandFadeMaxNs, kHandFadeMaxNs) == 0);
}

TEST_CASE("a fade is sent 44 times a second at the levels of those times, and ends exactly at its time") {
  World world;
  world.sink.sent.clear();
  const TimeNs start_ns = world.clock.now_ns();
  REQUIRE(world.hand.apply(set({level(1, 1, 255)}, 3 * kNsPerS), start_ns).has_value());
  world.run_for(4 * kNsPerS);
  REQUIRE(world.sink.sent.size() > 130);
  CHECK(world.sink.sent.size() <= 3 * kHandFadeRateHz + 2);
  for (const FakeSink::Sent& sent : world.sink.sent) {
    const DurationNs elapsed_ns = sent.time_ns - start_ns;
    CHECK(sent.levels[0] == static_cast<int>(faded_value(0, 255, elapsed_ns, 3 * kNsPerS)));
  }
  CHECK(world.sink.sent.back().time_ns == start_ns + 3 * kNsPerS);
  CHECK(world.sink.sent.back().levels[0] == 255);
  CHECK(world.hand.fade_count() == 0);
}

TEST_CASE("a poll that comes late gives the level of its own time, and no lateness adds up") {
  World world;
  world.waiter.late_by_ns = 3'333'333;
  world.sink.sent.clear();
  const TimeNs start_ns = world.clock.now_ns();
  REQUIRE(world.hand.apply(set({level(1, 1, 255)}, kNsPerS), start_ns).has_value());
  world.run_for(2 * kNsPerS);
  for (const FakeSink::Sent& sent : world.sink.sent) {
    const DurationNs elapsed_ns = std::min<DurationNs>(sent.time_ns - start_ns, kNsPerS);
    CHECK(sent.levels[0] == static_cast<int>(faded_value(0, 255, elapsed_ns, kNsPerS)));
  }
  CHECK(world.sink.sent.back().time_ns <= start_ns + kNsPerS + world.waiter.late_by_ns);
  CHECK(world.sink.sent.back().levels[0] == 255);
}

TEST_CASE("nothing wakes the pump while nothing fades") {
  World world;
  world.apply(set({level(1, 1, 255)}));
  CHECK(world.hand.next_deadline_ns() == kTimeNever);
  world.apply(set({level(1, 1, 0)}, kNsPerS));
  CHECK(world.hand.next_deadline_ns() < world.clock.now_ns() + kNsPerS / kHandFadeRateHz + 1);
  world.run_for(2 * kNsPerS);
  CHECK(world.hand.next_deadline_ns() == kTimeNever);
  const std::size_t sent = world.sink.sent.size();
  world.run_for(60 * kNsPerS);
  CHECK(world.sink.sent.size() == sent);
  CHECK(world.at(1) == 0);
}

TEST_CASE("a fade starts from the console's level, and a new one from the level of that moment") {
  World world;
  world.give(100);
  world.apply(set({level(1, 1, 200)}, 10 * kNsPerS));
  CHECK(world.at(1) == 100);
  world.run_for(5 * kNsPerS);
  CHECK(world.at(1) == doctest::Approx(150).epsilon(0.01));
  const int before = world.at(1);
  world.apply(set({level(1, 1, 0)}, 10 * kNsPerS));
  CHECK(world.at(1) <= before);
  CHECK(world.at(1) >= before - 2);
  world.run_for(11 * kNsPerS);
  CHECK(world.at(1) == 0);
  CHECK(world.hand.fade_count() == 0);
}

TEST_CASE("a number in two slots fades as one: the bytes never contradict each other") {
  World world;
  world.apply(set({pair(3, 4, 0x12FE)}));
  REQUIRE(world.hand.apply(set({pair(3, 4, 0x1302)}, kNsPerS), world.clock.now_ns()).has_value());
  int before = 0x12FE;
  for (int i = 0; i < 50; ++i) {
    world.run_for(25 * kNsPerMs);
    const int value = world.at(3) * 256 + world.at(4);
    CHECK(value >= before);
    CHECK(value <= 0x1302);
    before = value;
  }
  CHECK(before == 0x1302);
}

TEST_CASE("a level that is set during a fade stays, the rest of the command fades on") {
  World world;
  world.apply(set({level(1, 1, 255), level(1, 2, 255)}, kNsPerS));
  world.run_for(kNsPerS / 2);
  world.apply(set({level(1, 1, 7)}));
  world.run_for(2 * kNsPerS);
  CHECK(world.at(1) == 7);
  CHECK(world.at(2) == 255);
}

TEST_CASE("a place on a wheel is set at once by a fade") {
  World world;
  HandLevel gobo = level(1, 5, 90);
  gobo.jumps = true;
  world.apply(set({gobo, level(1, 6, 90)}, kNsPerS));
  CHECK(world.at(5) == 90);
  CHECK(world.at(6) < 5);
}

TEST_CASE("blackout is above every console, and when it ends everything is as the senders say") {
  World world;
  world.give(10, kPriorityMax);
  world.apply(set({level(1, 17, 255)}));
  world.apply(only(HandAction::kBlackout));
  CHECK(world.at(1) == 0);
  CHECK(world.at(17) == 0);
  CHECK(world.winners() == std::vector<std::string>{"blackout"});
  world.give(33, kPriorityMax);
  CHECK(world.at(1) == 0);
  HandCommand strong = set({level(1, 18, 44)});
  strong.priority = kPriorityMax;
  world.apply(strong);
  CHECK(world.at(18) == 0);
  world.apply(only(HandAction::kLift));
  CHECK(world.at(1) == 33);
  CHECK(world.at(18) == 44);
  CHECK_FALSE(world.hand.blacked_out());
  CHECK(unaccounted(world.pump.status().universes[0]) == 0);
}

TEST_CASE("slots that no sender has get the look from before the blackout back") {
  World world;
  world.give(10);
  world.desk.end(1);
  world.run_for(1);
  REQUIRE(world.at(5) == 10);
  world.apply(only(HandAction::kBlackout));
  CHECK(world.at(5) == 0);
  world.apply(only(HandAction::kLift));
  CHECK(world.at(5) == 10);
  CHECK(world.pump.status().universes[0].senders.empty());
}

TEST_CASE("a blackout of some slots leaves the others alone, and grows by further ones") {
  World world;
  world.give(10);
  world.apply({.action = HandAction::kBlackout, .levels = {level(1, 3, 0), level(1, 4, 255)}});
  CHECK(world.at(3) == 0);
  CHECK(world.at(4) == 255);  // an inverted dimmer is dark at 255
  CHECK(world.at(5) == 10);
  world.apply({.action = HandAction::kBlackout, .levels = {level(1, 5, 0)}});
  CHECK(world.at(3) == 0);
  CHECK(world.at(5) == 0);
  CHECK(world.hand.blacked_out());
  world.apply(only(HandAction::kLift));
  CHECK(world.at(3) == 10);
  CHECK(world.at(4) == 10);
}

TEST_CASE("a blackout that begins in the moment in which another ends leaves no gap") {
  World world;
  world.give(10);
  world.apply(only(HandAction::kBlackout));
  REQUIRE(world.hand.apply(only(HandAction::kLift), world.clock.now_ns()).has_value());
  world.apply({.action = HandAction::kBlackout, .levels = {level(1, 3, 0)}});
  CHECK(world.at(3) == 0);
  CHECK(world.at(4) == 10);
  world.apply(only(HandAction::kLift));
  CHECK(world.at(3) == 10);
}

TEST_CASE("a hold that is not renewed in time ends in a blackout, which renewing does not end") {
  World world;
  world.give(10);
  world.apply(only(HandAction::kHold, kNsPerS));
  for (int i = 0; i < 8; ++i) {
    world.run_for(kNsPerS / 2);
    world.give(10);
    world.apply(only(HandAction::kRenew, kNsPerS));
  }
  CHECK(world.at(1) == 10);
  const TimeNs renewed_ns = world.clock.now_ns() - 1;
  world.sink.sent.clear();
  world.run_for(2 * kNsPerS);
  CHECK(world.at(1) == 0);
  CHECK(world.sink.sent.front().time_ns == renewed_ns + kNsPerS);
  CHECK_FALSE(world.hand.apply(only(HandAction::kRenew, kNsPerS), world.clock.now_ns()).has_value());
  CHECK(world.hand.blacked_out());
  world.apply(only(HandAction::kLift));
  CHECK_FALSE(world.hand.blacked_out());
}

TEST_CASE("a blackout and a release of a rig larger than the bridge reach the universes that are there") {
  World world;
  world.give(10);
  const HandCommand dark{.action = HandAction::kBlackout, .levels = {level(77, 1, 0), level(1, 3, 0)}};
  const auto slots = world.hand.apply(dark, world.clock.now_ns());
  REQUIRE(slots.has_value());
  CHECK(*slots == 1);
  world.run_for(1);
  CHECK(world.at(3) == 0);
  CHECK(world.at(4) == 10);
  world.apply(only(HandAction::kLift));
  world.apply(set({level(1, 5, 99)}));
  world.apply(release({level(77, 1, 0), level(1, 5, 0)}));
  CHECK(world.at(5) == 10);
  const auto none = world.hand.apply({.action = HandAction::kBlackout, .levels = {level(77, 1, 0)}}, 0);
  REQUIRE_FALSE(none.has_value());
  CHECK(none.error().message.find("start the bridge with") != std::string::npos);
  CHECK_FALSE(world.hand.blacked_out());
}

TEST_CASE("a slot that is set and released during a blackout has that level when the blackout ends") {
  World world;
  world.apply(set({level(1, 5, 255)}));
  world.apply(only(HandAction::kBlackout));
  world.apply(set({level(1, 5, 0)}));
  world.apply(release({level(1, 5, 0)}));
  world.apply(only(HandAction::kLift));
  CHECK(world.at(5) == 0);
}

TEST_CASE("a slot that is set and released in one tick keeps the level, and is released") {
  World world;
  world.apply(set({level(1, 5, 255), level(1, 6, 255)}));
  REQUIRE(world.hand.apply(set({level(1, 5, 0)}), world.clock.now_ns()).has_value());
  REQUIRE(world.hand.apply(release({level(1, 5, 0)}), world.clock.now_ns()).has_value());
  CHECK(world.hand.held().size() == 1);
  world.run_for(2);
  CHECK(world.at(5) == 0);
  CHECK(world.at(6) == 255);
  world.give(33);
  CHECK(world.at(5) == 33);
  CHECK(world.at(6) == 255);
}

TEST_CASE("a second hold is refused while another one is active, and does not renew it") {
  World world;
  world.apply(only(HandAction::kHold, kNsPerS));
  const auto second = world.hand.apply(only(HandAction::kHold, 100 * kNsPerS), world.clock.now_ns());
  REQUIRE_FALSE(second.has_value());
  CHECK(second.error().message.find("footlight blackout off") != std::string::npos);
  world.run_for(2 * kNsPerS);
  CHECK(world.hand.blacked_out());
  world.apply(only(HandAction::kLift));
  world.apply(only(HandAction::kHold, kNsPerS));
  CHECK(world.hand.holding());
}

TEST_CASE("a hand that the merge displaced claims only its own slots when it comes back") {
  World world;
  world.apply(set({level(1, 17, 255)}));
  for (SenderId sender = 1; sender <= kSendersPerUniverseMax; ++sender) {
    world.desk.sender = sender;
    world.give(10, 180);
  }
  REQUIRE(world.pump.status().universes[0].merge.senders_displaced == 1);
  world.desk.end(1);
  world.run_for(1);
  for (SenderId sender = 1; sender < kSendersPerUniverseMax; ++sender) {
    world.desk.sender = sender;
    world.give(10, 120);
  }
  world.apply(set({level(1, 17, 254)}));
  CHECK(world.at(17) == 254);
  CHECK(world.at(16) == 10);
}

TEST_CASE("a blackout that is there before the first tick comes before the frames that wait in a source") {
  FakeClock clock;
  FakeWaiter waiter{clock};
  const auto universes = std::make_shared<Universes>();
  Pump pump{universes, clock, waiter};
  HandSource hand{universes};
  FakeSource desk{waiter, "desk", {1}};
  FakeSink sink{waiter, "dongle", {1}};
  pump.add_source(desk);
  pump.add_source(hand, {.may_override = true});
  pump.add_sink(sink);
  desk.give(1, 200);
  desk.give(1, 201);  // the first one is passed on when this one comes
  REQUIRE(hand.apply(only(HandAction::kBlackout), clock.now_ns()).has_value());
  struct Highest final : FrameReceiver {
    explicit Highest(const Universes& all) : universes(all) {}
    void receive(const FrameView& /*frame*/) override {
      Slots levels;
      FrameStamp stamp;
      universes.snapshot(0, levels, stamp);
      level = std::max<int>(level, levels[0]);
    }
    const Universes& universes;
    int level = 0;
  } highest(*universes);
  pump.add_tap(highest);
  pump.start();
  waiter.at(clock.now_ns() + 1, [&] { waiter.interrupt(); });
  for (int i = 0; i < 3; ++i) pump.step();
  Slots levels;
  FrameStamp stamp;
  universes->snapshot(0, levels, stamp);
  CHECK(levels[0] == 0);
  CHECK(highest.level == 0);
  for (const FakeSink::Sent& sent : sink.sent) CHECK(sent.levels[0] == 0);
  pump.stop();
  pump.remove_tap(highest);
}

TEST_CASE("a command with an error changes nothing, and its message names what is wrong") {
  World world;
  const auto refused = [&](const HandCommand& command) {
    const auto applied = world.hand.apply(command, world.clock.now_ns());
    REQUIRE_FALSE(applied.has_value());
    return applied.error().message;
  };
  CHECK(refused(set({level(1, 1, 5), level(77, 1, 5)})).find("universe 77") != std::string::npos);
  CHECK(refused(set({level(1, 1, 256)})).find("256") != std::string::npos);
  CHECK(refused(set({level(1, 513, 5)})).find("1 to 512") != std::string::npos);
  CHECK(refused(set({})).find("no slot") != std::string::npos);
  CHECK(refused(set({level(1, 1, 5)}, kHandFadeMaxNs + 1)).find("24 hours") != std::string::npos);
  HandCommand loud = set({level(1, 1, 5)});
  loud.priority = 201;
  CHECK(refused(loud).find("1 to 200") != std::string::npos);
  CHECK(refused(only(HandAction::kRenew, kNsPerS)).find("no hold") != std::string::npos);
  CHECK(refused(only(HandAction::kHold, 1)).find("200ms") != std::string::npos);
  CHECK(world.hand.held().empty());
  CHECK(world.at(1) == 0);
}

TEST_CASE("a network sender with the priority of a blackout is refused") {
  World world;
  world.give(10, kPriorityOverride);
  CHECK(world.at(1) == 0);
  CHECK(world.pump.status().universes[0].merge.refused_priority == 1);
}

TEST_CASE("after a move to another buffer a blackout covers the new universes, and lost ones are forgotten") {
  World world;
  world.apply(set({level(2, 1, 50), level(1, 1, 60)}));
  world.apply(only(HandAction::kBlackout));
  const std::vector<Universe> numbers = {1, 20};
  const auto next = std::make_shared<Universes>(numbers);
  world.pump.move_to(next, {});
  world.pump.remove_source(world.hand);
  world.hand.move_to(next);
  world.pump.add_source(world.hand, {.may_override = true});
  world.universes = next;
  FakeSource other(world.waiter, "other", {20});
  world.pump.add_source(other);
  other.give(20, 99);
  world.run_for(1);
  CHECK(world.at(1, 20) == 0);
  CHECK(world.at(1) == 0);
  world.apply(only(HandAction::kLift));
  CHECK(world.at(1, 20) == 99);
  CHECK(world.at(1) == 60);
  CHECK(world.hand.held().size() == 1);
  world.pump.remove_source(other);
}

TEST_CASE("setting and fading a universe that was used before allocates nothing, nor does the pump") {
  World world;
  world.sink.keep_history = false;
  std::vector<HandLevel> levels;
  for (Address address = 1; address <= 60; ++address) levels.push_back(level(1, address, 255));
  const HandCommand up = set(levels, kNsPerS);
  for (HandLevel& each : levels) each.value = 0;
  const HandCommand down = set(levels, kNsPerS);
  REQUIRE(world.hand.apply(up, world.clock.now_ns()).has_value());
  world.run_for(2 * kNsPerS);
  world.waiter.at(world.clock.now_ns() + 3 * kNsPerS, [&] { world.waiter.interrupt(); });
  const std::uint64_t before = footlight::testing::allocation_count();
  const bool applied = world.hand.apply(down, world.clock.now_ns()).has_value();
  for (int i = 0; i < 40; ++i) world.pump.step();
  CHECK(footlight::testing::allocation_count() == before);
  CHECK(applied);
}

TEST_CASE("three hundred thousand fades of a whole rig at once end at their levels") {
  const std::vector<Universe> numbers = universe_range(1, 64);
  const auto universes = std::make_shared<Universes>(numbers);
  HandSource hand(universes);
  std::vector<HandLevel> levels;
  for (const Universe universe : numbers)
    for (Address address = 1; address <= kSlotCountMax; ++address) levels.push_back(level(universe, address, 200));
  TimeNs now_ns = kNsPerS;
  for (int i = 0; i < 10; ++i) {
    for (HandLevel& each : levels) each.value = static_cast<std::uint32_t>(200 + i);
    REQUIRE(hand.apply(set(levels, kNsPerS), now_ns).has_value());
    now_ns += 10 * kNsPerMs;
  }
  CHECK(hand.fade_count() == 2 * levels.size());  // those of the last two commands; replaced ones are dropped
  REQUIRE(hand.apply(only(HandAction::kLift), now_ns + 2 * kNsPerS).has_value());
  CHECK(hand.fade_count() == 0);
  for (const HandSource::Held& held : hand.held()) REQUIRE(held.level == 209);
}

TEST_CASE("a reader gets what the hand has: over its own levels by priority, and the blackout apart from it") {
  World world;
  HandShown shown;
  world.hand.show_in(&shown);
  const std::array<Universe, 2> rig{1, 3};
  std::array<std::uint8_t, 2 * kSlotCountMax> levels{};
  const auto look = [&](bool dark) {
    levels.fill(100);
    shown.take();
    dark ? shown.darken(rig, levels) : shown.overlay(rig, levels, kPriorityDefault);
  };
  HandCommand command = set({level(1, 1, 9), level(3, 512, 8), level(2, 1, 7)});
  world.apply(command);
  look(false);
  CHECK(levels[0] == 9);
  CHECK(levels[1] == 100);
  CHECK(levels[2 * kSlotCountMax - 1] == 8);
  CHECK(shown.held_count() == 3);
  command = set({level(1, 1, 5), level(1, 2, 120), level(1, 3, 5)});
  command.priority = kPriorityDefault;  // that of the levels below
  world.apply(command);
  command.priority = kPriorityDefault - 1;
  command.levels = {level(1, 4, 5)};
  world.apply(command);
  look(false);
  CHECK(levels[0] == 100);
  CHECK(levels[1] == 120);
  CHECK(levels[2] == 100);
  CHECK(levels[3] == 100);
  world.apply(only(HandAction::kBlackout));
  look(true);
  CHECK(shown.dark());
  CHECK(levels[0] == 0);
  CHECK(levels[kSlotCountMax + 17] == 0);
  world.apply(only(HandAction::kLift));
  look(true);
  CHECK(!shown.dark());
  CHECK(levels[0] == 100);
  world.apply(only(HandAction::kReleaseAll));
  look(false);
  CHECK(!shown.any());
  CHECK(levels[2 * kSlotCountMax - 1] == 100);
}

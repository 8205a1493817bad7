#include "sim/pump.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/sim/allocation_count.h"
#include "tests/sim/pump_world.h"
#include "tests/support/fake_ports.h"

using namespace footlight;
using footlight::testing::FakeClock;
using footlight::testing::FakeSink;
using footlight::testing::FakeSource;
using footlight::testing::FakeWaiter;
using footlight::testing::kFrameNs;
using footlight::testing::make_desk;
using footlight::testing::World;

namespace {

std::vector<int> levels_sent(const FakeSink& sink) {
  std::vector<int> levels;
  for (const FakeSink::Sent& sent : sink.sent)
    for (const int level : sent.levels) levels.push_back(level);
  return levels;
}

}  // namespace

TEST_CASE("a frame reaches buffer and sink in the wake-up in which it arrives") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "dongle", {1});
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  const TimeNs at_ns = world.now_ns() + 12'345;
  world.waiter.at(at_ns, [&] { source.give(1, 77); });
  world.run_until(at_ns + 1);
  CHECK(world.level(1) == 77);
  REQUIRE(sink.sent.size() == 1);
  CHECK(sink.sent[0] == FakeSink::Sent{at_ns, {1}, {77}});
}

TEST_CASE("of several frames of one sender in one wake-up a sink without a cap gets each, in order") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "artnet", {1}), capped(world.waiter, "dongle", {1}, 40.0);
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().add_sink(capped);
  world.pump().start();
  const TimeNs at_ns = world.now_ns();
  for (const int level : {10, 20, 30}) source.give(1, static_cast<std::uint8_t>(level));
  world.run_for(kNsPerMs);
  CHECK(levels_sent(sink) == std::vector<int>{10, 20, 30});
  for (const FakeSink::Sent& sent : sink.sent) CHECK(sent.time_ns == at_ns);
  CHECK(levels_sent(capped) == std::vector<int>{30});
  const PumpStatus status = world.pump().status();
  CHECK(status.universes[0].merge.frames_shown == 3);
  CHECK(status.universes[0].writes == 3);
  CHECK(status.ports[1].frames == 3);
  CHECK(status.ports[1].replaced == 0);
  CHECK(status.ports[1].latency.count == 3);
  CHECK(status.ports[2].frames == 1);
  CHECK(status.ports[2].replaced == 2);
  CHECK(status.ports[2].snapshots == 3);
}

TEST_CASE("waiting rounds are sent as rounds: one call each with every universe") {
  World world;
  FakeSource source(world.waiter, "desk", universe_range(1, 9));
  FakeSink sink(world.waiter, "artnet", universe_range(1, 9));
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  for (int round = 1; round <= 4; ++round)
    for (Universe universe = 1; universe <= 9; ++universe)
      source.give(universe, static_cast<std::uint8_t>(round * 10 + universe));
  world.run_for(kNsPerMs);
  REQUIRE(sink.sent.size() == 4);
  for (int round = 1; round <= 4; ++round) {
    const FakeSink::Sent& sent = sink.sent[static_cast<std::size_t>(round - 1)];
    CHECK(sent.universes == universe_range(1, 9));
    CHECK(sent.levels[8] == round * 10 + 9);
  }
}

TEST_CASE("waiting rounds of two desks merge round by round") {
  World world;
  FakeSource a(world.waiter, "a", {1}), b(world.waiter, "b", {1});
  FakeSink sink(world.waiter, "artnet", {1});
  world.pump().add_source(a);
  world.pump().add_source(b);
  world.pump().add_sink(sink);
  world.pump().start();
  a.give(1, 10);
  b.give(1, 20);
  world.run_for(kNsPerMs);
  a.give(1, 30);
  a.give(1, 5);
  b.give(1, 2);
  b.give(1, 40);
  world.run_for(kNsPerMs);
  CHECK(levels_sent(sink) == std::vector<int>{20, 30, 5, 40});
}

TEST_CASE("a frame and the end of its sender in one wake-up still show the frame") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "artnet", {1});
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  source.give(1, 10);
  source.give(1, 0);
  source.end(1);
  world.run_for(kNsPerMs);
  CHECK(levels_sent(sink) == std::vector<int>{10, 0});
  CHECK(world.pump().status().universes[0].senders.empty());
}

TEST_CASE("all universes of one wake-up go to a sink in one call, and to each sink only its own") {
  World world;
  FakeSource source(world.waiter, "desk", universe_range(1, 9));
  FakeSink all(world.waiter, "artnet", universe_range(1, 9)), some(world.waiter, "dongle", {8, 3});
  world.pump().add_source(source);
  world.pump().add_sink(all);
  world.pump().add_sink(some);
  world.pump().start();
  for (Universe universe = 1; universe <= 9; ++universe)
    source.give(universe, static_cast<std::uint8_t>(universe * 10));
  world.run_for(kNsPerMs);
  REQUIRE(all.sent.size() == 1);
  CHECK(all.sent[0].universes == universe_range(1, 9));
  CHECK(all.sent[0].levels == std::vector<int>{10, 20, 30, 40, 50, 60, 70, 80, 90});
  REQUIRE(some.sent.size() == 1);
  CHECK(some.sent[0].universes == std::vector<Universe>{3, 8});
}

TEST_CASE("a starting sink gets every snapshot in the buffer once, and no universe without frames") {
  World world;
  const Slots slots = [] {
    Slots full;
    full.fill(42);
    return full;
  }();
  FrameView frame;
  frame.stamp_ns = 1;
  frame.slots = slots;
  world.universes.write(world.universes.index_of(4), frame);
  FakeSink sink(world.waiter, "dongle", universe_range(1, 9));
  world.pump().add_sink(sink);
  world.pump().start();
  world.run_for(10 * kNsPerS);
  REQUIRE(sink.sent.size() == 1);
  CHECK(sink.sent[0].universes == std::vector<Universe>{4});
  CHECK(sink.sent[0].levels == std::vector<int>{42});
  CHECK(world.pump().status().ports[0].latency.count == 0);  // an old snapshot is not a latency
}

TEST_CASE("the last snapshot stays when the source disappears, and a returning sink gets it at once") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "dongle", {1});
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  source.give(1, 99);
  world.run_for(kNsPerMs);
  source.poll_error = "desk: connection reset";
  source.give(1, 11);  // wakes it, and fails
  world.run_for(kNsPerS);

  sink.port_state = PortState::kGone;
  sink.port_trouble = "dongle: unplugged";
  sink.readable = true;
  sink.deadline_ns = world.now_ns() + 200 * kNsPerMs;
  sink.repeat_ns = 200 * kNsPerMs;
  world.run_for(60 * kNsPerS);
  CHECK(world.level(1) == 99);
  CHECK(levels_sent(sink) == std::vector<int>{99});

  const TimeNs plugged_in_ns = world.now_ns();
  sink.during_poll = [&](TimeNs) { sink.port_state = PortState::kWorking; };
  world.run_for(kNsPerS);
  REQUIRE(levels_sent(sink) == std::vector<int>{99, 99});
  CHECK(sink.sent[1].time_ns <= plugged_in_ns + 200 * kNsPerMs);
  CHECK(world.notices == std::vector<std::string>{"desk: lost: desk: connection reset",
                                                  "dongle: lost: dongle: unplugged", "dongle: back"});
}

TEST_CASE("a capped sink gets exactly its rate over two simulated hours, and every other sink all frames") {
  World world;
  FakeSource source(world.waiter, "desk", {1, 2});
  FakeSink capped(world.waiter, "dongle", {1, 2}, 30.0), free(world.waiter, "artnet", {1, 2});
  capped.keep_history = free.keep_history = false;
  // 44 Hz, from a desk with its own clock: 22,727,273 ns.
  source.deadline_ns = world.now_ns();
  source.repeat_ns = 22'727'273;
  source.before_poll = [&](TimeNs) {
    source.give(1, 1);
    source.give(2, 2);
  };
  world.pump().add_source(source);
  world.pump().add_sink(capped);
  world.pump().add_sink(free);
  world.pump().start();
  constexpr std::int64_t kHours = 2;
  const TimeNs start_ns = world.now_ns();
  world.run_until(start_ns + kHours * 3'600 * kNsPerS);
  const auto given = static_cast<std::int64_t>(source.poll_count);
  CHECK(static_cast<std::int64_t>(free.frame_count) == 2 * given);
  const auto sent = static_cast<std::int64_t>(capped.frame_count);
  CHECK(sent >= 2 * (kHours * 3'600 * 30 - 1));
  CHECK(sent <= 2 * (kHours * 3'600 * 30 + 1));
  const PumpStatus status = world.pump().status();
  CHECK(status.ports[1].frames + status.ports[1].replaced + 2 >= 2 * source.poll_count);  // sent, replaced or held now
  CHECK(status.ports[1].universes[0].rate_hz == doctest::Approx(30.0).epsilon(0.05));
  CHECK(status.ports[2].universes[1].rate_hz == doctest::Approx(44.0).epsilon(0.05));
}

TEST_CASE("a rate cap sends the newest snapshot when it is due, even without a further frame") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "dongle", {1}, 10.0);
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  const TimeNs start_ns = world.now_ns();
  for (const int ms : {0, 10, 20, 30})
    world.waiter.at(start_ns + ms * kNsPerMs, [&source, ms] { source.give(1, static_cast<std::uint8_t>(ms)); });
  world.run_for(kNsPerS);
  REQUIRE(sink.sent.size() == 2);
  CHECK(sink.sent[0] == FakeSink::Sent{start_ns, {1}, {0}});
  CHECK(sink.sent[1] == FakeSink::Sent{start_ns + 100 * kNsPerMs, {1}, {30}});
}

TEST_CASE("wake-ups that are always late lower no rate, and their lateness is measured") {
  World world;
  world.waiter.late_by_ns = 3 * kNsPerMs;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "dongle", {1}, 40.0);
  source.deadline_ns = world.now_ns();
  source.repeat_ns = kNsPerMs;
  source.before_poll = [&](TimeNs) { source.give(1, 1); };
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  world.run_for(100 * kNsPerS);
  CHECK(sink.frame_count >= 4'000 - 1);
  CHECK(sink.frame_count <= 4'000 + 1);
  const PumpStatus status = world.pump().status();
  CHECK(status.ports[0].lateness.max_ns >= 2 * kNsPerMs);
  CHECK(status.ports[0].lateness.max_ns <= 4 * kNsPerMs);
  CHECK(status.ports[1].lateness.count > 0);
  CHECK(status.ports[1].lateness.p50_ns <= 5 * kNsPerMs);
}

TEST_CASE("the backup desk takes over 2.5 s after the main desk's last frame, and the snapshot stays until then") {
  World world;
  FakeSource main_desk(world.waiter, "main", {1}), backup(world.waiter, "backup", {1});
  main_desk.sender = 1;
  backup.sender = 2;
  FakeSink sink(world.waiter, "dongle", {1});
  std::uint8_t main_level = 200, backup_level = 50;
  bool main_alive = true, backup_alive = true;
  make_desk(main_desk, world.clock, 1, 150, main_level, main_alive);
  make_desk(backup, world.clock, 1, 100, backup_level, backup_alive);
  world.pump().add_source(main_desk);
  world.pump().add_source(backup);
  world.pump().add_sink(sink);
  world.pump().start();
  world.run_for(kNsPerS);
  main_alive = false;
  const TimeNs last_word_ns = sink.sent.back().time_ns;
  backup_level = 60;  // the newest levels of the backup must show, not those from the start
  world.run_until(last_word_ns + 2'500 * kNsPerMs - 1);
  CHECK(world.level(1) == 200);
  world.run_for(kNsPerMs);
  CHECK(world.level(1) == 60);
  const auto first =
      std::find_if(sink.sent.begin(), sink.sent.end(), [](const auto& sent) { return sent.levels[0] == 60; });
  REQUIRE(first != sink.sent.end());
  CHECK(first->time_ns == last_word_ns + 2'500 * kNsPerMs);
  for (const FakeSink::Sent& sent : sink.sent) CHECK((sent.levels[0] == 200 || sent.levels[0] == 60));

  main_alive = true;
  world.run_for(2 * kFrameNs);
  CHECK(world.level(1) == 200);
}

TEST_CASE("a terminated desk loses its universe in the same wake-up") {
  World world;
  FakeSource main_desk(world.waiter, "main", {1}), backup(world.waiter, "backup", {1});
  main_desk.sender = 1;
  backup.sender = 2;
  FakeSink sink(world.waiter, "dongle", {1});
  world.pump().add_source(main_desk);
  world.pump().add_source(backup);
  world.pump().add_sink(sink);
  world.pump().start();
  main_desk.give(1, 200, 150);
  backup.give(1, 50, 100);
  world.run_for(kNsPerMs);
  const TimeNs end_ns = world.now_ns() + 1'000;
  world.waiter.at(end_ns, [&] { main_desk.end(1); });
  world.run_for(kNsPerMs);
  REQUIRE(sink.sent.size() == 2);
  CHECK(sink.sent[1] == FakeSink::Sent{end_ns, {1}, {50}});
}

TEST_CASE("a failing sink stops neither the other sinks nor the sources, and is reported once") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink bad(world.waiter, "bad", {1}), good(world.waiter, "good", {1});
  std::uint8_t level = 1;
  bool alive = true;
  make_desk(source, world.clock, 1, 100, level, alive);
  bad.send_error = "bad: write failed";
  world.pump().add_source(source);
  world.pump().add_sink(bad);
  world.pump().add_sink(good);
  world.pump().start();
  world.run_for(60 * kNsPerS);
  CHECK(good.frame_count == source.poll_count);
  CHECK(world.notices == std::vector<std::string>{"bad: lost: bad: write failed"});
  CHECK(bad.send_count > 50);  // it is tried again at growing intervals up to a second
  CHECK(bad.send_count < 80);
  const PortStatus status = world.pump().status().ports[1];
  CHECK(status.name == "bad");
  CHECK(status.failures == bad.send_count);
  CHECK(status.frames == 0);

  bad.send_error.clear();
  world.run_for(2 * kNsPerS);
  CHECK(bad.frame_count > 0);
  CHECK(world.notices.back() == "bad: back");
  CHECK(world.pump().status().ports[1].state == PortState::kWorking);
  CHECK(world.pump().status().ports[1].trouble.empty());
}

TEST_CASE("a source that fails stays listed as gone with its reason and is polled again at its own deadline") {
  World world;
  FakeSource bad(world.waiter, "bad", {1}), good(world.waiter, "good", {1});
  good.sender = 2;
  FakeSink sink(world.waiter, "dongle", {1});
  world.pump().add_source(bad);
  world.pump().add_source(good);
  world.pump().add_sink(sink);
  world.pump().start();
  bad.poll_error = "bad: unplugged";
  bad.give(1, 255);  // stays readable for ever: must not keep the pump awake
  world.run_for(kNsPerMs);
  const std::uint64_t polls = bad.poll_count, waits = world.waiter.wait_count;
  bad.deadline_ns = world.now_ns() + 400 * kNsPerMs;
  world.run_for(399 * kNsPerMs);
  CHECK(bad.poll_count == polls);
  CHECK(world.waiter.wait_count - waits < 5);
  PortStatus status = world.pump().status().ports[0];
  CHECK(status.state == PortState::kGone);
  CHECK(status.trouble == "bad: unplugged");
  good.give(1, 7);
  world.run_for(kNsPerMs);
  CHECK(bad.poll_count == polls + 1);
  CHECK(world.level(1) == 7);

  bad.poll_error.clear();
  bad.deadline_ns = world.now_ns() + 20 * kNsPerMs;
  world.run_for(100 * kNsPerMs);
  CHECK(world.level(1) == 255);  // its frame was still waiting
  status = world.pump().status().ports[0];
  CHECK(status.state == PortState::kWorking);
  CHECK(status.trouble.empty());
  CHECK(world.notices == std::vector<std::string>{"bad: lost: bad: unplugged", "bad: back"});
}

TEST_CASE("a port that is gone cannot keep the pump awake with its descriptor or with a deadline in the past") {
  for (const bool by_descriptor : {true, false}) {
    World world;
    FakeSink sink(world.waiter, "dongle", {1});
    sink.port_state = PortState::kGone;
    if (by_descriptor) {
      sink.during_poll = [&](TimeNs) { sink.readable = true; };
      sink.readable = true;
    } else {
      sink.deadline_ns = 1;
      sink.deadline_stuck = true;
    }
    world.pump().add_sink(sink);
    world.pump().start();
    world.run_for(10 * kNsPerS);
    CHECK(sink.poll_count > 5);  // and it is still polled
    CHECK(world.waiter.wait_count < 1'100);
  }
}

TEST_CASE("a port may come back with another descriptor") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  world.pump().add_source(source);
  world.pump().start();
  world.run_for(kNsPerMs);
  const int old_fd = source.fd;
  CHECK(world.waiter.watched().count(old_fd) == 1);
  source.port_state = PortState::kGone;
  source.fd = -1;
  source.deadline_ns = world.now_ns() + 50 * kNsPerMs;
  world.run_for(100 * kNsPerMs);
  CHECK(world.waiter.watched().count(old_fd) == 0);
  bool rang = false;
  source.before_poll = [&](TimeNs) { rang = false; };
  source.fd = world.waiter.make_fd([&] { return rang; });
  source.port_state = PortState::kWorking;
  source.deadline_ns = world.now_ns() + 50 * kNsPerMs;
  world.run_for(100 * kNsPerMs);
  CHECK(world.waiter.watched().count(source.fd) == 1);
  source.deadline_ns = kTimeNever;
  source.give(1, 5);
  rang = true;
  world.run_for(kNsPerMs);
  CHECK(world.level(1) == 5);
}

TEST_CASE("two ports that share a descriptor are both polled when it is readable") {
  World world;
  FakeSource in(world.waiter, "in", {1});
  FakeSink out(world.waiter, "out", {2});
  out.fd = in.fd;
  world.pump().add_source(in);
  world.pump().add_sink(out);
  world.pump().start();
  world.run_for(kNsPerMs);
  const std::uint64_t before = out.poll_count;
  in.give(1, 1);
  world.run_for(kNsPerMs);
  CHECK(out.poll_count == before + 1);
  CHECK(world.level(1) == 1);
}

TEST_CASE("a sink is polled at its keep-alive deadline while no frame arrives") {
  World world;
  FakeSink sink(world.waiter, "sacn", {1});
  const TimeNs start_ns = world.now_ns();
  sink.deadline_ns = start_ns + kNsPerS;
  sink.repeat_ns = kNsPerS;
  world.pump().add_sink(sink);
  world.pump().start();
  world.run_for(5 * kNsPerS + 1);
  REQUIRE(sink.polled_ns.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) CHECK(sink.polled_ns[i] == start_ns + static_cast<TimeNs>(i + 1) * kNsPerS);
  CHECK(sink.send_count == 0);
}

TEST_CASE("one notice names all universes of a port that are not part of the run") {
  World world;
  std::vector<Universe> wide = universe_range(1, 512);
  wide.push_back(600);
  FakeSource source(world.waiter, "desk", wide);
  world.pump().add_source(source);
  CHECK(world.notices ==
        std::vector<std::string>{"desk: universes 10-512,600 are not among those of this run; they stay unused"});
}

TEST_CASE("frames of universes that the source did not announce are counted and not routed") {
  World world;
  FakeSource source(world.waiter, "desk", {1, 40});
  FakeSink sink(world.waiter, "dongle", universe_range(1, 9));
  world.pump().add_source(source);
  CHECK(world.notices == std::vector<std::string>{"desk: universe 40 is not among those of this run; it stays unused"});
  world.pump().add_sink(sink);
  world.pump().start();
  source.give(2, 1);
  source.give(40, 1);
  source.give(-1, 1);
  world.run_for(kNsPerMs);
  CHECK(sink.send_count == 0);
  CHECK(world.pump().status().ports[0].unrouted == 3);
}

TEST_CASE("a refused ninth sender and a priority above 200 are reported once and counted every time") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  world.pump().add_source(source);
  world.pump().start();
  for (source.sender = 1; source.sender <= 10; ++source.sender) source.give(1, 1);
  source.sender = 1;
  source.give(1, 1, 201);
  source.give(1, 1, 202);
  world.run_for(kNsPerMs);
  REQUIRE(world.notices.size() == 2);
  CHECK(world.notices[0].find("universe 1 has 8 senders already") != std::string::npos);
  CHECK(world.notices[1].find("priority 201") != std::string::npos);
  const UniverseStatus status = world.pump().status().universes[0];
  CHECK(status.merge.refused_full == 2);
  CHECK(status.merge.refused_priority == 2);
  CHECK(status.senders.size() == 8);
  CHECK(status.winners == 8);
}

TEST_CASE("a tap receives every frame as it came, including losers and unknown universes") {
  struct Tap final : FrameReceiver {
    void receive(const FrameView& frame) override { levels.push_back(frame.slots[0]); }
    std::vector<int> levels;
  };
  World world;
  Tap tap;
  FakeSource source(world.waiter, "desk", {1});
  world.pump().add_source(source);
  world.pump().add_tap(tap);
  world.pump().start();
  source.give(1, 1, 150);
  source.sender = 2;
  source.give(1, 2, 100);
  source.give(63, 3);
  world.run_for(kNsPerMs);
  CHECK(tap.levels == std::vector<int>{1, 2, 3});
}

TEST_CASE("a sink fed by a tap is reported with its own count of frames and rate") {
  struct Recorder final : Sink, FrameReceiver {
    void receive(const FrameView&) override { ++count; }
    std::string name() const override { return "log"; }
    PortState state() const override { return PortState::kWorking; }
    PortCounters counters() const override { return {.frames = count}; }
    Status send(TimeNs, std::span<const FrameView>) override { return {}; }
    Status poll(TimeNs) override { return {}; }
    std::span<const Universe> universes() const override { return {}; }
    void close(TimeNs) override {}
    std::uint64_t count = 0;
  };
  World world;
  Recorder recorder;
  FakeSource source(world.waiter, "desk", {1});
  std::uint8_t level = 5;
  bool alive = true;
  make_desk(source, world.clock, 1, 100, level, alive);
  world.pump().add_source(source);
  world.pump().add_sink(recorder);
  world.pump().add_tap(recorder);
  world.pump().start();
  world.run_for(10 * kNsPerS);
  const PumpStatus status = world.pump().status();
  REQUIRE(status.ports.size() == 2);
  CHECK(status.ports[1].frames == recorder.count);
  CHECK(recorder.count >= 399);
  CHECK(status.ports[1].rate_hz == doctest::Approx(40).epsilon(0.03));
  CHECK(unaccounted(status.ports[1]) == 0);
}

TEST_CASE("stop closes every sink once, also a failed one, after sending what the cap held back") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink capped(world.waiter, "capped", {1}, 1.0), failed(world.waiter, "failed", {1}),
      idle(world.waiter, "idle", {2});
  failed.send_error = "failed: no";
  world.pump().add_source(source);
  for (FakeSink* sink : {&capped, &failed, &idle}) world.pump().add_sink(*sink);
  world.pump().start();
  source.give(1, 1);
  world.run_for(kNsPerMs);
  source.give(1, 2);
  world.run_for(kNsPerMs);
  CHECK(levels_sent(capped) == std::vector<int>{1});
  world.pump().stop();
  world.pump().stop();
  CHECK(levels_sent(capped) == std::vector<int>{1, 2});
  for (const FakeSink* sink : {&capped, &failed, &idle}) CHECK(sink->close_count == 1);
  CHECK(world.waiter.watched().empty());
}

TEST_CASE("run returns after a request_stop before or during it, with every sink closed") {
  for (const bool before : {true, false}) {
    World world;
    FakeSink sink(world.waiter, "dongle", {1});
    world.pump().add_sink(sink);
    if (before) {
      world.pump().request_stop();
    } else {
      world.waiter.at(world.now_ns() + 10 * kNsPerS, [&] { world.pump().request_stop(); });
    }
    world.pump().run();
    CHECK(sink.close_count == 1);
    CHECK(world.now_ns() == FakeClock().now_ns() + (before ? 0 : 10 * kNsPerS));
  }
}

TEST_CASE("with stop_at_end run returns when the last source has ended, and not before") {
  PumpOptions options;
  options.stop_at_end = true;
  World world(options);
  FakeSource first(world.waiter, "a.dmxlog", {1}), second(world.waiter, "b.dmxlog", {2});
  FakeSink sink(world.waiter, "dongle", {1, 2});
  const TimeNs start_ns = world.now_ns();
  for (FakeSource* source : {&first, &second}) {
    const DurationNs end_ns = source == &first ? kNsPerS : 3 * kNsPerS;
    source->deadline_ns = start_ns + kFrameNs;
    source->repeat_ns = kFrameNs;
    source->before_poll = [source, start_ns, end_ns](TimeNs now_ns) {
      source->give(source->carried[0], 9);
      if (now_ns >= start_ns + end_ns) source->port_state = PortState::kEnded;
    };
    world.pump().add_source(*source);
  }
  world.pump().add_sink(sink);
  world.pump().run();
  CHECK(world.now_ns() == start_ns + 3 * kNsPerS);
  CHECK(first.poll_count == 40);  // none after its end
  CHECK(second.poll_count == 120);
  CHECK(sink.close_count == 1);
}

TEST_CASE("LTP for one universe: the desk that changed last wins it") {
  World world;
  FakeSource source(world.waiter, "desk", {1, 2});
  world.pump().set_mode(2, MergeMode::kLtp);
  world.pump().add_source(source);
  world.pump().start();
  for (const int level : {200, 100}) {
    source.sender = static_cast<SenderId>(level);
    source.give(1, static_cast<std::uint8_t>(level));
    source.give(2, static_cast<std::uint8_t>(level));
  }
  world.run_for(kNsPerMs);
  CHECK(world.level(1) == 200);
  CHECK(world.level(2) == 100);
}

TEST_CASE("latency is the age of the frame when its sink has sent it, including the wait for a rate cap") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "dongle", {1}, 10.0);
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  const TimeNs start_ns = world.now_ns();
  source.give(1, 1, 100, start_ns - 400);
  world.run_for(10 * kNsPerMs);
  CHECK(world.pump().status().ports[1].latency.count == 1);
  CHECK(world.pump().status().ports[1].latency.max_ns == 400);
  source.give(1, 2);
  world.run_for(kNsPerS);
  CHECK(world.pump().status().ports[1].latency.max_ns == 90 * kNsPerMs);
}

TEST_CASE("after its start the pump allocates nothing, in ten minutes of traffic with failover and a rate cap") {
  World world;
  // Ports with fixed memory, so that every counted allocation is the pump's.
  struct Desk final : Source {
    std::string name() const override { return "desk"; }
    TimeNs next_deadline_ns() const override { return next_ns; }
    PortState state() const override { return PortState::kWorking; }
    PortCounters counters() const override { return {}; }
    std::span<const Universe> universes() const override { return carried; }
    Status poll(TimeNs now_ns, FrameReceiver& receiver) override {
      while (next_ns <= now_ns) next_ns += kFrameNs;
      FrameView frame;
      frame.stamp_ns = now_ns;
      frame.slots = slots;
      for (int sender = 1; sender <= 9; ++sender) {
        if (now_ns / (4 * kNsPerS) % 2 == 1 && sender > 4) break;  // half of them are silent for 4 s out of 8
        frame.sender = static_cast<SenderId>(sender);
        frame.priority = static_cast<std::uint8_t>(100 + sender % 3);
        for (const Universe universe : carried) {
          frame.universe = universe;
          receiver.receive(frame);
        }
      }
      return {};
    }
    TimeNs next_ns = 0;
    std::vector<Universe> carried = universe_range(1, 9);
    Slots slots{};
  };
  struct Stage final : Sink {
    std::string name() const override { return "stage"; }
    PortState state() const override { return PortState::kWorking; }
    PortCounters counters() const override { return {}; }
    std::span<const Universe> universes() const override { return carried; }
    double rate_hz_max() const override { return 33.0; }
    Status send(TimeNs, std::span<const FrameView> frames) override {
      frame_count += frames.size();
      return {};
    }
    Status poll(TimeNs) override { return {}; }
    void close(TimeNs) override {}
    std::uint64_t frame_count = 0;
    std::vector<Universe> carried = universe_range(1, 9);
  };
  Desk desk;
  Stage stage;
  world.pump().add_source(desk);
  world.pump().add_sink(stage);
  world.pump().start();
  for (int i = 0; i < 100; ++i) world.pump().step();  // the ninth sender is refused and reported: that may allocate
  const std::uint64_t before = testing::allocation_count();
  const TimeNs end_ns = world.now_ns() + 600 * kNsPerS;
  while (world.now_ns() < end_ns) {
    world.pump().step();
    static_cast<void>(world.universes.revision());
  }
  CHECK(testing::allocation_count() == before);
  CHECK(stage.frame_count > 9u * 600u * 30u);
  CHECK(world.pump().status().universes[0].merge.senders_silent > 100);
}

TEST_CASE("No rate is above 100 Hz after a device that times its line itself replaces one that does not") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "open-dmx", {1}, 40.0);
  sink.line_frames = 1000;
  sink.keep_history = false;
  source.deadline_ns = world.now_ns();
  source.repeat_ns = 25 * kNsPerMs;
  int level = 0;
  source.before_poll = [&](TimeNs) {
    source.give(1, static_cast<std::uint8_t>(++level));
    if (sink.line_frames) ++*sink.line_frames;
  };
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  double highest_hz = 0;
  const auto run_for = [&](int seconds) {
    for (int i = 0; i < 10 * seconds; ++i) {
      world.run_for(kNsPerS / 10);
      highest_hz = std::max(highest_hz, world.pump().status().ports[1].rate_hz);
    }
  };
  run_for(3);
  sink.line_frames = std::nullopt;  // the device times its line
  run_for(3);
  sink.line_frames = 900'000;  // this machine times it again, and the port continued to count
  run_for(3);
  sink.line_frames = 0;  // another device, within one period
  run_for(3);
  CHECK(highest_hz < 100);
  CHECK(world.pump().status().ports[1].rate_hz == doctest::Approx(40.0).epsilon(0.05));
}

TEST_CASE("the rate of a line that this machine times counts frames sent on the line, not frames passed to the sink") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink timed(world.waiter, "open-dmx", {1}, 40.0), other(world.waiter, "artnet", {1});
  timed.line_frames = 1000;  // from before
  timed.figures = {{.name = "requested_hz", .value = 40.0}};
  timed.keep_history = other.keep_history = false;
  source.deadline_ns = world.now_ns();
  source.repeat_ns = 25 * kNsPerMs;
  int turn = 0;
  source.before_poll = [&](TimeNs) {
    source.give(1, static_cast<std::uint8_t>(++turn));
    if (turn % 4 != 0) ++*timed.line_frames;  // 30 of 40 are sent
  };
  world.pump().add_source(source);
  world.pump().add_sink(timed);
  world.pump().add_sink(other);
  world.pump().start();
  world.run_for(10 * kNsPerS);
  const PumpStatus status = world.pump().status();
  CHECK(status.ports[1].rate_hz == doctest::Approx(30.0).epsilon(0.05));
  CHECK(status.ports[1].universes[0].rate_hz == doctest::Approx(30.0).epsilon(0.05));
  CHECK(status.ports[2].rate_hz == doctest::Approx(40.0).epsilon(0.05));
  REQUIRE(status.ports[1].figures.size() == 1);
  CHECK(status.ports[1].figures[0].name == "requested_hz");
  CHECK(status.ports[2].figures.empty());
}

TEST_CASE("a sink that appears after the start is called at its rate cap of that time") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "velleman", {1}, 44.0);
  sink.port_state = PortState::kGone;
  source.deadline_ns = world.now_ns();
  source.repeat_ns = 10 * kNsPerMs;
  int turn = 0;
  source.before_poll = [&](TimeNs) { source.give(1, static_cast<std::uint8_t>(++turn)); };
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  world.run_for(2 * kNsPerS);
  CHECK(sink.frame_count == 0);
  sink.set_rate_hz_max(20.0);
  sink.port_state = PortState::kWorking;
  world.run_for(2 * kNsPerS);
  const std::uint64_t before = sink.frame_count;
  world.run_for(10 * kNsPerS);
  CHECK(sink.frame_count - before == 200);
}

// --- Standbys ---

namespace {

// A desk, a main sink and a chain of standby sinks.
struct Chain {
  World world;
  FakeSource source{world.waiter, "desk", {1, 2}};
  FakeSink first{world.waiter, "first", {1, 2}}, second{world.waiter, "second", {1, 2}},
      third{world.waiter, "third", {1}};

  void start() {
    world.pump().add_source(source);
    world.pump().add_sink(first);
    world.pump().add_sink(second, {.standby_for = &first});
    world.pump().add_sink(third, {.standby_for = &second});
    world.pump().start();
  }
  void give(int level) {
    source.give(1, static_cast<std::uint8_t>(level));
    source.give(2, static_cast<std::uint8_t>(level + 1));
    world.run_for(kNsPerMs);
  }
};

}  // namespace

TEST_CASE("a standby gets nothing while its main works, and every snapshot in the tick in which the main fails") {
  Chain chain;
  chain.start();
  chain.give(10);
  CHECK(chain.second.sent.empty());
  chain.first.send_error = "first: unplugged";
  const TimeNs at_ns = chain.world.now_ns();
  chain.source.give(2, 99);
  chain.world.run_for(kNsPerMs);
  REQUIRE(chain.second.sent.size() == 1);
  CHECK(chain.second.sent[0] == FakeSink::Sent{at_ns, {1, 2}, {10, 99}});
  chain.give(20);
  CHECK(levels_sent(chain.second) == std::vector<int>{10, 99, 20, 21});
  CHECK(chain.third.sent.empty());
  CHECK(chain.world.notices ==
        std::vector<std::string>{"first: lost: first: unplugged", "second: takes over for first"});

  chain.first.send_error.clear();
  chain.world.run_for(2 * kNsPerS);
  CHECK(chain.first.sent.back().levels == std::vector<int>{20, 21});
  CHECK(chain.second.rest_count == 1);
  chain.give(30);
  CHECK(chain.first.sent.back().levels == std::vector<int>{30, 31});
  CHECK(chain.second.sent.size() == 2);
  CHECK(chain.world.notices.size() == 4);
  CHECK(chain.world.notices[2] == "first: back");
  CHECK(chain.world.notices[3] == "second: on standby again; first is back");
  const PumpStatus status = chain.world.pump().status();
  CHECK(status.ports[2].standby);
  CHECK(status.ports[2].standby_for == "first");
  for (const PortStatus& port : status.ports) CHECK(unaccounted(port) == 0);
}

TEST_CASE("with the main gone at the start, its standby gets frames from the start") {
  Chain chain;
  chain.first.port_state = PortState::kGone;
  chain.first.port_trouble = "first: not plugged in";
  chain.start();
  chain.give(10);
  CHECK(levels_sent(chain.second) == std::vector<int>{10, 11});
  CHECK(chain.first.sent.empty());
  CHECK(chain.third.sent.empty());
}

TEST_CASE("with main and standby gone the next in the chain gets frames, and rests when either is back") {
  for (const bool second_first : {true, false}) {
    Chain chain;
    chain.start();
    chain.give(10);
    chain.first.send_error = "first: no";
    chain.second.send_error = "second: no";
    chain.source.give(1, 20);
    chain.world.run_for(kNsPerMs);
    CHECK(levels_sent(chain.third) == std::vector<int>{20});
    FakeSink& returns = second_first ? chain.second : chain.first;
    returns.send_error.clear();
    chain.world.run_for(2 * kNsPerS);
    CHECK(chain.third.rest_count == 1);
    CHECK(returns.sent.back().levels == std::vector<int>{20, 11});
    chain.give(30);
    CHECK(chain.third.sent.size() == 1);
    CHECK(returns.sent.back().levels == std::vector<int>{30, 31});
  }
}

TEST_CASE("while all are gone no sink gets frames and nothing spins, the first one back gets every snapshot") {
  Chain chain;
  for (FakeSink* sink : {&chain.first, &chain.second, &chain.third}) sink->send_error = "no";
  chain.start();
  chain.give(10);
  const std::uint64_t waits = chain.world.waiter.wait_count;
  chain.world.run_for(60 * kNsPerS);
  CHECK(chain.world.waiter.wait_count - waits < 400);
  chain.third.send_error.clear();
  chain.world.run_for(2 * kNsPerS);
  CHECK(levels_sent(chain.third) == std::vector<int>{10});
  for (const PortStatus& port : chain.world.pump().status().ports) CHECK(unaccounted(port) == 0);
}

TEST_CASE("a main that accepts polls but no snapshots is not back, so its standby gets frames all along") {
  Chain chain;
  chain.start();
  chain.give(10);
  chain.first.send_error = "first: stalled";
  chain.give(20);
  const std::size_t before = chain.world.notices.size();
  for (int i = 0; i < 400; ++i) {  // ten seconds with about a dozen attempts
    chain.source.give(1, static_cast<std::uint8_t>(i));
    chain.world.run_for(kFrameNs);
  }
  CHECK(chain.first.send_count > 10);
  CHECK(chain.second.rest_count == 0);
  CHECK(chain.world.notices.size() == before);
  CHECK(chain.second.sent.size() == 1 + 400);
}

TEST_CASE("a flapping main loses no snapshot: each is at the main or at the standby when its tick ends") {
  Chain chain;
  chain.start();
  std::uint64_t random = 7;
  for (int i = 0; i < 2'000; ++i) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    if (random >> 61 == 0) chain.first.send_error = chain.first.send_error.empty() ? "first: flaps" : "";
    const int level = i % 250;
    chain.source.give(1, static_cast<std::uint8_t>(level));
    chain.world.run_for(kFrameNs);
    const auto last = [](const FakeSink& sink) { return sink.sent.empty() ? -1 : sink.sent.back().levels[0]; };
    const bool fed_second = last(chain.second) == level, fed_first = last(chain.first) == level;
    REQUIRE((fed_first || fed_second));
  }
  CHECK(chain.second.rest_count > 10);
  for (const PortStatus& port : chain.world.pump().status().ports) CHECK(unaccounted(port) == 0);
}

TEST_CASE("a standby whose main is removed gets frames from then on, or becomes the standby of the one before") {
  Chain chain;
  chain.start();
  chain.give(10);
  chain.world.pump().call([&] { chain.world.pump().remove_sink(chain.second); });
  chain.give(20);
  CHECK(chain.second.close_count == 1);
  CHECK(chain.third.sent.empty());
  CHECK(chain.world.pump().status().ports[2].standby_for == "first");
  chain.world.pump().call([&] { chain.world.pump().remove_sink(chain.first); });
  chain.world.run_for(kNsPerMs);
  CHECK(levels_sent(chain.third) == std::vector<int>{20});
}

// --- Ports and universes that change while it runs ---

TEST_CASE("call runs a job on the pump's thread in the next step, in order, and stop runs the remaining ones") {
  World world;
  world.pump().start();
  std::vector<int> done;
  world.waiter.at(world.now_ns() + 3 * kNsPerMs, [&] {
    world.pump().call([&] { done.push_back(1); });
    world.pump().call([&] { done.push_back(2); });
  });
  world.pump().step();
  CHECK(world.now_ns() == FakeClock().now_ns() + 3 * kNsPerMs);  // it did not continue to sleep
  CHECK(done == std::vector<int>{1, 2});
  world.pump().call([&] { done.push_back(3); });
  world.pump().stop();
  CHECK(done == std::vector<int>{1, 2, 3});
}

TEST_CASE("a source added while the pump runs delivers at once, and a removed one no more") {
  World world;
  FakeSource first(world.waiter, "first", {1}), second(world.waiter, "second", {1});
  FakeSink sink(world.waiter, "artnet", {1});
  world.pump().add_source(first);
  world.pump().add_sink(sink);
  world.pump().start();
  first.give(1, 200);
  world.run_for(kNsPerMs);
  second.give(1, 50);  // opened before it was added: its frame is waiting
  world.pump().call([&] {
    world.pump().add_source(second);
    world.pump().remove_source(first);
  });
  const TimeNs at_ns = world.now_ns();
  world.run_for(kNsPerMs);
  CHECK(sink.sent.back() == FakeSink::Sent{at_ns, {1}, {50}});
  CHECK(world.waiter.watched().count(first.fd) == 0);
  first.give(1, 255);
  world.run_for(kNsPerMs);
  CHECK(world.level(1) == 50);
  CHECK(world.pump().status().ports.size() == 2);
  CHECK(world.pump().status().universes[0].senders.size() == 1);
}

TEST_CASE(
    "a sink added while the pump runs gets every snapshot in that step, a removed one gets its last snapshot and is "
    "closed") {
  World world;
  FakeSource source(world.waiter, "desk", {1, 2});
  FakeSink capped(world.waiter, "dongle", {1, 2}, 1.0), added(world.waiter, "artnet", {1, 2});
  world.pump().add_source(source);
  world.pump().add_sink(capped);
  world.pump().start();
  source.give(1, 10);
  source.give(2, 20);
  world.run_for(kNsPerMs);
  source.give(2, 30);
  world.run_for(kNsPerMs);
  const TimeNs at_ns = world.now_ns();
  world.pump().call([&] {
    world.pump().remove_sink(capped);
    world.pump().add_sink(added);
  });
  world.run_for(kNsPerMs);
  CHECK(levels_sent(capped) == std::vector<int>{10, 20, 30});
  CHECK(capped.close_count == 1);
  REQUIRE(added.sent.size() == 1);
  CHECK(added.sent[0] == FakeSink::Sent{at_ns, {1, 2}, {10, 30}});
  CHECK(world.waiter.watched().count(capped.fd) == 0);
}

TEST_CASE(
    "a move to other universes keeps snapshots, senders, priorities, silence and counters, and serves the new ones") {
  World world;
  FakeSource source(world.waiter, "desk", {1, 2, 40}), backup(world.waiter, "backup", {2});
  FakeSink sink(world.waiter, "artnet", {2, 40});
  world.pump().add_source(source);
  world.pump().add_source(backup);
  world.pump().add_sink(sink);
  world.pump().start();
  source.give(1, 10);
  source.give(2, 200, 150);
  source.give(40, 1);  // not in the buffer
  backup.give(2, 50, 100);
  world.run_for(kNsPerMs);
  CHECK(levels_sent(sink) == std::vector<int>{200});
  const TimeNs heard_ns = world.now_ns();

  const std::shared_ptr<const Universes> old = world.pump().universes();
  const auto next = std::make_shared<Universes>(std::array<Universe, 2>{2, 40});
  // Frames that arrive in between wait in the ports.
  source.give(40, 77);
  world.pump().call([&] { world.pump().move_to(next, {}); });
  world.run_for(kNsPerMs);
  CHECK(world.pump().universes() == next);
  CHECK(levels_sent(sink) == std::vector<int>{200, 77});

  std::array<std::uint8_t, kSlotCountMax> levels;
  FrameStamp stamp;
  next->snapshot(next->index_of(2), levels, stamp);
  CHECK(levels[511] == 200);
  CHECK(stamp.stamp_ns != 0);
  old->snapshot(old->index_of(1), levels, stamp);  // the old one is still readable
  CHECK(levels[0] == 10);
  source.give(1, 11);
  world.run_for(kNsPerMs);
  PumpStatus status = world.pump().status();
  CHECK(status.ports[0].unrouted == 2);
  REQUIRE(status.universes.size() == 2);
  CHECK(status.universes[0].universe == 2);
  CHECK(status.universes[0].senders.size() == 2);
  CHECK(status.universes[0].senders[0].priority == 150);
  CHECK(status.universes[0].merge.frames == 2);
  CHECK(status.universes[0].writes == 1);
  for (int i = 0; i < 100; ++i) {
    backup.give(2, 60, 100);
    world.run_for(kFrameNs);
  }
  CHECK(heard_ns + 2'500 * kNsPerMs < world.now_ns());
  next->snapshot(next->index_of(2), levels, stamp);
  CHECK(levels[0] == 60);  // the main desk's silence continued through the move
  const auto first = std::find_if(sink.sent.begin(), sink.sent.end(), [](const auto& s) { return s.levels[0] == 60; });
  REQUIRE(first != sink.sent.end());
  CHECK(first->time_ns <= heard_ns + 2'500 * kNsPerMs);
}

TEST_CASE("a snapshot held back by a cap is dropped and counted when its universe is removed") {
  World world;
  FakeSource source(world.waiter, "desk", {1, 2});
  FakeSink sink(world.waiter, "dongle", {1, 2}, 1.0);
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  for (const int level : {10, 20}) {
    source.give(1, static_cast<std::uint8_t>(level));
    source.give(2, static_cast<std::uint8_t>(level));
  }
  world.run_for(kNsPerMs);
  source.give(1, 30);
  source.give(2, 40);
  world.run_for(kNsPerMs);
  world.pump().call([&] { world.pump().move_to(std::make_shared<Universes>(std::array<Universe, 1>{2}), {}); });
  world.run_for(2 * kNsPerS);
  CHECK(sink.sent.back().universes == std::vector<Universe>{2});
  const PumpStatus status = world.pump().status();
  CHECK(status.ports[1].universes[0].waiting == 0);
  CHECK(unaccounted(status.ports[1]) == 0);
}

TEST_CASE("a status says which of several winners have set a slot, in the order of its senders") {
  World world;
  FakeSource desk(world.waiter, "sacn:1", {1}), other(world.waiter, "artnet:1", {1});
  world.pump().add_source(other);
  world.pump().add_source(desk);
  world.pump().start();
  other.give(1, 50);
  world.run_for(kNsPerS / 2);
  CHECK(world.pump().status().universes[0].slot_senders.empty());  // there is one
  desk.give(1, 60);
  world.run_for(kNsPerS / 2);
  UniverseStatus status = world.pump().status().universes[0];
  REQUIRE(status.slot_senders.size() == kSlotCountMax);
  const auto setter = [&](std::size_t slot) {
    for (std::size_t k = 0; k < status.senders.size(); ++k) {
      if (status.slot_senders[slot] == 1 << k) return status.senders[k].name;
    }
    return std::string("several or none");
  };
  CHECK(setter(0) == "sacn:1");
  other.give(1, 70);
  world.run_for(kNsPerS / 10);
  status = world.pump().status().universes[0];
  CHECK(setter(0) == "artnet:1");
}

TEST_CASE("senders are reported by name, the highest priority first") {
  World world;
  FakeSource desk(world.waiter, "sacn:1", {1}), other(world.waiter, "artnet:1", {1});
  desk.sender_name = "FOH (10.0.0.7)";
  world.pump().add_source(desk);
  world.pump().add_source(other);
  world.pump().start();
  other.give(1, 1, 90);
  desk.give(1, 2, 110);
  world.run_for(kNsPerS);
  const std::vector<SenderStatus> senders = world.pump().status().universes[0].senders;
  REQUIRE(senders.size() == 2);  // although both are sender 1 of their source
  CHECK(senders[0].name == "FOH (10.0.0.7)");
  CHECK(senders[0].wins);
  CHECK(senders[0].priority == 110);
  CHECK(senders[0].age_ns == kNsPerS);
  CHECK(senders[0].rate_hz == doctest::Approx(1.0));
  CHECK(senders[1].name == "artnet:1");
  CHECK_FALSE(senders[1].wins);
}

TEST_CASE("lost frames of a sender are reported for their universe, also after a change of the buffer") {
  World world;
  FakeSource desk(world.waiter, "sacn:2-3", {3, 2});
  desk.losses = {{.lost = 30, .late = 3}, {.lost = 20, .late = 2}};
  world.pump().add_source(desk);
  world.pump().start();
  desk.give(2, 1);
  desk.give(3, 1);
  world.run_for(kNsPerMs);
  const auto lost_in = [&](Universe number) {
    for (const UniverseStatus& universe : world.pump().status().universes)
      if (universe.universe == number && universe.senders.size() == 1) return universe.senders[0].losses.lost;
    return std::uint64_t{999};
  };
  CHECK(lost_in(2) == 20);
  CHECK(lost_in(3) == 30);
  world.pump().call([&] { world.pump().move_to(std::make_shared<Universes>(std::array<Universe, 2>{3, 7}), {}); });
  world.run_for(kNsPerMs);
  CHECK(lost_in(3) == 30);
}

// --- Nothing is lost uncounted ---

TEST_CASE("every frame and every snapshot of a long random history is in exactly one counter") {
  World world;
  std::uint64_t random = 11;
  const auto draw = [&](std::uint64_t below) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return (random >> 33) % below;
  };
  FakeSource desks[2] = {{world.waiter, "a", {1, 2, 3}}, {world.waiter, "b", {2, 3, 4}}};
  FakeSink sinks[4] = {{world.waiter, "all", universe_range(1, 9)},
                       {world.waiter, "capped", {2, 3}, 30.0},
                       {world.waiter, "main", {1, 3}},
                       {world.waiter, "standby", {1, 3}}};
  for (FakeSource& desk : desks) world.pump().add_source(desk);
  for (FakeSink& sink : sinks) world.pump().add_sink(sink, {.standby_for = &sink == &sinks[3] ? &sinks[2] : nullptr});
  world.pump().set_mode(3, MergeMode::kLtp);
  world.pump().start();
  std::array<std::uint64_t, 10> given{};
  std::uint64_t strange = 0;
  for (int step = 0; step < 20'000; ++step) {
    for (std::uint64_t burst = draw(12); burst > 0; --burst) {
      FakeSource& desk = desks[draw(2)];
      desk.sender = 1 + draw(10);
      const auto universe = static_cast<Universe>(1 + draw(5));
      const bool carried = std::count(desk.carried.begin(), desk.carried.end(), universe) != 0;
      ++(carried ? given[static_cast<std::size_t>(universe)] : strange);
      if (draw(20) == 0) {
        desk.end(universe);
      } else {
        desk.give(universe, static_cast<std::uint8_t>(draw(3)),
                  static_cast<std::uint8_t>(draw(50) == 0 ? 201 : 99 + draw(3)));
      }
    }
    if (draw(10) == 0) {
      FakeSink& sink = sinks[draw(4)];
      sink.send_error = sink.send_error.empty() ? "no" : "";
    }
    world.run_for(static_cast<DurationNs>(1 + draw(draw(50) == 0 ? 3'000 : 30)) * kNsPerMs);
    const PumpStatus status = world.pump().status();
    for (const UniverseStatus& universe : status.universes) {
      REQUIRE(unaccounted(universe) == 0);
      REQUIRE(universe.merge.frames == given[static_cast<std::size_t>(universe.universe)]);
    }
    for (const PortStatus& port : status.ports) REQUIRE(unaccounted(port) == 0);
    REQUIRE(status.ports[0].unrouted + status.ports[1].unrouted == strange);
    // A sink without a cap that never failed has had every snapshot, so its frames equal the snapshots.
    for (std::size_t i = 0; i < 4; ++i) {
      const PortStatus& port = status.ports[2 + i];
      if (sinks[i].rate_hz_max() > 0.0 || port.failures != 0) continue;
      REQUIRE(port.frames == port.snapshots);
    }
  }
  const PumpStatus status = world.pump().status();
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(status.ports[2 + i].frames == sinks[i].frame_count);
    CHECK(status.ports[2 + i].refused > 0);
  }
  CHECK(status.ports[3].replaced > 100);
  const MergeCounters& merge = status.universes[2].merge;
  for (const std::uint64_t count : {merge.frames_shown, merge.frames_outranked, merge.frames_ended,
                                    merge.refused_priority, merge.refused_full, merge.senders_displaced})
    CHECK(count > 100);
}

// Desks on the network and a bridge: real sockets, the real pump, and a clock that jumps to the next event.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

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

constexpr DurationNs kFrameNs = kNsPerS / 44;

struct Received {
  TimeNs at_ns = 0;
  std::vector<std::uint8_t> levels;
  bool terminated = false;
};

// Universe 1 comes in by sACN and is sent as 101.
struct Stage {
  FakeClock clock;
  JumpingWaiter waiter{clock};
  std::unique_ptr<Universes> universes = must(Universes::make(std::vector<Universe>{1}));
  std::unique_ptr<SacnSource> in;
  std::unique_ptr<SacnSink> out;
  std::unique_ptr<SacnSource> listener;
  std::unique_ptr<Pump> pump;
  std::vector<std::unique_ptr<SacnSink>> desks;
  std::vector<std::uint8_t> desk_levels;
  std::vector<Received> output;

  Stage() {
    const auto own_senders = std::make_shared<OwnSenders>();
    SacnSourceOptions in_options;
    in_options.name = "sacn:1";
    in_options.universes = {{1, 1}};
    in_options.kernel_stamps = false;
    in_options.own_senders = own_senders;
    in = must(SacnSource::create(in_options));
    in_options.universes = {{101, 101}};
    in_options.own_senders = nullptr;
    listener = must(SacnSource::create(in_options));
    SacnSinkOptions out_options;
    out_options.name = "sacn:101=1";
    out_options.universes = {{101, 1}};
    out_options.own_senders = own_senders;
    out = must(SacnSink::create(out_options));
    pump = std::make_unique<Pump>(*universes, clock, waiter);
    pump->add_source(*in);
    pump->add_sink(*out);
    pump->start();
  }

  void add_desk(std::uint8_t priority, std::uint8_t level, std::vector<std::uint8_t> address_priorities = {}) {
    SacnSinkOptions options;
    options.name = "desk";
    options.universes = {{1, 1}};
    options.priority = priority;
    options.address_priorities = std::move(address_priorities);
    options.cid.fill(static_cast<std::uint8_t>(desks.size() + 1));
    desks.push_back(must(SacnSink::create(options)));
    desk_levels.push_back(level);
  }

  // Every active desk sends each 1/44 s; the pump runs; its output is kept with its time.
  void run_for(DurationNs duration_ns) {
    const TimeNs end_ns = clock.now_ns() + duration_ns;
    while (clock.now_ns() < end_ns) {
      for (std::size_t i = 0; i < desks.size(); ++i) {
        if (!desks[i]) continue;
        // A desk repeats itself at 44 Hz although nothing changes; a sink of ours would send four times and pause.
        ++wiggle_;
        std::array<std::uint8_t, 4> levels = {desk_levels[i], desk_levels[i], desk_levels[i], wiggle_};
        FrameView frame;
        frame.universe = 1;
        frame.slots = levels;
        REQUIRE(desks[i]->send(clock.now_ns(), {&frame, 1}).has_value());
      }
      waiter.limit_ns = clock.now_ns() + kFrameNs;
      while (clock.now_ns() < waiter.limit_ns) {
        pump->step();
        listen();
      }
    }
  }
  void listen() {
    KeepingReceiver frames;
    REQUIRE(testing::drain(*listener, clock.now_ns(), frames));
    for (auto& frame : frames.frames) {
      if (frame.view.start_code == kStartCodeLevels)
        output.push_back({clock.now_ns(), std::move(frame.slots), frame.view.terminated});
    }
  }
  [[nodiscard]] int level(std::size_t address) const { return output.back().levels[address - 1]; }

 private:
  std::uint8_t wiggle_ = 0;
};

}  // namespace

TEST_CASE(
    "when the desk of priority 150 disappears its levels are repeated for 2.5 s, then those of priority 100 appear") {
  if (!enter_private_network()) return;
  Stage stage;
  stage.add_desk(150, 10);
  stage.add_desk(100, 20);
  stage.run_for(kNsPerS);
  REQUIRE_FALSE(stage.output.empty());
  CHECK(stage.level(1) == 10);
  for (const Received& one : stage.output) REQUIRE(one.levels[0] == 10);
  stage.desks[0].reset();  // unplugged: no end of stream
  const TimeNs gone_ns = stage.clock.now_ns();
  stage.output.clear();
  stage.run_for(4 * kNsPerS);
  TimeNs last_ns = gone_ns;
  TimeNs taken_over_ns = 0;
  for (const Received& one : stage.output) {
    REQUIRE(one.at_ns - last_ns <= kNsPerS);  // E1.31-2018 section 6.6.2: no receiver may lose the bridge
    last_ns = one.at_ns;
    REQUIRE((one.levels[0] == 10 || one.levels[0] == 20));
    if (one.levels[0] == 20 && taken_over_ns == 0) taken_over_ns = one.at_ns;
    REQUIRE((taken_over_ns == 0) == (one.levels[0] == 10));
    REQUIRE_FALSE(one.terminated);
  }
  CHECK(taken_over_ns - gone_ns > 2'400 * kNsPerMs);  // its last frame was received up to 23 ms before
  CHECK(taken_over_ns - gone_ns <= 2'500 * kNsPerMs);
}

TEST_CASE("a desk that ends is replaced at once") {
  if (!enter_private_network()) return;
  Stage stage;
  stage.add_desk(150, 10);
  stage.add_desk(100, 20);
  stage.run_for(kNsPerS);
  CHECK(stage.level(1) == 10);
  stage.desks[0]->close(stage.clock.now_ns());
  stage.desks[0].reset();
  const TimeNs ended_ns = stage.clock.now_ns();
  stage.output.clear();
  stage.run_for(kFrameNs);
  REQUIRE_FALSE(stage.output.empty());
  CHECK(stage.output.front().at_ns == ended_ns);
  CHECK(stage.output.front().levels[0] == 20);
}

TEST_CASE("when the last desk disappears its levels stay and are repeated") {
  if (!enter_private_network()) return;
  Stage stage;
  stage.add_desk(100, 20);
  stage.run_for(kNsPerS);
  stage.desks[0].reset();
  stage.output.clear();
  stage.run_for(10 * kNsPerS);
  CHECK(stage.output.size() >= 10);
  for (const Received& one : stage.output) {
    CHECK(one.levels[0] == 20);
    CHECK_FALSE(one.terminated);
  }
}

TEST_CASE("priorities per address let two desks share a universe address by address") {
  if (!enter_private_network()) return;
  Stage stage;
  stage.add_desk(150, 10, {200, 0, 90});  // from address 4 on: 0, as past the end
  stage.add_desk(100, 20);
  stage.run_for(2 * kNsPerS);
  CHECK(stage.level(1) == 10);  // 200 against the other's 100
  CHECK(stage.level(2) == 20);  // 0: not claimed
  CHECK(stage.level(3) == 20);  // 90 against 100
  stage.desks[1]->close(stage.clock.now_ns());
  stage.desks[1].reset();
  stage.run_for(kNsPerS);
  CHECK(stage.level(1) == 10);
  CHECK(stage.level(3) == 10);  // no other desk is left
}

}  // namespace footlight::drivers

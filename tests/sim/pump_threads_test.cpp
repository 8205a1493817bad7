// A pump with calls from other threads. Apart from pump_test.cpp, whose long runs on one thread take ThreadSanitizer
// minutes and have no race to find.
#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <thread>

#include "sim/pump.h"
#include "tests/sim/pump_world.h"
#include "tests/support/fake_ports.h"

using namespace footlight;
using footlight::testing::FakeSink;
using footlight::testing::FakeSource;
using footlight::testing::make_desk;
using footlight::testing::World;

TEST_CASE("another thread may read buffer and status while the pump runs") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  FakeSink sink(world.waiter, "dongle", {1}, 20.0);
  std::uint8_t level = 3;
  bool alive = true;
  make_desk(source, world.clock, 1, 100, level, alive);
  sink.keep_history = false;
  world.pump().add_source(source);
  world.pump().add_sink(sink);
  world.pump().start();
  std::atomic<bool> done{false};
  std::uint64_t backwards = 0, torn = 0;
  std::jthread preview([&] {
    std::array<std::uint8_t, kSlotCountMax> levels;
    FrameStamp stamp;
    std::uint64_t ticks = 0;
    while (!done) {
      world.universes.snapshot(0, levels, stamp);
      if (stamp.revision != 0 && levels[0] != 3) ++torn;
      const PumpStatus status = world.pump().latest_status();
      if (status.ticks < ticks) ++backwards;
      ticks = status.ticks;
      if (status.ports.size() != 2 || status.ports[0].name != "desk") ++torn;
    }
  });
  world.run_for(120 * kNsPerS);
  done = true;
  preview.join();
  CHECK(backwards == 0);
  CHECK(torn == 0);
  static_cast<void>(world.pump().latest_status());  // requests the first status
  world.run_for(2 * kNsPerS);
  const PumpStatus status = world.pump().latest_status();
  CHECK(status.stamp_ns > world.now_ns() - 2 * kNsPerS);
  CHECK(status.ports[1].rate_hz == doctest::Approx(20.0).epsilon(0.1));
}

TEST_CASE("another thread's jobs are all run, on the pump's thread") {
  World world;
  FakeSource source(world.waiter, "desk", {1});
  std::uint8_t level = 1;
  bool alive = true;
  make_desk(source, world.clock, 1, 100, level, alive);
  world.pump().add_source(source);
  world.pump().start();
  int count = 0;  // used by the pump's thread
  std::jthread caller([&] {
    for (int i = 0; i < 1'000; ++i) world.pump().call([&] { ++count; });
  });
  world.run_for(60 * kNsPerS);
  caller.join();
  world.pump().stop();
  CHECK(count == 1'000);
}

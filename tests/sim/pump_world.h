// A pump with ports that a test controls, and a desk for it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/pump.h"
#include "tests/support/fake_ports.h"

namespace footlight::testing {

inline constexpr DurationNs kFrameNs = kNsPerS / 40;

// A pump with scripted ports around it.
struct World {
  FakeClock clock;
  FakeWaiter waiter{clock};
  Universes universes;
  std::vector<std::string> notices;
  std::unique_ptr<Pump> pump_owner;

  explicit World(PumpOptions options = {}) {
    options.on_notice = [this](const Notice& notice) { notices.emplace_back(notice.text); };
    pump_owner = std::make_unique<Pump>(universes, clock, waiter, options);
  }
  Pump& pump() { return *pump_owner; }
  TimeNs now_ns() { return clock.now_ns(); }
  void run_until(TimeNs time_ns) {
    waiter.at(time_ns, [this] { waiter.interrupt(); });
    while (clock.now_ns() < time_ns) pump().step();
  }
  void run_for(DurationNs duration_ns) { run_until(clock.now_ns() + duration_ns); }
  int level(Universe universe) {
    std::array<std::uint8_t, kSlotCountMax> levels;
    FrameStamp stamp;
    universes.snapshot(universes.index_of(universe), levels, stamp);
    return levels[0];
  }
};

// A source that sends one level of one universe 40 times a second from its own deadline, as long as `alive`.
inline void make_desk(FakeSource& source, FakeClock& clock, Universe universe, std::uint8_t priority,
                      std::uint8_t& level, bool& alive) {
  source.deadline_ns = clock.now_ns() + kFrameNs;
  source.repeat_ns = kFrameNs;
  source.before_poll = [&source, universe, priority, &level, &alive](TimeNs) {
    if (alive) source.give(universe, level, priority);
  };
}

}  // namespace footlight::testing

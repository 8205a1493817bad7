// Fixture-steps a second on one core, of fleets of generic/profile (16 bit), in float as on the GPU: head by head
// (Walker) and in batches (Fleet). Figures are in docs/numerics.md.
//
// A fixture-step is one fixture, one step of 1/60 s: its slots compared with those before, decoded where they have
// changed, its three motors, spin, strobe, dimmer law, colour and gobo where something is on its way, its light of the
// exposure. What rests is left out: that is why rows differ. Levels come in three of four steps, as from a desk of
// 45 Hz. bytes: of states, tables and levels that a fixture's step reads or writes, read and written counted once; MB:
// of states in all.
//   holds   nothing changes, and all moves are over
//   show    each frame one fixture in ten fades (pan, tilt, dimmer go a little further), one in 50 gets a new look; one
//           in ten strobes, one gobo in three turns. So most motors of some fixtures are on their way at any time
//   fade    all fade; as many strobe and turn
//   lively  each slot in 16 changes at random in each frame: 60 % of the fixtures get new levels, most motors move,
//           most fixtures strobe, most gobos turn, which no show does
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include <benchmark/benchmark.h>

#include "fixtures/builtin/builtin.h"
#include "fixtures/model/rig.h"
#include "fixtures/simulate/fleet.h"
#include "fixtures/simulate/walker.h"

namespace footlight {
namespace {

constexpr std::int64_t kStepNs = 16'666'667;

enum class Show { kHolds, kShow, kFade, kLively };

fixtures::Rig fleet_rig(int count) {
  const fixtures::FixtureType* type = fixtures::find_builtin_type("generic/profile");
  fixtures::Rig rig;
  rig.types.push_back(*type);
  const int slots = type->modes.front().slot_count;
  const int per_universe = 512 / slots;
  for (int i = 0; i < count; ++i) {
    fixtures::PatchedFixture fixture;
    fixture.name = "Head " + std::to_string(i + 1);
    fixture.universe = 1 + i / per_universe;
    fixture.address = 1 + i % per_universe * slots;
    rig.fixtures.push_back(std::move(fixture));
  }
  return rig;
}

// Levels of step after step.
class Levels {
 public:
  Levels(const fixtures::CompiledRig& rig, Show show) : rig_(rig), show_(show), bytes_(rig.universes.size() * 512) {
    for (std::uint8_t& byte : bytes_) byte = random_byte();
    if (show != Show::kLively) {
      for (const fixtures::HeadRow& head : rig.heads) stand(&bytes_[head.slot_first_1]);
    }
  }
  const std::vector<std::uint8_t>& next() {
    if (step_++ % 4 == 0 || show_ == Show::kHolds) return bytes_;
    if (show_ == Show::kLively) {
      for (std::uint8_t& byte : bytes_) {
        if (one_in(16)) byte = random_byte();
      }
      return bytes_;
    }
    for (std::size_t i = 0; i < rig_.heads.size(); ++i) {
      std::uint8_t* slots = &bytes_[rig_.heads[i].slot_first_1];
      // Who fades changes each ten seconds.
      if (show_ == Show::kFade || (i + static_cast<std::size_t>(step_) / 600) % 10 == 0) {
        for (const int slot : {1, 3, 5}) slots[slot] = static_cast<std::uint8_t>(slots[slot] + 3);  // the fine bytes
      }
      if (show_ == Show::kShow && one_in(50)) {
        for (int slot = 0; slot < 14; ++slot) slots[slot] = random_byte();
        stand(slots);
      }
    }
    return bytes_;
  }

 private:
  bool one_in(unsigned count) { return (random_() >> 8) % count == 0; }
  std::uint8_t random_byte() { return static_cast<std::uint8_t>(random_() >> 20); }
  void stand(std::uint8_t* slots) {
    if (show_ == Show::kHolds || !one_in(10)) slots[6] = 40;   // shutter open
    if (show_ == Show::kHolds || !one_in(3)) slots[13] = 128;  // gobo stands
  }
  const fixtures::CompiledRig& rig_;
  Show show_;
  std::vector<std::uint8_t> bytes_;
  std::minstd_rand random_{7};
  int step_ = 0;
};

template <class Stepper, Show show>
void fleet(benchmark::State& bench) {
  const auto compiled = fixtures::compile(fleet_rig(static_cast<int>(bench.range(0))));
  if (!compiled) std::abort();
  Stepper stepper(*compiled);
  Levels levels(*compiled, show);
  for (int i = 0; i < 170; ++i) stepper.step(levels.next(), kStepNs);  // the first look's moves are over: 2.6 s
  double touched = 0;
  for (auto _ : bench) {
    bench.PauseTiming();
    const std::vector<std::uint8_t>& now = levels.next();
    bench.ResumeTiming();
    stepper.step(now, kStepNs);
    benchmark::ClobberMemory();
    if constexpr (std::is_same_v<Stepper, fixtures::Fleet>) touched += static_cast<double>(stepper.touched_bytes());
  }
  if constexpr (std::is_same_v<Stepper, fixtures::Fleet>) {
    bench.counters["bytes"] = touched / static_cast<double>(bench.iterations() * bench.range(0));
    bench.counters["MB"] = static_cast<double>(stepper.bytes()) * 1e-6;
  }
  bench.SetItemsProcessed(bench.iterations() * bench.range(0));
}

#define FL_SHOW(show)                                       \
  BENCHMARK(fleet<fixtures::f32::Walker, show>)->Arg(4096); \
  BENCHMARK(fleet<fixtures::Fleet, show>)->Arg(100)->Arg(1000)->Arg(4096)->Arg(10'000)->Arg(100'000)->Arg(1'000'000)
FL_SHOW(Show::kHolds);
FL_SHOW(Show::kShow);
FL_SHOW(Show::kFade);
FL_SHOW(Show::kLively);

}  // namespace
}  // namespace footlight

// What one universe costs in the buffer, the merge and the pump. The counter "per_universe" is the figure to read (CPU
// time, so that other load matters little); the time columns are for all N universes of an iteration.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "sim/merge.h"
#include "sim/pump.h"
#include "sim/universes.h"

using namespace footlight;

namespace {

void count_universes(benchmark::State& state, std::int64_t count) {
  state.counters["per_universe"] = benchmark::Counter(static_cast<double>(state.iterations() * count),
                                                      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

// Levels that differ from universe to universe and from frame to frame.
std::vector<std::uint8_t> noise(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  std::uint64_t random = 1;
  for (std::uint8_t& byte : bytes) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    byte = static_cast<std::uint8_t>(random >> 56);
  }
  return bytes;
}

FrameView frame_of(const std::vector<std::uint8_t>& bytes, std::int64_t index) {
  FrameView frame;
  frame.stamp_ns = 1;
  frame.slots = std::span(bytes).subspan(static_cast<std::size_t>(index) * kSlotCountMax, kSlotCountMax);
  return frame;
}

void write_universes(benchmark::State& state) {
  const std::int64_t count = state.range(0);
  Universes universes(universe_range(1, static_cast<int>(count)));
  const auto bytes = noise(static_cast<std::size_t>(count) * kSlotCountMax);
  for (auto _ : state)
    for (std::int64_t i = 0; i < count; ++i) universes.write(static_cast<int>(i), frame_of(bytes, i));
  count_universes(state, count);
}

void snapshot_one_by_one(benchmark::State& state) {
  const std::int64_t count = state.range(0);
  Universes universes(universe_range(1, static_cast<int>(count)));
  std::vector<std::uint8_t> levels(static_cast<std::size_t>(count) * kSlotCountMax);
  FrameStamp stamp;
  for (auto _ : state) {
    for (std::int64_t i = 0; i < count; ++i)
      universes.snapshot(static_cast<int>(i),
                         std::span<std::uint8_t, kSlotCountMax>(levels.data() + i * kSlotCountMax, kSlotCountMax),
                         stamp);
    benchmark::DoNotOptimize(levels.data());
    benchmark::ClobberMemory();
  }
  count_universes(state, count);
}

void snapshot_all(benchmark::State& state) {
  const std::int64_t count = state.range(0);
  Universes universes(universe_range(1, static_cast<int>(count)));
  std::vector<std::uint8_t> levels(static_cast<std::size_t>(count) * kSlotCountMax);
  std::vector<FrameStamp> stamps(static_cast<std::size_t>(count));
  for (auto _ : state) {
    universes.snapshot_all(levels, stamps);
    benchmark::DoNotOptimize(levels.data());
    benchmark::ClobberMemory();
  }
  count_universes(state, count);
}

// A preview at 60 pictures a second over universes that come 44 times: here nothing was written since.
void snapshot_changed_nothing(benchmark::State& state) {
  const std::int64_t count = state.range(0);
  Universes universes(universe_range(1, static_cast<int>(count)));
  std::vector<std::uint8_t> levels(static_cast<std::size_t>(count) * kSlotCountMax);
  std::vector<FrameStamp> stamps(static_cast<std::size_t>(count));
  for (auto _ : state) {
    benchmark::DoNotOptimize(universes.snapshot_changed(levels, stamps));
    benchmark::ClobberMemory();
  }
  count_universes(state, count);
}

// receive() from every sender, then resolve(): the second argument is the number of senders, all of one priority.
void merge_senders(benchmark::State& state, MergeMode mode) {
  const std::int64_t count = state.range(0), senders = state.range(1);
  Merge merge(static_cast<int>(count), {.mode = mode});
  const auto bytes = noise(static_cast<std::size_t>(count + senders) * kSlotCountMax);
  TimeNs now_ns = 0;
  for (auto _ : state) {
    now_ns += 22 * kNsPerMs;
    for (std::int64_t sender = 0; sender < senders; ++sender)
      for (std::int64_t i = 0; i < count; ++i) {
        FrameView frame = frame_of(bytes, i + sender);
        frame.sender = static_cast<SenderId>(sender + 1);
        merge.receive(static_cast<int>(i), frame, now_ns);
      }
    merge.expire(now_ns);
    for (const int index : merge.changed()) benchmark::DoNotOptimize(merge.resolve(index));
    merge.clear_changed();
  }
  count_universes(state, count);
}
void merge_htp(benchmark::State& state) { merge_senders(state, MergeMode::kHtp); }
void merge_ltp(benchmark::State& state) { merge_senders(state, MergeMode::kLtp); }

// As merge_htp() with two senders that each have a priority in every slot, said once a second; or with two senders and
// half of the slots LTP.
void merge_slots(benchmark::State& state, bool priorities) {
  const std::int64_t count = state.range(0), senders = state.range(1);
  Merge merge(static_cast<int>(count));
  SlotSet odd;
  for (std::size_t slot = 1; slot < odd.size(); slot += 2) odd.set(slot);
  if (!priorities)
    for (int i = 0; i < merge.count(); ++i) merge.set_slot_modes(i, odd);
  const auto bytes = noise(static_cast<std::size_t>(count + senders) * kSlotCountMax);
  std::vector<std::uint8_t> claims(kSlotCountMax, 100);
  for (std::size_t slot = 0; slot < claims.size(); slot += 3) claims[slot] = 101;
  TimeNs now_ns = 0;
  std::int64_t rounds = 0;
  for (auto _ : state) {
    now_ns += 22 * kNsPerMs;
    for (std::int64_t sender = 0; sender < senders; ++sender)
      for (std::int64_t i = 0; i < count; ++i) {
        FrameView frame = frame_of(bytes, i + sender);
        frame.sender = static_cast<SenderId>(sender + 1);
        const auto source = static_cast<SourceId>(sender);
        merge.receive(static_cast<int>(i), frame, now_ns, source);
        if (!priorities || rounds % 45 != 0) continue;
        frame.start_code = kStartCodePriorities;
        frame.slots = claims;
        merge.receive(static_cast<int>(i), frame, now_ns, source);
      }
    ++rounds;
    merge.expire(now_ns);
    for (const int index : merge.changed()) benchmark::DoNotOptimize(merge.resolve(index));
    merge.clear_changed();
  }
  count_universes(state, count);
}
void merge_priorities(benchmark::State& state) { merge_slots(state, true); }
void merge_ltp_slots(benchmark::State& state) { merge_slots(state, false); }

// The whole tick without I/O: one source gives every universe, one sink takes them.
struct StillClock final : Clock {
  TimeNs now_ns() override { return now; }
  void sleep_until_ns(TimeNs) override {}
  TimeNs now = 1;
};
struct NoWaiter final : Waiter {
  Status watch(int) override { return {}; }
  void unwatch(int) override {}
  int wait_until(TimeNs, std::span<int>) override { return 0; }
  void interrupt() noexcept override {}
};
struct Desk final : Source {
  explicit Desk(int count) : carried(universe_range(1, count)), bytes(noise(carried.size() * kSlotCountMax)) {}
  std::string name() const override { return "desk"; }
  TimeNs next_deadline_ns() const override { return 0; }
  PortState state() const override { return PortState::kWorking; }
  PortCounters counters() const override { return {}; }
  std::span<const Universe> universes() const override { return carried; }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override {
    for (std::size_t n = 0; n < carried.size() * static_cast<std::size_t>(rounds); ++n) {
      const std::size_t i = n % carried.size();
      FrameView frame = frame_of(bytes, static_cast<std::int64_t>(i));
      frame.universe = carried[i];
      frame.sender = 1;
      frame.stamp_ns = now_ns;
      receiver.receive(frame);
    }
    return {};
  }
  int rounds = 1;
  std::vector<Universe> carried;
  std::vector<std::uint8_t> bytes;
};
struct Stage final : Sink {
  explicit Stage(int count) : carried(universe_range(1, count)) {}
  std::string name() const override { return "stage"; }
  PortState state() const override { return PortState::kWorking; }
  PortCounters counters() const override { return {}; }
  std::span<const Universe> universes() const override { return carried; }
  Status send(TimeNs, std::span<const FrameView> frames) override {
    for (const FrameView& frame : frames) benchmark::DoNotOptimize(frame.slots.data());
    return {};
  }
  Status poll(TimeNs) override { return {}; }
  void close(TimeNs) override {}
  std::vector<Universe> carried;
};

void pump_rounds(benchmark::State& state, int rounds) {
  const int count = static_cast<int>(state.range(0));
  Universes universes(universe_range(1, count));
  StillClock clock;
  NoWaiter waiter;
  Desk desk(count);
  desk.rounds = rounds;
  Stage stage(count);
  Pump pump(universes, clock, waiter);
  pump.add_source(desk);
  pump.add_sink(stage);
  pump.start();
  for (auto _ : state) {
    clock.now += 22 * kNsPerMs;
    pump.tick(clock.now);
  }
  pump.stop();
  count_universes(state, count * rounds);
}
void pump_tick(benchmark::State& state) { pump_rounds(state, 1); }
// Two rounds of the desk lie there: each leaves by itself.
void pump_tick_piled_up(benchmark::State& state) { pump_rounds(state, 2); }

#define SIZES Arg(9)->Arg(512)->Arg(4096)
BENCHMARK(write_universes)->SIZES;
BENCHMARK(snapshot_one_by_one)->SIZES;
BENCHMARK(snapshot_all)->SIZES;
BENCHMARK(snapshot_changed_nothing)->SIZES;
BENCHMARK(merge_htp)->ArgsProduct({{9, 512, 4096}, {1, 2, 8}});
BENCHMARK(merge_ltp)->ArgsProduct({{9, 512, 4096}, {2}});
BENCHMARK(merge_priorities)->ArgsProduct({{9, 512, 4096}, {2}});
BENCHMARK(merge_ltp_slots)->ArgsProduct({{9, 512, 4096}, {2}});
BENCHMARK(pump_tick)->SIZES;
BENCHMARK(pump_tick_piled_up)->SIZES;

}  // namespace

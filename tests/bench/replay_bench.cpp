// How exactly a log is replayed, beside a loop that sleeps to the same deadlines and does nothing else: turn and turn
// about on one thread, so that both meet the same machine.
//
//   bench_replay [SECONDS [UNIVERSES]]     default 60, 24
//
// An interval's error is what lies between two frames of one universe less what lay between them in the log. The log is
// the worst case: noise in every slot, and universes spread evenly over the 22.7 ms of a round, so that a block of the
// log is due while there is no pause of 2 ms.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "sim/dmx_log/log_output.h"
#include "sim/dmx_log/log_ports.h"
#include "sim/system_clock.h"

namespace footlight {
namespace {

constexpr DurationNs kTurnNs = 5 * kNsPerS;
constexpr DurationNs kPeriodNs = kNsPerS / 44;

// Fails loudly: a benchmark has nobody to tell.
template <class T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}\n", result.error().message);
  std::exit(1);
}

LogReader noise(DurationNs length_ns, int universes) {
  dmx_log::Bytes bytes;
  LogWriter writer = must(dmx_log::make_writer(dmx_log::memory_output(bytes, "noise"), {}));
  Slots slots;
  std::uint64_t state = 1;
  for (DurationNs round_ns = 0; round_ns < length_ns; round_ns += kPeriodNs) {
    for (int universe = 1; universe <= universes; ++universe) {
      for (auto& slot : slots) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        slot = static_cast<std::uint8_t>(state >> 56);
      }
      FrameView frame;
      frame.universe = universe;
      frame.stamp_ns = round_ns + (universe - 1) * kPeriodNs / universes;
      frame.slots = slots;
      if (!writer.append(frame)) std::exit(1);
    }
  }
  if (!writer.close(length_ns)) std::exit(1);
  return must(LogReader::open_bytes(std::move(bytes), "noise"));
}

// Takes down how late each frame was, and how far its interval was off.
class Errors final : public FrameReceiver {
 public:
  explicit Errors(Clock& clock) : clock_(clock) {}
  void receive(const FrameView& frame) override { take(frame.universe, frame.stamp_ns, clock_.now_ns()); }
  void take(Universe universe, TimeNs due_ns, TimeNs at_ns) {
    const DurationNs late_ns = at_ns - due_ns;
    late_.push_back(late_ns);
    const auto [before, first] = before_.try_emplace(universe, late_ns);
    if (!first) errors_.push_back(std::abs(late_ns - before->second));
    before->second = late_ns;
  }
  void begin_turn() { before_.clear(); }
  void print(const char* name) {
    const auto row = [](std::vector<DurationNs>& values) {
      std::sort(values.begin(), values.end());
      const auto at = [&](double part) {
        return static_cast<double>(values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))]) *
               1e-3;
      };
      return fmt::format("{:9.1f} {:9.1f} {:9.1f} {:9.1f}", at(0.5), at(0.99), at(0.999), at(1.0));
    };
    fmt::print("{:<10} {:7} frames   late, us {}   interval error, us {}\n", name, late_.size(), row(late_),
               row(errors_));
  }

 private:
  Clock& clock_;
  std::map<Universe, DurationNs> before_;
  std::vector<DurationNs> late_;
  std::vector<DurationNs> errors_;
};

// Stands still while the bare loop has its turn.
class TurnClock final : public Clock {
 public:
  TimeNs now_ns() override { return clock_.now_ns() - paused_ns; }
  void sleep_until_ns(TimeNs deadline_ns) override { clock_.sleep_until_ns(deadline_ns + paused_ns); }
  DurationNs paused_ns = 0;

 private:
  SystemClock clock_;
};

void run(int seconds, int universes) {
  TurnClock clock;
  auto source = must(LogSource::from_reader(noise(seconds * kNsPerS, universes), "noise"));
  source->start(clock.now_ns());
  Errors replay(clock);
  Errors floor(clock);
  while (source->state() != PortState::kEnded) {
    replay.begin_turn();
    const TimeNs turn_end_ns = clock.now_ns() + kTurnNs;
    std::vector<std::pair<Universe, TimeNs>> deadlines;
    while (clock.now_ns() < turn_end_ns && source->state() != PortState::kEnded) {
      const TimeNs deadline_ns = source->next_deadline_ns();
      clock.sleep_until_ns(deadline_ns);
      if (!source->poll(clock.now_ns(), replay)) std::exit(1);
      deadlines.emplace_back(static_cast<Universe>(deadlines.size() % static_cast<std::size_t>(universes)),
                             deadline_ns);
    }
    if (deadlines.empty()) break;
    const TimeNs pause_ns = clock.now_ns();
    floor.begin_turn();
    const DurationNs shift_ns = clock.now_ns() - deadlines.front().second + kNsPerMs;
    for (const auto& [universe, deadline_ns] : deadlines) {
      clock.sleep_until_ns(deadline_ns + shift_ns);
      floor.take(universe, deadline_ns + shift_ns, clock.now_ns());
    }
    clock.paused_ns += clock.now_ns() - pause_ns;
  }
  fmt::print("{} s of {} universes at 44 Hz, noise; p50, p99, p99.9, max\n", seconds, universes);
  floor.print("bare loop");
  replay.print("LogSource");
}

}  // namespace
}  // namespace footlight

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 60;
  const int universes = argc > 2 ? std::atoi(argv[2]) : 24;
  if (seconds < 1 || universes < 1 || universes > 1'000) return 2;
  footlight::run(seconds, universes);
  return 0;
}

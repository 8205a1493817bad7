#include "tests/sim/soak.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include <fmt/format.h>

#include "sim/pump.h"
#include "tests/sim/allocation_count.h"
#include "tests/support/fake_clock.h"

namespace footlight::testing {
namespace {

constexpr int kUniverses = 9;       // always present; a tenth appears and disappears
constexpr int kTag = 8;             // the first slots identify the frame: four hold a running number, one the sender
constexpr int kRoundsWaiting = 50;  // the capacity of a socket
constexpr DurationNs kBackWithinNs = 1'100 * kNsPerMs;  // a port that works again is used again within 1 s

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 2 + 1) {}
  std::uint64_t below(std::uint64_t end) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return (state_ >> 33) % end;
  }
  bool once_in(std::uint64_t times) { return below(times) == 0; }

 private:
  std::uint64_t state_;
};

using Tag = std::array<std::uint8_t, kTag>;

// One desk: a sender of a source.
struct Desk {
  SenderId id = 0;
  std::uint8_t priority = 100;
  bool claims = false;  // sends per-address priorities
  TimeNs silent_until_ns = 0;
  bool ends = false;  // its next round marks the end
  std::uint32_t number = 0;
  std::array<std::uint8_t, kSlotCountMax> levels{};
  std::array<std::uint8_t, kSlotCountMax> priorities{};
};

class SoakSource final : public Source {
 public:
  SoakSource(std::string name, std::vector<Universe> universes, std::vector<Desk> desks, DurationNs period_ns,
             TimeNs start_ns)
      : desks_of(std::move(desks)),
        next_ns(start_ns + period_ns),
        name_(std::move(name)),
        universes_(std::move(universes)),
        period_ns_(period_ns) {}

  std::string name() const override { return name_; }
  TimeNs next_deadline_ns() const override { return next_ns; }
  PortState state() const override { return PortState::kWorking; }
  PortCounters counters() const override { return {}; }
  std::span<const Universe> universes() const override { return universes_; }

  Status poll(TimeNs now_ns, FrameReceiver& receiver) override {
    if (now_ns < failing_until_ns) {
      ++failures;
      return fail(ErrorCode::kIo, "{}: scripted failure", name_);
    }
    // Rounds that waited; those beyond the socket's capacity are lost before they are delivered.
    std::int64_t due = now_ns >= next_ns ? (now_ns - next_ns) / period_ns_ + 1 : 0;
    next_ns += due * period_ns_;
    due = std::min<std::int64_t>(due + std::exchange(extra_rounds, 0), kRoundsWaiting);
    for (std::int64_t round = due - 1; round >= 0; --round)
      for (Desk& desk : desks_of) give_round(desk, now_ns - round * (period_ns_ / kRoundsWaiting), now_ns, receiver);
    return {};
  }

  std::vector<Desk> desks_of;
  TimeNs next_ns;
  TimeNs failing_until_ns = 0;
  int extra_rounds = 0;
  std::uint64_t failures = 0;
  std::array<std::uint64_t, kUniverses + 2> given{};  // per universe

 private:
  void give_round(Desk& desk, TimeNs stamp_ns, TimeNs now_ns, FrameReceiver& receiver) {
    if (now_ns < desk.silent_until_ns) return;
    ++desk.number;
    std::memcpy(desk.levels.data(), &desk.number, sizeof desk.number);
    desk.levels[4] = static_cast<std::uint8_t>(desk.id);
    FrameView frame;
    frame.sender = desk.id;
    frame.stamp_ns = stamp_ns;
    frame.sequence = desk.number;
    frame.priority = desk.priority;
    frame.terminated = std::exchange(desk.ends, false);
    if (frame.terminated) desk.silent_until_ns = now_ns + 3 * kNsPerS;
    for (const Universe universe : universes_) {
      frame.universe = universe;
      if (desk.claims && !frame.terminated && desk.number % 8 == 0) {
        FrameView claim = frame;
        claim.start_code = kStartCodePriorities;
        claim.slots = desk.priorities;
        ++given[static_cast<std::size_t>(universe)];
        receiver.receive(claim);
      }
      frame.slots = desk.levels;
      ++given[static_cast<std::size_t>(universe)];
      receiver.receive(frame);
    }
  }

  std::string name_;
  std::vector<Universe> universes_;
  DurationNs period_ns_;
};

class SoakSink final : public Sink {
 public:
  SoakSink(std::string name, std::vector<Universe> universes, double rate_hz_max, FakeClock& clock)
      : name_(std::move(name)), universes_(std::move(universes)), rate_hz_max_(rate_hz_max), clock_(clock) {}

  std::string name() const override { return name_; }
  PortState state() const override { return clock_.now_ns() < gone_until_ns ? PortState::kGone : PortState::kWorking; }
  std::string trouble() const override { return name_; }
  PortCounters counters() const override { return {}; }
  std::span<const Universe> universes() const override { return universes_; }
  double rate_hz_max() const override { return rate_hz_max_; }

  Status send(TimeNs now_ns, std::span<const FrameView> frames) override {
    ++sends;
    if (stall_ns > 0) clock_.advance_ns(std::exchange(stall_ns, 0));
    if (now_ns < failing_until_ns || now_ns < gone_until_ns) {
      ++failures;
      refused += frames.size();
      return fail(ErrorCode::kIo, "{}: scripted failure", name_);
    }
    taken += frames.size();
    for (const FrameView& frame : frames) {
      const auto u = static_cast<std::size_t>(frame.universe);
      std::copy_n(frame.slots.begin(), kTag, last[u].begin());
      sent_ns[u] = now_ns;
    }
    return {};
  }
  Status poll(TimeNs now_ns) override {
    if (now_ns >= failing_until_ns) return {};
    ++failures;
    return fail(ErrorCode::kIo, "{}: scripted failure", name_);
  }
  void rest(TimeNs) override { ++rests; }
  void close(TimeNs) override {}

  [[nodiscard]] bool in_trouble(TimeNs now_ns) const { return now_ns < std::max(failing_until_ns, gone_until_ns); }
  // Working for long enough that the pump must use it again.
  [[nodiscard]] bool settled(TimeNs now_ns) const {
    return now_ns >= std::max({failing_until_ns, gone_until_ns, added_ns}) + kBackWithinNs;
  }
  // Resets the counters when it is added to the pump again.
  void begin(TimeNs now_ns) {
    added_ns = now_ns;
    taken_before += taken;
    taken = refused = 0;
  }

  TimeNs failing_until_ns = 0;
  TimeNs gone_until_ns = 0;
  TimeNs added_ns = 0;
  DurationNs stall_ns = 0;
  std::uint64_t sends = 0;
  std::uint64_t failures = 0;
  std::uint64_t rests = 0;
  std::uint64_t taken = 0;  // since it was added
  std::uint64_t taken_before = 0;
  std::uint64_t refused = 0;
  std::array<Tag, kUniverses + 2> last{};
  std::array<TimeNs, kUniverses + 2> sent_ns{};

 private:
  std::string name_;
  std::vector<Universe> universes_;
  double rate_hz_max_;
  FakeClock& clock_;
};

// Sleeps to the deadline; there are no descriptors.
class SoakWaiter final : public Waiter {
 public:
  explicit SoakWaiter(FakeClock& clock) : clock_(clock) {}
  Status watch(int) override { return {}; }
  void unwatch(int) override {}
  int wait_until(TimeNs deadline_ns, std::span<int>) override {
    if (!std::exchange(interrupted_, false)) clock_.sleep_until_ns(deadline_ns);
    woke_ns = clock_.now_ns();
    return 0;
  }
  void interrupt() noexcept override { interrupted_ = true; }

  TimeNs woke_ns = 0;  // start of the current tick; a sink that stalls moves the clock within it

 private:
  FakeClock& clock_;
  bool interrupted_ = false;
};

class Soak {
 public:
  explicit Soak(const SoakOptions& options)
      : options_(options),
        random_(options.seed),
        period_ns_(static_cast<DurationNs>(static_cast<double>(kNsPerS) / options.rate_hz)) {
    Desk front, backup, partial;
    front.id = 1;
    front.priority = 150;
    backup.id = 2;
    partial.id = 1;  // another source uses the same id
    sources_.push_back(std::make_unique<SoakSource>("desks", universe_range(1, kUniverses + 1),
                                                    std::vector<Desk>{front, backup}, period_ns_, clock_.now_ns()));
    sources_.push_back(std::make_unique<SoakSource>("partial", universe_range(1, 3), std::vector<Desk>{partial},
                                                    period_ns_, clock_.now_ns() + period_ns_ / 3));
    const auto all = universe_range(1, kUniverses + 1);
    for (const char* name : {"free", "capped", "main", "standby", "steady"})
      sinks_.push_back(
          std::make_unique<SoakSink>(name, all, name == std::string_view("capped") ? kCapHz : 0.0, clock_));
    PumpOptions pump_options;
    pump_options.on_notice = [this](const Notice& notice) {
      ++notices_;
      if (notice.id == "standby-takes-over") ++report_.takeovers;
    };
    universes_ = std::make_shared<Universes>();
    pump_ = std::make_unique<Pump>(universes_, clock_, waiter_, pump_options);
    for (const auto& source : sources_) pump_->add_source(*source);
    for (const auto& sink : sinks_) add(*sink);
  }

  SoakReport run() {
    const TimeNs start_ns = clock_.now_ns();
    const TimeNs end_ns = start_ns + static_cast<DurationNs>(options_.hours * 3'600.0 * static_cast<double>(kNsPerS));
    TimeNs second_ns = start_ns, minute_ns = start_ns + 60 * kNsPerS, hour_ns = start_ns + 600 * kNsPerS;
    std::int64_t baseline_bytes = 0;
    pump_->start();
    while (clock_.now_ns() < end_ns && report_.offences.size() < 20) {
      bool disturbed = false;  // something that may allocate was requested
      const TimeNs now_ns = clock_.now_ns();
      if (now_ns >= second_ns) {
        second_ns = now_ns + kNsPerS;
        disturbed = disturb(now_ns);
      }
      step(disturbed);
      if (now_ns >= minute_ns) {
        minute_ns = now_ns + 60 * kNsPerS;
        check_accounts();
      }
      if (now_ns >= hour_ns) {
        const bool first = baseline_bytes == 0;
        hour_ns = now_ns + 3'600 * kNsPerS;
        const std::int64_t held_bytes = held_at_rest();
        if (first) {
          baseline_bytes = held_bytes;
        } else {
          report_.memory_growth_bytes = std::max(report_.memory_growth_bytes, held_bytes - baseline_bytes);
        }
      }
    }
    check_accounts();
    pump_->stop();
    for (const auto& source : sources_)
      for (const std::uint64_t count : source->given) report_.frames += count;
    for (const auto& sink : sinks_) {
      report_.sink_failures += sink->failures;
      report_.snapshots += sink->taken_before + sink->taken;
    }
    return report_;
  }

 private:
  static constexpr double kCapHz = 25.0;

  void add(SoakSink& sink) {
    sink.begin(clock_.now_ns());
    pump_->add_sink(sink, {.standby_for = &sink == sinks_[3].get() ? sinks_[2].get() : nullptr});
  }

  void offend(std::string text) {
    if (report_.offences.size() < 20)
      report_.offences.push_back(fmt::format("seed {}, {} ns: {}", options_.seed, clock_.now_ns(), text));
  }

  void step(bool disturbed) {
    std::uint64_t failures = 0;
    const auto count_failures = [&] {
      failures = 0;
      for (const auto& source : sources_) failures += source->failures;
      for (const auto& sink : sinks_) failures += sink->failures;
      return failures;
    };
    const std::uint64_t failures_before = count_failures(), notices_before = notices_;
    const std::uint64_t standby_sends = sinks_[3]->sends;
    const TimeNs woke_before_ns = waiter_.woke_ns;
    const std::uint64_t allocations = allocation_count();
    pump_->step();
    const std::uint64_t allocated = allocation_count() - allocations;
    ++report_.ticks;
    const bool quiet = !disturbed && count_failures() == failures_before && notices_ == notices_before;
    if (quiet && allocated != 0) offend(fmt::format("a quiet tick allocated {} times", allocated));
    const TimeNs now_ns = waiter_.woke_ns;
    // Settled at the last tick: after a jump, waiting rounds are sent before the main's state is read.
    if (!disturbed && sinks_[3]->sends != standby_sends && sinks_[2]->settled(woke_before_ns))
      offend("the standby was fed though its main works");
    check_looks(now_ns);
  }

  void check_looks(TimeNs now_ns) {
    std::array<std::uint8_t, kSlotCountMax> levels;
    FrameStamp stamp;
    constexpr auto kCapPeriodNs = static_cast<DurationNs>(static_cast<double>(kNsPerS) / kCapHz) + 1;
    for (int index = 0; index < universes_->count(); ++index) {
      universes_->snapshot(index, levels, stamp);
      if (stamp.revision == 0) continue;
      const Universe universe = universes_->numbers()[static_cast<std::size_t>(index)];
      const auto u = static_cast<std::size_t>(universe);
      const auto has = [&](std::size_t sink) {
        return std::equal(sinks_[sink]->last[u].begin(), sinks_[sink]->last[u].end(), levels.begin());
      };
      const auto fit = [&](std::size_t sink) { return sinks_[sink]->settled(now_ns); };
      if (!has(4)) offend(fmt::format("universe {}: the steady sink is stale", universe));
      if (fit(0) && !has(0)) offend(fmt::format("universe {}: the free sink is stale", universe));
      if (fit(1) && !has(1) && now_ns - sinks_[1]->sent_ns[u] > kCapPeriodNs)
        offend(fmt::format("universe {}: the capped sink is stale", universe));
      if (fit(2) && !has(2)) offend(fmt::format("universe {}: the main sink is stale", universe));
      if (!fit(2) && fit(3) && !has(2) && !has(3))
        offend(fmt::format("universe {}: neither main nor standby has the snapshot", universe));
    }
  }

  void check_accounts() {
    ++report_.minutes_checked;
    const PumpStatus status = pump_->status();
    for (const UniverseStatus& universe : status.universes) {
      if (unaccounted(universe) != 0)
        offend(fmt::format("universe {}: {} frames unaccounted for", universe.universe, unaccounted(universe)));
      if (universe.universe > kUniverses) continue;  // starts again each time that it appears
      std::uint64_t given = 0;
      for (const auto& source : sources_) given += source->given[static_cast<std::size_t>(universe.universe)];
      if (given != universe.merge.frames)
        offend(
            fmt::format("universe {}: {} frames given, {} counted", universe.universe, given, universe.merge.frames));
    }
    for (const PortStatus& port : status.ports) {
      if (unaccounted(port) != 0) offend(fmt::format("{}: {} snapshots unaccounted for", port.name, unaccounted(port)));
      for (const auto& sink : sinks_) {
        if (sink->name() != port.name) continue;
        if (port.frames != sink->taken || port.refused != sink->refused)
          offend(fmt::format("{}: took {} snapshots and refused {}; counted are {} and {}", port.name, sink->taken,
                             sink->refused, port.frames, port.refused));
      }
      if (port.name == "steady" && port.frames != port.snapshots)
        offend(fmt::format("the sink that never fails got {} of {} snapshots", port.frames, port.snapshots));
    }
  }

  // Causes a fault about once a second. True: the next step may allocate.
  bool disturb(TimeNs now_ns) {
    const auto for_ns = [&](std::uint64_t ms_max) { return static_cast<DurationNs>(random_.below(ms_max)) * kNsPerMs; };
    SoakSource& source = *sources_[random_.below(sources_.size())];
    Desk& desk = source.desks_of[random_.below(source.desks_of.size())];
    SoakSink& sink = *sinks_[random_.below(4)];  // all except the steady one
    bool disturbed = false;
    switch (random_.below(20)) {
      case 0:
        ++report_.silences;
        desk.silent_until_ns = now_ns + for_ns(8'000);
        break;
      case 1:
        ++report_.endings;
        desk.ends = true;
        break;
      case 2:
      case 3:
        ++report_.bursts;
        source.extra_rounds = static_cast<int>(1 + random_.below(10));
        break;
      case 4:
        ++report_.priority_changes;
        desk.priority = static_cast<std::uint8_t>(random_.once_in(20) ? 201 : 99 + random_.below(3) * 50);
        break;
      case 5:
        ++report_.claim_changes;
        desk.claims = !random_.once_in(3);
        for (std::uint8_t& priority : desk.priorities)
          priority = static_cast<std::uint8_t>(random_.once_in(3) ? 0 : 98 + random_.below(4));
        break;
      case 6:
        ++report_.source_failures;
        source.failing_until_ns = now_ns + for_ns(3'000);
        break;
      case 7:
      case 8: sink.failing_until_ns = now_ns + for_ns(5'000); break;
      case 9: sink.gone_until_ns = now_ns + for_ns(5'000); break;
      case 10:
        ++report_.stalls;
        sink.stall_ns = for_ns(300);
        break;
      case 11:
        ++report_.jumps;
        clock_.advance_ns(for_ns(random_.once_in(20) ? 30'000 : 500));
        break;
      case 12:
        if (random_.once_in(5)) {
          ++report_.reloads;
          reload(false);
          disturbed = true;
        }
        break;
      default: break;  // sometimes no fault
    }
    return disturbed;
  }

  // Another set of universes, other modes, a port that is removed and added.
  void reload(bool plain) {
    pump_->call([this, plain] {
      const int count = plain ? kUniverses : kUniverses + static_cast<int>(random_.below(2));
      universes_ = std::make_shared<Universes>(universe_range(1, count));
      MergeOptions merge;
      if (!plain && random_.once_in(3))
        merge.timeout_ns = kNsPerS + static_cast<DurationNs>(random_.below(3)) * kNsPerS;
      pump_->move_to(universes_, merge);
      if (plain) return;
      const auto some_universe = [this] { return static_cast<Universe>(1 + random_.below(kUniverses)); };
      for (std::uint64_t k = random_.below(3); k > 0; --k) pump_->set_mode(some_universe(), MergeMode::kLtp);
      for (std::uint64_t k = random_.below(3); k > 0; --k) {
        SlotSet slots;
        for (std::size_t slot = 0; slot < slots.size(); ++slot) slots[slot] = random_.once_in(2);
        pump_->set_slot_modes(some_universe(), slots);
      }
      if (random_.once_in(2)) {
        SoakSource& source = *sources_[random_.below(sources_.size())];
        pump_->remove_source(source);
        pump_->add_source(source);
      } else {
        // The standby is added after its main, so it is removed with it.
        const std::size_t number = random_.below(3);
        const std::size_t end = number == 2 ? 4 : number + 1;
        for (std::size_t k = end; k-- > number;) pump_->remove_sink(*sinks_[k]);
        for (std::size_t k = number; k < end; ++k) add(*sinks_[k]);
      }
    });
  }

  // The memory held without a fault: the same each time, or something grows.
  std::int64_t held_at_rest() {
    for (int twice = 0; twice < 2; ++twice) {  // the second has nothing left of the earlier modes
      reload(true);
      step(true);
    }
    return live_bytes();
  }

  SoakOptions options_;
  Random random_;
  DurationNs period_ns_;
  FakeClock clock_;
  SoakWaiter waiter_{clock_};
  std::shared_ptr<Universes> universes_;
  std::vector<std::unique_ptr<SoakSource>> sources_;
  std::vector<std::unique_ptr<SoakSink>> sinks_;
  std::unique_ptr<Pump> pump_;
  std::uint64_t notices_ = 0;
  SoakReport report_;
};

}  // namespace

SoakReport run_soak(const SoakOptions& options) { return Soak(options).run(); }

}  // namespace footlight::testing

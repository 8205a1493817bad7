// The pump: sources -> merge -> universes -> sinks. One loop on one thread; it knows ports, a clock and a waiter,
// nothing of networks or devices.
//
//   Pump pump(universes, clock, waiter);
//   pump.add_source(*sacn);
//   pump.add_sink(*dongle);
//   pump.run();                       // until request_stop(), which a signal handler may call
//
// What it promises:
// - A sink without a rate cap gets every frame that wins, in the order in which they came: as soon as they are read,
//   one call per wake-up with all universes of it. Where a wake-up finds a second frame of one sender and universe (a
//   desk that is faster than the wake-ups, a machine that stood still), everything before it is merged and sent first,
//   so that each round of a desk is a call. Nothing is queued. Repeats of an unchanged look are passed on as well.
// - A sink with a cap gets the newest look at most rate_hz_max() times a second per universe (sim/pace.h); looks that a
//   newer one replaces are counted.
// - Every frame is accounted for: see UniverseStatus, PortStatus and unaccounted().
// - A sink gets every look that there is when the pump starts and when the sink comes back after having been gone.
//   Keep-alives in between are the sink's own business: next_deadline_ns() and poll().
// - When a sender or a source vanishes, the last look stays (sim/merge.h).
// - A port that fails is said once, stays listed as kGone and is polled again at its own deadline, though not within 10
//   ms; one that keeps failing is left alone for longer, up to 1 s; one that names no deadline is tried every second.
//   The others go on meanwhile. A port that comes back is said once.
// - A sink that stands by for another one (SinkRole) gets nothing while that one works, and every look of its universes
//   in the tick in which that one is found lost. It rests again (Sink::rest) when that one has taken its looks. Both is
//   said.
// - stop() sends what a rate cap has held back and closes every sink. run() ends with it; who calls start() calls
//   stop().
//
// Ports: poll_fd() may change whenever a port was kGone in between; otherwise it stays the same. A descriptor that
// wakes the pump while its port stays kGone is not listened to again before the port's next deadline. Two ports may
// share a descriptor; both are then polled. A source that is kEnded is not polled again.
//
// Ports and universes may change while it runs, on the pump's thread and between two ticks; call() leads there:
//
//   pump.call([&] {                                  // from any thread; everything was opened before, on that thread
//     pump.move_to(new_universes, merge_options);    // where the set of universes or how they are merged changes
//     pump.remove_source(old_source);
//     pump.add_source(new_source);                   // the ports that are not named stay as they are
//   });
//
// Frames that come meanwhile wait in their ports. A port that replaces one of the same wire is added before the other
// is removed or closed, so that it hears what the other no longer does.
//
// Threads: everything runs on the thread that calls run(), or start(), step() and stop(). Other threads may read the
// Universes, and call call(), request_stop(), latest_status() and universes().
//
// Cost: after start() a tick makes no system call, takes no lock and allocates nothing, unless a port fails or comes
// back; once every status_period_ns it copies out what it has counted, if somebody has asked.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/histogram.h"
#include "sim/core/notice.h"
#include "sim/core/ports.h"
#include "sim/merge.h"
#include "sim/pace.h"
#include "sim/universes.h"
#include "sim/wait.h"

namespace footlight {

struct PumpOptions {
  // All optional.
  MergeOptions merge;
  bool stop_at_end = false;               // run() returns when every source is kEnded (a replay)
  DurationNs status_period_ns = kNsPerS;  // over which rates are measured; > 0
  // Told when something out of the ordinary happens: a port lost or back, a sender refused. Called on the pump's
  // thread.
  NoticeReceiver say;
};

// Quantiles to within 1/8 of their value, the largest exactly (sim/core/histogram.h). All 0 where count is 0.
inline constexpr int kTimingPowerFirst = 14;
inline constexpr int kTimingPowerCount = 14;

struct Timing {
  std::uint64_t count = 0;
  std::uint64_t sum_ns = 0;
  DurationNs p50_ns = 0;
  DurationNs p99_ns = 0;
  DurationNs max_ns = 0;
  // How many were shorter than 2^(14 + k) ns: 16 us, 33 us, ... 134 ms. Exact.
  std::array<std::uint64_t, kTimingPowerCount> below{};
};

// A source gives frames, a sink gets looks: every look made of a universe that it carries, and every look there is when
// it starts, comes back or takes over, but none while it stands by.
struct PortUniverseStatus {
  Universe universe = 0;
  std::uint64_t frames = 0;  // source: received from it; sink: handed to it
  // Of those, over the last status period. A sink that times its line itself, with one universe: frames that left.
  double rate_hz = 0.0;
  // Sinks only; looks == frames + replaced + refused + waiting.
  std::uint64_t snapshots = 0;  // meant for it
  std::uint64_t replaced = 0;   // by a newer one before it was handed over (rate cap, or gone), or taken back (standby)
  std::uint64_t refused = 0;    // handed over in a call that failed
  std::uint64_t waiting = 0;    // 0 or 1: held back by the rate cap, or until it is back
};

struct PortStatus {
  std::string name;
  bool is_sink = false;
  bool stands_by = false;                 // it is fed only when another sink is lost, and that one is not
  std::string standby_for;                // the name of that other sink; empty: it stands by for none
  PortState state = PortState::kWaiting;  // kGone also for a port whose last call failed
  std::string trouble;                    // why it is kGone; empty otherwise
  PortCounters port;                      // what the port itself counts
  // Sum over its universes, as of what follows. A sink without universes takes its frames by itself, as a recorder with
  // a tap does: then its own count.
  std::uint64_t frames = 0;
  double rate_hz = 0.0;
  std::uint64_t snapshots = 0;
  std::uint64_t replaced = 0;
  std::uint64_t refused = 0;
  std::uint64_t waiting = 0;
  std::uint64_t unrouted = 0;  // source: frames of universes that it did not announce or that the buffer has not
  std::uint64_t failures = 0;  // calls that returned an error
  Timing lateness;             // of calls that were asked for at a deadline, or held back by the rate cap
  Timing latency;              // sink: from the stamp of the frame to the return of the call that handed it over
  std::vector<PortFigure> figures;
  std::vector<PortUniverseStatus> universes;
};

struct SenderStatus {
  std::string name;  // what its source calls it (Source::sender_text), else the name of the source's port
  SenderId id = 0;
  std::uint8_t priority = kPriorityDefault;
  DurationNs age_ns = 0;     // of its last levels
  double rate_hz = 0.0;      // of its levels, over the last status period
  bool wins = false;         // some of its levels are in the look
  bool per_address = false;  // it sends a priority for each address
  SenderLosses losses;       // as its source counts (Source::sender_losses)
};

struct UniverseStatus {
  Universe universe = 0;
  FrameStamp newest;
  std::uint8_t priority = kPriorityDefault;  // of the winners
  double rate_hz = 0.0;                      // writes, over the last status period
  std::uint64_t writes = 0;                  // looks made
  int winners = 0;                           // senders that share the highest priority
  MergeCounters merge;
  std::vector<SenderStatus> senders;  // known at the moment; the highest priority first
};

// How many frames or looks are in no counter, or in two: 0. Exact where the status was taken between two ticks, as
// status() and latest_status() do.
[[nodiscard]] std::int64_t unaccounted(const UniverseStatus& universe);
[[nodiscard]] std::int64_t unaccounted(const PortStatus& port);

struct PumpStatus {
  TimeNs stamp_ns = 0;  // when this was true; 0: the pump has not started
  std::uint64_t ticks = 0;
  std::vector<PortStatus> ports;  // sources, then sinks, each in the order in which they were added
  std::vector<UniverseStatus> universes;
};

struct SinkRole {
  // Optional: fed only while that one is lost. It was added before, to the same pump. Where it stands by itself, it has
  // to be lost as well as the one before it.
  const Sink* standby_for = nullptr;
};

class Pump {
 public:
  // All three outlive the pump. The pump is the one writer of every universe.
  Pump(Universes& universes, Clock& clock, Waiter& waiter, PumpOptions options = {});
  Pump(std::shared_ptr<Universes> universes, Clock& clock, Waiter& waiter, PumpOptions options = {});
  Pump(const Pump&) = delete;
  Pump& operator=(const Pump&) = delete;

  // Before start() or between two ticks. The ports outlive the pump, or are removed.
  void add_source(Source& source);
  void add_sink(Sink& sink, SinkRole role = {});
  // Between two ticks, or while stopped. Its senders are forgotten: whoever is left has the universes, else the looks
  // stay.
  void remove_source(Source& source);
  // As above. Sends it what a rate cap has held back and closes it. Who stood by for it stands by for the sink that it
  // stood by for or, where there is none, is fed from now on.
  void remove_sink(Sink& sink);
  // Sees every frame of every source as it came, before the merge, also those that lose or have no universe here (a
  // recorder). Called on the pump's thread; outlives the pump, or is removed. Both between two ticks.
  void add_tap(FrameReceiver& tap);
  void remove_tap(FrameReceiver& tap);
  // Before start() or between two ticks: LTP for one universe, which the buffer has.
  void set_mode(Universe universe, MergeMode mode);
  // Likewise: HTP, but LTP for these slots.
  void set_slot_modes(Universe universe, const SlotSet& ltp);

  // Between two ticks: goes on with another buffer, which may have other universes. Looks, senders and counters of
  // those that both have are taken over; frames of universes that are no more are unrouted from now on. Modes are those
  // of `merge`. Readers go over on their own: the old buffer gets no more writes, and universes() gives the new one.
  void move_to(std::shared_ptr<Universes> universes, const MergeOptions& merge);
  // The buffer that is being written. Any thread. A reader that keeps the pointer may go on reading it.
  [[nodiscard]] std::shared_ptr<const Universes> universes() const;

  // Any thread: has the pump's thread call `job` between two ticks, as soon as it can; jobs keep their order. Those
  // that wait when the pump stops are called by stop(), ahead of everything else.
  void call(std::function<void()> job);

  // start(), step() until request_stop() (or the end of all sources, see PumpOptions), stop().
  void run();
  // Any thread, and signal handlers. Before run(): run() starts, stops and returns.
  void request_stop() noexcept;

  // The parts of run(), for tests and for mains with a loop of their own.
  void start();
  bool step();  // one wait and one tick; false: it is time to stop()
  void tick(TimeNs now_ns);
  void stop();

  // On the pump's thread.
  [[nodiscard]] PumpStatus status() const;
  // Any thread: as it was at the end of the last status period in which somebody had asked, so that asking every second
  // gives what is one or two periods old. Never waits for the pump.
  [[nodiscard]] PumpStatus latest_status() const;

 private:
  // What the pump keeps beside each universe of a port.
  struct Lane {
    Universe universe = 0;
    int index = -1;  // in the buffer; -1: the buffer has no such universe, or an earlier lane has it
    std::uint64_t frames = 0;
    std::uint64_t frames_before = 0;  // at the begin of this status period
    double rate_hz = 0.0;
    // Sinks only.
    std::uint64_t snapshots = 0;
    std::uint64_t replaced = 0;
    std::uint64_t refused = 0;
    std::uint8_t flags = 0;  // of the look that waits
    Pace pace;
  };

  // What the pump keeps beside each port.
  struct PortRun {
    Port* port = nullptr;
    Source* source = nullptr;  // one of the two
    Sink* sink = nullptr;
    std::string name;
    SourceId source_id = 0;  // of its senders, in the merge

    bool ready = false;   // its descriptor is readable
    bool down = false;    // it failed or says kGone
    bool failed = false;  // its last call returned an error
    bool lost = false;    // it was down, and has done no work since; people know
    bool muted = false;   // its descriptor is not listened to: see "Ports" above
    int watched_fd = -1;
    TimeNs polled_ns = 0;
    TimeNs armed_ns = kTimeNever;  // the deadline that the last wait knew of
    DurationNs retry_ns = 0;       // while failed: how long it is left alone
    std::string trouble;

    std::vector<Lane> lanes;         // as it names its universes
    std::vector<int> lane_of_index;  // -1: it does not carry it
    std::uint64_t unrouted = 0;
    std::uint64_t failures = 0;
    std::uint64_t own_frames_before = 0;  // sink without universes: what it counted itself
    double own_rate_hz = 0.0;
    Histogram lateness;
    Histogram latency;

    // Sinks only.
    const Sink* standby_for = nullptr;
    bool resting = false;               // the one that it stands by for works
    double period_ns = 0.0;             // 0: no cap
    TimeNs held_until_ns = kTimeNever;  // when the first look that the cap holds back is due
    std::vector<int> pending;           // lanes to be sent
    std::vector<FrameView> batch;       // of the call under way
    std::vector<int> batch_lanes;       // beside it
    // Sink::frames_on_line() at the begin of this status period.
    std::optional<std::uint64_t> line_frames_before;
  };

  // Takes the frames of the source that is being polled.
  class Inlet final : public FrameReceiver {
   public:
    explicit Inlet(Pump& pump) : pump_(pump) {}
    void receive(const FrameView& frame) override;
    PortRun* run = nullptr;
    TimeNs now_ns = 0;

   private:
    Pump& pump_;
  };

  void run_jobs();
  void attach(PortRun& run, TimeNs now_ns);
  void detach(PortRun& run);
  void add(PortRun& run, std::span<const Universe> universes);
  void find_lanes(PortRun& run) const;
  void take_from_buffer(int index);

  void receive_ready(TimeNs now_ns);
  void pass_on(TimeNs now_ns);
  void merge_changed();
  void send_due(TimeNs now_ns);
  void count_rates(TimeNs now_ns);

  void poll(PortRun& run, TimeNs now_ns);
  void send_pending(PortRun& run, TimeNs now_ns, bool ignore_cap = false);
  void mark_pending(PortRun& run, int lane, std::uint8_t flags);
  void mark_every_snapshot(PortRun& run);
  void set_standbys(TimeNs now_ns);
  [[nodiscard]] const PortRun* run_of(const Sink* sink) const;
  void settle(PortRun& run, const Status& result, TimeNs now_ns);
  void say_lost(PortRun& run, const std::string& why, TimeNs now_ns);
  void say_back(PortRun& run, TimeNs now_ns);
  void watch(PortRun& run, bool again, TimeNs now_ns);
  void record_lateness(PortRun& run, TimeNs deadline_ns, TimeNs now_ns);
  void say(NoticeLevel level, std::string_view id, const PortRun& run, const std::string& text,
           Universe universe = 0) const;
  [[nodiscard]] bool is_watched(int fd) const;
  [[nodiscard]] TimeNs deadline_of(const PortRun& run) const;
  [[nodiscard]] bool is_due(const PortRun& run, TimeNs now_ns) const;
  [[nodiscard]] TimeNs next_deadline_ns();
  void fill(PumpStatus& status, TimeNs now_ns) const;
  void fill(PortStatus& port, const PortRun& run) const;
  void fill(UniverseStatus& universe, int index, TimeNs now_ns) const;

  std::shared_ptr<Universes> universes_;  // replaced under published_mutex_
  Clock& clock_;
  Waiter& waiter_;
  PumpOptions options_;
  Merge merge_;
  Inlet inlet_;
  std::vector<PortRun> sources_;
  std::vector<PortRun> sinks_;
  std::vector<FrameReceiver*> taps_;
  SourceId last_source_id_ = 0;
  bool in_tick_ = false;

  struct UniverseRun {
    bool has_snapshot = false;  // a frame was written since the buffer was made
    bool said_full = false;     // people know that a sender was refused
    bool said_priority = false;
    bool heard = false;  // a frame came since the last look
    std::uint64_t writes = 0;
    std::uint64_t writes_before = 0;
    double rate_hz = 0.0;
  };
  std::vector<UniverseRun> universe_runs_;

  std::vector<int> ready_fds_;
  std::uint64_t ticks_ = 0;
  TimeNs tick_ns_ = INT64_MIN;  // of the last tick
  TimeNs rates_since_ns_ = 0;
  bool started_ = false;
  std::atomic<bool> stop_requested_{false};

  std::atomic<bool> has_jobs_{false};
  std::mutex jobs_mutex_;
  std::vector<std::function<void()>> jobs_;  // guarded by jobs_mutex_

  mutable std::atomic<bool> status_wanted_{false};
  PumpStatus spare_status_;  // filled here, then swapped with published_
  mutable std::mutex published_mutex_;
  PumpStatus published_;  // guarded by published_mutex_
};

}  // namespace footlight

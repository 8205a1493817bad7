// The pump: sources -> merge -> universes -> sinks. One loop on one thread; it knows ports, a clock and a waiter,
// nothing of networks or devices.
//
//   Pump pump(universes, clock, waiter);
//   pump.add_source(*sacn);
//   pump.add_sink(*dongle);
//   pump.run();                       // until request_stop(), which a signal handler may call
//
// What it promises:
// - The newest frame wins. Frames that come faster than they are used replace each other and are counted, never queued.
// - A sink is called as soon as a universe that it carries gets a frame, once per wake-up with all those universes, and
//   at most rate_hz_max() times a second per universe (sim/pace.h). Repeats of an unchanged look are passed on as well.
// - A sink gets every look that there is when the pump starts and when the sink comes back after having been gone.
//   Keep-alives in between are the sink's own business: next_deadline_ns() and poll().
// - When a sender or a source vanishes, the last look stays (sim/merge.h).
// - A port that fails is said once, stays listed as kGone and is polled again at its own deadline, though not within 10
//   ms; one that keeps failing is left alone for longer, up to 1 s; one that names no deadline is tried every second.
//   The others go on meanwhile. A port that comes back is said once.
// - stop() sends what a rate cap has held back and closes every sink. run() ends with it; who calls start() calls
//   stop().
//
// Ports: poll_fd() may change whenever a port was kGone in between; otherwise it stays the same. A descriptor that
// wakes the pump while its port stays kGone is not listened to again before the port's next deadline. Two ports may
// share a descriptor; both are then polled. A source that is kEnded is not polled again.
//
// Threads: everything runs on the thread that calls run(), or start(), step() and stop(). Other threads may read the
// Universes, and call request_stop() and latest_status().
//
// Cost: after start() a tick makes no system call, takes no lock and allocates nothing, unless a port fails or comes
// back; once every status_period_ns it copies out what it has counted, if somebody has asked.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
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

struct PortUniverseStatus {
  Universe universe = 0;
  std::uint64_t frames = 0;  // source: received from it; sink: handed to it
  double rate_hz = 0.0;      // of those, over the last status period
};

struct PortStatus {
  std::string name;
  bool is_sink = false;
  PortState state = PortState::kWaiting;  // kGone also for a port whose last call failed
  std::string trouble;                    // why it is kGone; empty otherwise
  PortCounters port;                      // what the port itself counts
  std::uint64_t frames = 0;               // sum over its universes
  double rate_hz = 0.0;                   // sum over its universes
  std::uint64_t replaced = 0;  // sink: looks replaced by a newer one before they were handed over (rate cap, or gone)
  std::uint64_t unrouted = 0;  // source: frames of universes that it did not announce or that the buffer has not
  std::uint64_t failures = 0;  // calls that returned an error
  Timing lateness;             // of calls that were asked for at a deadline, or held back by the rate cap
  Timing latency;              // sink: from the stamp of the frame to the return of the call that handed it over
  std::vector<PortUniverseStatus> universes;
};

struct UniverseStatus {
  Universe universe = 0;
  FrameStamp newest;
  std::uint8_t priority = kPriorityDefault;  // of the winners
  double rate_hz = 0.0;                      // writes, over the last status period
  std::uint64_t writes = 0;
  int senders = 0;  // known at the moment
  int winners = 0;  // that share the highest priority
  MergeCounters merge;
};

struct PumpStatus {
  TimeNs stamp_ns = 0;  // when this was true; 0: the pump has not started
  std::uint64_t ticks = 0;
  std::vector<PortStatus> ports;  // sources, then sinks, each in the order in which they were added
  std::vector<UniverseStatus> universes;
};

class Pump {
 public:
  // All three outlive the pump. The pump is the one writer of every universe.
  Pump(Universes& universes, Clock& clock, Waiter& waiter, PumpOptions options = {});
  Pump(const Pump&) = delete;
  Pump& operator=(const Pump&) = delete;

  // Before start(). The ports outlive the pump.
  void add_source(Source& source);
  void add_sink(Sink& sink);
  // Sees every frame of every source as it came, before the merge, also those that lose or have no universe here (a
  // recorder). Called on the pump's thread; outlives the pump.
  void add_tap(FrameReceiver& tap);
  // Before start(): LTP for one universe.
  void set_mode(Universe universe, MergeMode mode);

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
  // What the pump keeps beside each port.
  struct PortRun {
    Port* port = nullptr;
    Source* source = nullptr;  // one of the two
    Sink* sink = nullptr;
    std::string name;

    bool ready = false;      // its descriptor is readable
    bool down = false;       // it failed or says kGone
    bool failed = false;     // its last call returned an error
    bool said_down = false;  // people know
    bool muted = false;      // its descriptor is not listened to: see "Ports" above
    int watched_fd = -1;
    TimeNs polled_ns = 0;
    TimeNs armed_ns = kTimeNever;  // the deadline that the last wait knew of
    DurationNs retry_ns = 0;       // while failed: how long it is left alone
    std::string trouble;

    std::vector<Universe> universes;           // as it names them; the k-th has position k
    std::vector<int> index_of_position;        // in the buffer; -1: the buffer has no such universe
    std::vector<int> position_of_index;        // -1: it does not carry it
    std::vector<std::uint64_t> frames;         // per position
    std::vector<std::uint64_t> frames_before;  // at the begin of this status period
    std::vector<double> rates_hz;
    std::uint64_t replaced = 0;
    std::uint64_t unrouted = 0;
    std::uint64_t failures = 0;
    Histogram lateness;
    Histogram latency;

    // Sinks only.
    double period_ns = 0.0;                   // 0: no cap
    TimeNs held_until_ns = kTimeNever;        // when the first look that the cap holds back is due
    std::vector<int> pending;                 // positions to be sent
    std::vector<std::uint8_t> pending_flags;  // per position
    std::vector<Pace> paces;                  // per position
    std::vector<FrameView> batch;             // of the call under way
    std::vector<int> batch_positions;         // beside it
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

  PortRun make_run(Port& port, std::span<const Universe> universes) const;

  void receive_ready(TimeNs now_ns);
  void merge_changed(TimeNs now_ns);
  void send_due(TimeNs now_ns);
  void count_rates(TimeNs now_ns);

  void poll(PortRun& run, TimeNs now_ns);
  void send_pending(PortRun& run, TimeNs now_ns, bool ignore_cap = false);
  void mark_pending(PortRun& run, int position, std::uint8_t flags);
  void mark_every_look(PortRun& run);
  void settle(PortRun& run, const Status& result, TimeNs now_ns);
  void say_back(PortRun& run);
  void watch(PortRun& run, bool again);
  void record_lateness(PortRun& run, TimeNs deadline_ns, TimeNs now_ns);
  void say(NoticeLevel level, std::string_view id, const PortRun& run, const std::string& text,
           Universe universe = 0) const;
  [[nodiscard]] TimeNs deadline_of(const PortRun& run) const;
  [[nodiscard]] bool is_due(const PortRun& run, TimeNs now_ns) const;
  [[nodiscard]] TimeNs next_deadline_ns();
  void fill(PumpStatus& status, TimeNs now_ns) const;

  Universes& universes_;
  Clock& clock_;
  Waiter& waiter_;
  PumpOptions options_;
  Merge merge_;
  Inlet inlet_;
  std::vector<PortRun> sources_;
  std::vector<PortRun> sinks_;
  std::vector<FrameReceiver*> taps_;

  struct UniverseRun {
    bool has_look = false;   // a frame was written since the buffer was made
    bool said_full = false;  // people know that a sender was refused
    bool said_priority = false;
    std::uint64_t heard_tick = 0;  // in which the last frame came
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

  mutable std::atomic<bool> status_wanted_{false};
  PumpStatus spare_status_;  // filled here, then swapped with published_
  mutable std::mutex published_mutex_;
  PumpStatus published_;  // guarded by published_mutex_
};

}  // namespace footlight

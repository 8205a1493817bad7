// The pump: sources -> merge -> universes -> sinks. One loop on one thread. It depends on ports, a clock and a waiter,
// not on networks or devices.
//
//   Pump pump(universes, clock, waiter);
//   pump.add_source(*sacn);
//   pump.add_sink(*dongle);
//   pump.run();                       // until request_stop(), which a signal handler may call
//
// Guarantees:
// - A sink without a rate cap gets every winning frame, in the order of arrival, as soon as it is read: one call per
//   wake-up with all its universes. If a wake-up finds a second frame of one sender and universe (a desk faster than
//   the wake-ups, a machine that was stopped), everything before that frame is merged and sent first. So each round of
//   a desk is one call. Nothing is queued. Repeats of an unchanged snapshot are sent as well.
// - A sink with a cap gets the newest snapshot at most rate_hz_max() times a second per universe (sim/pace.h).
//   Snapshots that a newer one replaces are counted.
// - Every frame is counted: see UniverseStatus, PortStatus and unaccounted().
// - A sink gets every existing snapshot when the pump starts and when the sink returns from kGone. Keep-alives between
//   frames are the sink's own task: next_deadline_ns() and poll().
// - The last snapshot stays when a sender or a source disappears (sim/merge.h).
// - A failed port is reported once, is listed as kGone and is polled again at its own deadline, but not within 10 ms.
//   While it keeps failing the pause grows to at most 1 s. A port without a deadline is polled every second. The other
//   ports continue. A port that returns is reported once.
// - A standby sink (SinkRole) gets nothing while its main sink works. It gets every snapshot of its universes in the
//   tick in which the main sink is found lost. It rests again (Sink::rest) when the main sink has sent its snapshots.
//   Both changes are reported.
// - stop() sends what a rate cap has held back and closes every sink. run() calls stop() at its end. A caller of
//   start() must call stop().
//
// Ports: poll_fd() may change only while the port is kGone. If a descriptor wakes the pump while its port stays kGone,
// it is not watched again before the port's next deadline. Two ports may share a descriptor; both are then polled. A
// source that is kEnded is not polled again.
//
// Ports and universes may change while the pump runs, on its thread and between two ticks, through call():
//
//   pump.call([&] {                                  // from any thread; everything was opened before, on that thread
//     pump.move_to(new_universes, merge_options);    // if the set of universes or their merge options change
//     pump.remove_source(old_source);
//     pump.add_source(new_source);                   // other ports are not affected
//   });
//
// Frames that arrive in between wait in their ports. Add a port before removing or closing the one that it replaces on
// the same wire, so that no frame is missed.
//
// Threads: everything runs on the thread that calls run(), or start(), step() and stop(). Other threads may read the
// Universes, and call call(), request_stop(), latest_status() and universes().
//
// Cost: after start() a tick makes no system call, takes no lock and allocates nothing, unless a port fails or returns.
// Once every status_period_ns it copies its counters if a caller has requested a status.
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
  DurationNs status_period_ns = kNsPerS;  // time over which rates are measured; > 0
  // Receives notices of unusual events: a port lost or back, a sender refused. Called on the pump's thread.
  NoticeReceiver on_notice;
};

// Quantiles to within 1/8 of their value, the maximum exactly (sim/core/histogram.h). All 0 if count is 0.
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

// A source delivers frames; a sink gets snapshots. A sink gets every snapshot made of its universes, and every existing
// one when it starts, returns or takes over, but none while it is on standby.
struct PortUniverseStatus {
  Universe universe = 0;
  std::uint64_t frames = 0;  // source: received from it; sink: passed to it
  // Of those, over the last status period. For a sink with one universe that times its line itself: frames sent on the
  // line.
  double rate_hz = 0.0;
  // Sinks only; snapshots == frames + replaced + refused + waiting.
  std::uint64_t snapshots = 0;  // due to this sink
  std::uint64_t replaced = 0;   // by a newer one before it was sent (rate cap, or gone), or withdrawn (standby)
  std::uint64_t refused = 0;    // passed in a call that failed
  std::uint64_t waiting = 0;    // 0 or 1: held back by the rate cap, or until the sink returns
};

struct PortStatus {
  std::string name;
  bool is_sink = false;
  bool standby = false;                   // receives no frames now, because its main sink works
  std::string standby_for;                // the name of its main sink; empty: it is no standby
  PortState state = PortState::kWaiting;  // kGone also for a port whose last call failed
  std::string trouble;                    // why it is kGone; empty otherwise
  PortCounters port;                      // what the port itself counts
  // Sums over its universes, as described above. A sink without universes takes its frames itself, as a recorder with a
  // tap does: then the sink's own count.
  std::uint64_t frames = 0;
  double rate_hz = 0.0;
  std::uint64_t snapshots = 0;
  std::uint64_t replaced = 0;
  std::uint64_t refused = 0;
  std::uint64_t waiting = 0;
  std::uint64_t unrouted = 0;  // source: frames of universes that it did not announce or that the buffer does not have
  std::uint64_t failures = 0;  // calls that returned an error
  Timing lateness;             // of calls that had a deadline or were held back by the rate cap
  Timing latency;              // sink: from the stamp of the frame to the return of the call that sent it
  std::vector<PortFigure> figures;
  std::vector<PortUniverseStatus> universes;
};

struct SenderStatus {
  std::string name;  // from its source (Source::sender_text), else the name of the source's port
  SenderId id = 0;
  std::uint8_t priority = kPriorityDefault;
  DurationNs age_ns = 0;     // of its last levels
  double rate_hz = 0.0;      // of its levels, over the last status period
  bool wins = false;         // some of its levels are in the snapshot
  bool per_address = false;  // it sends a priority for each address
  SenderLosses losses;       // as its source counts them (Source::sender_losses)
};

struct UniverseStatus {
  Universe universe = 0;
  FrameStamp newest;
  std::uint8_t priority = kPriorityDefault;  // of the winners
  double rate_hz = 0.0;                      // writes, over the last status period
  std::uint64_t writes = 0;                  // snapshots made
  int winners = 0;                           // senders that share the highest priority
  MergeCounters merge;
  std::vector<SenderStatus> senders;  // active now; the highest priority first
  // If several of them win, which have set each slot: 512 of them, as Merge::slot_senders() with bits by the order of
  // `senders`. Else empty.
  std::vector<std::uint8_t> slot_senders;
};

// How many frames or snapshots are in no counter, or in two: 0. Exact if the status was taken between two ticks, as by
// status() and latest_status().
[[nodiscard]] std::int64_t unaccounted(const UniverseStatus& universe);
[[nodiscard]] std::int64_t unaccounted(const PortStatus& port);

struct PumpStatus {
  TimeNs stamp_ns = 0;  // when the values were taken; 0: the pump has not started
  std::uint64_t ticks = 0;
  std::vector<PortStatus> ports;  // sources, then sinks, each in the order in which they were added
  std::vector<UniverseStatus> universes;
};

struct SinkRole {
  // Optional: the main sink. This sink gets frames only while that one is lost. The main sink was added before, to the
  // same pump. If it is a standby itself, it must be lost as well as its own main sink.
  const Sink* standby_for = nullptr;
};

struct SourceRole {
  bool may_override = false;  // its frames may have kPriorityOverride (sim/merge.h)
};

class Pump {
 public:
  // All three outlive the pump. Only the pump writes the universes.
  Pump(Universes& universes, Clock& clock, Waiter& waiter, PumpOptions options = {});
  Pump(std::shared_ptr<Universes> universes, Clock& clock, Waiter& waiter, PumpOptions options = {});
  Pump(const Pump&) = delete;
  Pump& operator=(const Pump&) = delete;

  // Before start() or between two ticks. The ports outlive the pump, or are removed.
  void add_source(Source& source, SourceRole role = {});
  void add_sink(Sink& sink, SinkRole role = {});
  // Between two ticks, or while stopped. Removes the source's senders: the remaining senders win the universes. Without
  // any, the snapshots stay.
  void remove_source(Source& source);
  // As above. Sends what a rate cap has held back and closes the sink. Its standby becomes the standby of the removed
  // sink's main sink. Without a main sink it gets frames from now on.
  void remove_sink(Sink& sink);
  // The tap receives every frame of every source as it came, before the merge, including frames that lose or have no
  // universe here (for a recorder). Called on the pump's thread. The tap outlives the pump, or is removed. Call both
  // between two ticks.
  void add_tap(FrameReceiver& tap);
  void remove_tap(FrameReceiver& tap);
  // Before start() or between two ticks. Sets the mode of one universe of the buffer.
  void set_mode(Universe universe, MergeMode mode);
  // Likewise: HTP, except for these slots, which are LTP.
  void set_slot_modes(Universe universe, const SlotSet& ltp);

  // Between two ticks: changes to another buffer, which may have other universes. Snapshots, senders and counters of
  // universes in both buffers are kept. Frames of universes that are gone count as unrouted. Modes are those of
  // `merge`. Readers switch by themselves: the old buffer gets no more writes, and universes() returns the new one.
  void move_to(std::shared_ptr<Universes> universes, const MergeOptions& merge);
  // The buffer that the pump writes. Any thread. A reader that keeps the pointer may go on reading it.
  [[nodiscard]] std::shared_ptr<const Universes> universes() const;

  // Any thread. Runs `job` on the pump's thread between two ticks, as soon as possible; jobs keep their order. stop()
  // runs the waiting jobs before anything else.
  void call(std::function<void()> job);

  // start(), step() until request_stop() (or the end of all sources, see PumpOptions), stop().
  void run();
  // Any thread, and signal handlers. If called before run(), run() starts, stops and returns.
  void request_stop() noexcept;

  // The parts of run(), for tests and for mains with a loop of their own.
  void start();
  bool step();  // one wait and one tick; false: call stop() now
  void tick(TimeNs now_ns);
  void stop();

  // On the pump's thread.
  [[nodiscard]] PumpStatus status() const;
  // Any thread. Returns the status at the end of the last status period that had a request. A caller that calls it
  // every second gets a status one or two periods old. Never waits for the pump.
  [[nodiscard]] PumpStatus latest_status() const;

 private:
  // State of one universe of a port.
  struct Lane {
    Universe universe = 0;
    int index = -1;  // in the buffer; -1: not in the buffer, or an earlier lane has it
    std::uint64_t frames = 0;
    std::uint64_t frames_before = 0;  // at the start of this status period
    double rate_hz = 0.0;
    // Sinks only.
    std::uint64_t snapshots = 0;
    std::uint64_t replaced = 0;
    std::uint64_t refused = 0;
    std::uint8_t flags = 0;  // of the waiting snapshot
    Pace pace;
  };

  // State of one port.
  struct PortRun {
    Port* port = nullptr;
    Source* source = nullptr;  // one of `source` and `sink` is set
    Sink* sink = nullptr;
    std::string name;
    SourceId source_id = 0;  // of its senders, in the merge
    std::uint8_t priority_max = kPriorityMax;

    bool ready = false;   // its descriptor is readable
    bool down = false;    // it failed or reports kGone
    bool failed = false;  // its last call returned an error
    bool lost = false;    // it was down and has done no work since; this was reported
    bool muted = false;   // its descriptor is not watched: see "Ports" above
    int watched_fd = -1;
    TimeNs polled_ns = 0;
    TimeNs armed_ns = kTimeNever;  // the deadline that the last wait used
    DurationNs retry_ns = 0;       // while failed: pause before the next call
    std::string trouble;

    std::vector<Lane> lanes;         // in the order of its universes
    std::vector<int> lane_of_index;  // -1: the port does not carry it
    std::uint64_t unrouted = 0;
    std::uint64_t failures = 0;
    std::uint64_t own_frames_before = 0;  // sink without universes: its own count
    double own_rate_hz = 0.0;
    Histogram lateness;
    Histogram latency;

    // Sinks only.
    const Sink* standby_for = nullptr;
    bool resting = false;               // its main sink works
    double period_ns = 0.0;             // 0: no cap
    TimeNs held_until_ns = kTimeNever;  // when the first snapshot held back by the cap is due
    std::vector<int> pending;           // lanes to send
    std::vector<FrameView> batch;       // of the current call
    std::vector<int> batch_lanes;       // lanes of `batch`
    // Sink::frames_on_line() at the start of this status period.
    std::optional<std::uint64_t> line_frames_before;
  };

  // Takes the frames of the source being polled.
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
  void report_lost(PortRun& run, const std::string& why, TimeNs now_ns);
  void report_back(PortRun& run, TimeNs now_ns);
  void watch(PortRun& run, bool again, TimeNs now_ns);
  void record_lateness(PortRun& run, TimeNs deadline_ns, TimeNs now_ns);
  void notify(NoticeLevel level, std::string_view id, const PortRun& run, const std::string& text,
              Universe universe = 0) const;
  [[nodiscard]] bool is_watched(int fd) const;
  [[nodiscard]] TimeNs deadline_of(const PortRun& run) const;
  [[nodiscard]] bool is_due(const PortRun& run, TimeNs now_ns) const;
  [[nodiscard]] TimeNs next_deadline_ns();
  void fill(PumpStatus& status, TimeNs now_ns) const;
  void fill(PortStatus& port, const PortRun& run) const;
  void fill_slot_senders(UniverseStatus& universe, int index, std::span<const std::uint8_t> order) const;
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
    bool has_snapshot = false;   // a frame was written since the buffer was made
    bool reported_full = false;  // a refused sender was reported
    bool reported_priority = false;
    bool received = false;  // a frame came since the last snapshot
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

#include "sim/pump.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "sim/core/check.h"

namespace footlight {
namespace {

// Minimum interval between calls of a port that is gone, whatever its deadline.
constexpr DurationNs kRetryMinNs = 10 * kNsPerMs;
// Maximum pause after failed calls, and the interval for a gone port without a deadline.
constexpr DurationNs kRetryMaxNs = kNsPerS;

// Flags of a snapshot that waits to be sent.
constexpr std::uint8_t kPending = 1;
constexpr std::uint8_t kReceived = 2;  // caused by a received frame, so its age is a latency of this program
constexpr std::uint8_t kHeld = 4;      // the rate cap holds it back

int highest_priority_of(const FrameView& frame) {
  if (frame.start_code != kStartCodePriorities || frame.slots.empty()) return frame.priority;
  return std::max(frame.priority, *std::max_element(frame.slots.begin(), frame.slots.end()));
}

// One sentence, however many universes of a port are not part of the run. Sorts them.
std::string unused_text(std::vector<Universe>& unused) {
  std::sort(unused.begin(), unused.end());
  unused.erase(std::unique(unused.begin(), unused.end()), unused.end());
  std::string ranges;
  for (std::size_t i = 0; i < unused.size();) {
    std::size_t last = i;
    while (last + 1 < unused.size() && unused[last + 1] == unused[last] + 1) ++last;
    ranges += fmt::format("{}{}", ranges.empty() ? "" : ",", unused[i]);
    if (last > i) ranges += fmt::format("-{}", unused[last]);
    i = last + 1;
  }
  const bool one = unused.size() == 1;
  return fmt::format("universe{} {} {} not among those of this run; {} unused", one ? "" : "s", ranges,
                     one ? "is" : "are", one ? "it stays" : "they stay");
}

// Period of the sink's rate cap; 0: no cap.
double period_ns_of(const Sink& sink) {
  const double rate_hz_max = sink.rate_hz_max();
  return rate_hz_max > 0.0 ? static_cast<double>(kNsPerS) / rate_hz_max : 0.0;
}

Timing timing_of(const Histogram& histogram) {
  Timing timing = {.count = histogram.count(),
                   .sum_ns = histogram.sum_ns(),
                   .p50_ns = histogram.quantile_ns(0.50),
                   .p99_ns = histogram.quantile_ns(0.99),
                   .max_ns = histogram.max_ns()};
  for (int k = 0; k < kTimingPowerCount; ++k) {
    timing.below[static_cast<std::size_t>(k)] = histogram.count_below_power(kTimingPowerFirst + k);
  }
  return timing;
}

}  // namespace

// --- The wire path, top down -----------------------------------------------------------------------------------------

void Pump::run() {
  start();
  while (!stop_requested_.load(std::memory_order_acquire) && step()) {
  }
  stop();
  stop_requested_.store(false, std::memory_order_release);
}

bool Pump::step() {
  const int ready_count = waiter_.wait_until(next_deadline_ns(), ready_fds_);
  for (int i = 0; i < ready_count; ++i)
    for (std::vector<PortRun>* runs : {&sources_, &sinks_})
      for (PortRun& run : *runs)
        if (run.watched_fd == ready_fds_[static_cast<std::size_t>(i)]) run.ready = true;
  if (has_jobs_.load(std::memory_order_acquire)) run_jobs();
  tick(clock_.now_ns());
  if (stop_requested_.load(std::memory_order_acquire)) return false;
  const bool ended = !sources_.empty() && std::all_of(sources_.begin(), sources_.end(), [](const PortRun& run) {
    return run.port->state() == PortState::kEnded;
  });
  return !(options_.stop_at_end && ended);
}

void Pump::tick(TimeNs now_ns) {
  FL_CHECK(started_);
  FL_CHECK(!in_tick_);
  in_tick_ = true;
  ++ticks_;
  receive_ready(now_ns);
  merge_.expire(now_ns);
  merge_changed();
  send_due(now_ns);
  in_tick_ = false;
  tick_ns_ = now_ns;
  if (now_ns - rates_since_ns_ >= options_.status_period_ns) count_rates(now_ns);
}

void Pump::receive_ready(TimeNs now_ns) {
  // A blackout first: queued frames of other sources must not be shown before it. It is asked again in its turn, since
  // those sources may have given it commands.
  for (PortRun& run : sources_)
    if (run.priority_max == kPriorityOverride && is_due(run, now_ns)) poll(run, now_ns);
  for (PortRun& run : sources_)
    if (is_due(run, now_ns)) poll(run, now_ns);
}

void Pump::Inlet::receive(const FrameView& frame) {
  for (FrameReceiver* tap : pump_.taps_) tap->receive(frame);
  const int index = pump_.universes_->index_of(frame.universe);
  const int lane = index < 0 ? -1 : run->lane_of_index[static_cast<std::size_t>(index)];
  if (lane < 0) {
    ++run->unrouted;
    return;
  }
  ++run->lanes[static_cast<std::size_t>(lane)].frames;
  UniverseRun& universe = pump_.universe_runs_[static_cast<std::size_t>(index)];
  Merge::Received received = pump_.merge_.receive(index, frame, now_ns, run->source_id, run->priority_max);
  if (received == Merge::Received::kResolveFirst) {
    pump_.pass_on(now_ns);
    received = pump_.merge_.receive(index, frame, now_ns, run->source_id, run->priority_max);
  }
  // A priority frame or a sender's end shows earlier levels. Their age is not a latency.
  if (frame.start_code == kStartCodeLevels && !frame.terminated) universe.received = true;
  if (received == Merge::Received::kRefusedFull && !universe.reported_full) {
    universe.reported_full = true;
    pump_.notify(NoticeLevel::kWarning, "sender-refused", *run,
                 fmt::format("universe {} has {} senders already; frames of further ones are refused and counted",
                             frame.universe, kSendersPerUniverseMax),
                 frame.universe);
  }
  if (received == Merge::Received::kRefusedPriority && !universe.reported_priority) {
    universe.reported_priority = true;
    pump_.notify(
        NoticeLevel::kWarning, "priority-refused", *run,
        fmt::format("universe {}: a sender has priority {}; expected 0 to {}; its frames are ignored and counted",
                    frame.universe, highest_priority_of(frame), kPriorityMax),
        frame.universe);
  }
}

// Called while receiving: sends what has come so far, so that no frame is overwritten unsent.
void Pump::pass_on(TimeNs now_ns) {
  merge_changed();
  for (PortRun& run : sinks_)
    if (run.period_ns <= 0.0) send_pending(run, now_ns);
}

void Pump::merge_changed() {
  for (const int index : merge_.changed()) {
    if (!merge_.resolve(index)) continue;
    universes_->write(index, merge_.snapshot(index));
    UniverseRun& universe = universe_runs_[static_cast<std::size_t>(index)];
    universe.has_snapshot = true;
    ++universe.writes;
    const std::uint8_t flags = universe.received ? kPending | kReceived : kPending;
    universe.received = false;
    for (PortRun& run : sinks_) {
      const int lane = run.lane_of_index[static_cast<std::size_t>(index)];
      if (lane >= 0 && !run.resting) mark_pending(run, lane, flags);
    }
  }
  merge_.clear_changed();
}

void Pump::send_due(TimeNs now_ns) {
  for (PortRun& run : sinks_) {
    send_pending(run, now_ns);
    if (!is_due(run, now_ns)) continue;
    const bool was_down = run.down;
    poll(run, now_ns);
    if (was_down && !run.down) send_pending(run, now_ns);
  }
}

void Pump::send_pending(PortRun& run, TimeNs now_ns, bool ignore_cap) {
  if (run.pending.empty() || run.down) return;
  run.batch.clear();
  run.batch_lanes.clear();
  run.held_until_ns = kTimeNever;
  std::size_t held_count = 0;
  for (const int number : run.pending) {
    Lane& lane = run.lanes[static_cast<std::size_t>(number)];
    const TimeNs due_ns = lane.pace.due_ns();
    if (run.period_ns > 0.0 && due_ns > now_ns && !ignore_cap) {
      lane.flags |= kHeld;
      run.held_until_ns = std::min(run.held_until_ns, due_ns);
      run.pending[held_count++] = number;
      continue;
    }
    if ((lane.flags & kHeld) != 0) record_lateness(run, due_ns, now_ns);
    if (run.period_ns > 0.0) lane.pace.happened(now_ns, run.period_ns);
    FrameView& frame = run.batch.emplace_back(merge_.snapshot(lane.index));
    frame.universe = lane.universe;
    run.batch_lanes.push_back(number);
  }
  run.pending.resize(held_count);
  if (run.batch.empty()) return;

  const Status sent = run.sink->send(now_ns, run.batch);
  const TimeNs sent_ns = clock_.now_ns();
  for (std::size_t i = 0; i < run.batch.size(); ++i) {
    Lane& lane = run.lanes[static_cast<std::size_t>(run.batch_lanes[i])];
    ++(sent ? lane.frames : lane.refused);
    if (sent && (lane.flags & kReceived) != 0) run.latency.record(sent_ns - run.batch[i].stamp_ns);
    lane.flags = 0;
  }
  settle(run, sent, now_ns);
  if (!run.down) report_back(run, now_ns);
}

void Pump::mark_pending(PortRun& run, int lane_number, std::uint8_t flags) {
  Lane& lane = run.lanes[static_cast<std::size_t>(lane_number)];
  ++lane.snapshots;
  if ((lane.flags & kPending) != 0) {
    ++lane.replaced;
  } else {
    run.pending.push_back(lane_number);
  }
  lane.flags |= flags;
}

void Pump::mark_every_snapshot(PortRun& run) {
  if (run.resting) return;
  for (std::size_t number = 0; number < run.lanes.size(); ++number) {
    const Lane& lane = run.lanes[number];
    if (lane.index < 0 || (lane.flags & kPending) != 0) continue;
    if (!universe_runs_[static_cast<std::size_t>(lane.index)].has_snapshot) continue;
    mark_pending(run, static_cast<int>(number), kPending);
  }
}

// --- Ports that come and go ------------------------------------------------------------------------------------------

void Pump::poll(PortRun& run, TimeNs now_ns) {
  const bool woken_by_descriptor = run.ready;
  if (!woken_by_descriptor) record_lateness(run, run.armed_ns, now_ns);
  run.ready = false;
  run.polled_ns = now_ns;
  inlet_.run = &run;
  inlet_.now_ns = now_ns;
  settle(run, run.source != nullptr ? run.source->poll(now_ns, inlet_) : run.sink->poll(now_ns), now_ns);
  while (const auto notice = run.port->take_notice()) notify(notice->level, notice->id, run, notice->text);
  const bool mute = run.down && woken_by_descriptor;
  if (mute != run.muted) {
    run.muted = mute;
    watch(run, false, now_ns);
  }
}

// After every call of a port: detects whether it is gone or back.
void Pump::settle(PortRun& run, const Status& result, TimeNs now_ns) {
  const PortState state = run.port->state();
  const bool was_down = run.down;
  run.failed = !result.has_value();
  run.down = run.failed || state == PortState::kGone;
  if (!was_down && !run.down) {
    const int fd = state == PortState::kEnded ? -1 : run.port->poll_fd();
    if (fd != run.watched_fd) watch(run, false, now_ns);
    return;
  }

  if (run.failed) {
    ++run.failures;
    run.trouble = result.error().message;
    run.retry_ns = std::clamp(run.retry_ns * 2, kRetryMinNs, kRetryMaxNs);
    run.polled_ns = now_ns;
  }
  if (run.down) {
    run.held_until_ns = kTimeNever;
    report_lost(run, run.failed ? run.trouble : run.port->trouble(), now_ns);
  } else {
    if (run.sink != nullptr) {
      run.period_ns = period_ns_of(*run.sink);  // the device may be a new model, or absent at the start
      mark_every_snapshot(run);
    }
    if (run.pending.empty()) report_back(run, now_ns);  // else after a snapshot was sent
  }
  watch(run, true, now_ns);
}

void Pump::report_lost(PortRun& run, const std::string& why, TimeNs now_ns) {
  if (run.lost) return;
  run.lost = true;
  notify(NoticeLevel::kWarning, "port-lost", run, fmt::format("lost: {}", why));
  if (run.sink != nullptr) set_standbys(now_ns);
}

// The port has done work: the trouble is over.
void Pump::report_back(PortRun& run, TimeNs now_ns) {
  run.retry_ns = 0;
  if (!run.lost) return;
  run.lost = false;
  run.trouble.clear();
  notify(NoticeLevel::kInfo, "port-back", run, "back");
  if (run.sink != nullptr) set_standbys(now_ns);
}

// Decides which standbys get frames. Called when a sink is lost, returns, is added or is removed.
void Pump::set_standbys(TimeNs now_ns) {
  for (PortRun& run : sinks_) {
    const PortRun* working = nullptr;
    for (const PortRun* main = run_of(run.standby_for); main != nullptr; main = run_of(main->standby_for))
      if (!main->lost) working = main;
    const bool rests = working != nullptr;
    if (rests == run.resting) continue;
    run.resting = rests;
    if (rests) {
      for (const int number : run.pending) {
        Lane& lane = run.lanes[static_cast<std::size_t>(number)];
        ++lane.replaced;
        lane.flags = 0;
      }
      run.pending.clear();
      run.held_until_ns = kTimeNever;
      run.sink->rest(now_ns);
      notify(NoticeLevel::kInfo, "standby-rests", run, fmt::format("on standby again; {} is back", working->name));
    } else {
      if (const PortRun* const main = run_of(run.standby_for); main != nullptr)
        notify(NoticeLevel::kWarning, "standby-takes-over", run, fmt::format("takes over for {}", main->name));
      mark_every_snapshot(run);  // it sends after its main sink, so in the same tick
    }
  }
}

const Pump::PortRun* Pump::run_of(const Sink* sink) const {
  for (const PortRun& run : sinks_)
    if (run.sink == sink) return &run;
  return nullptr;
}

// Watches the port's descriptor, or none. `again`: even if the number is unchanged.
void Pump::watch(PortRun& run, bool again, TimeNs now_ns) {
  const bool ignored = run.failed || run.muted || run.port->state() == PortState::kEnded;
  const int fd = ignored ? -1 : run.port->poll_fd();
  if (fd == run.watched_fd && (fd < 0 || !again)) return;
  const int old_fd = run.watched_fd;
  run.watched_fd = fd;
  if (old_fd >= 0 && old_fd != fd && !is_watched(old_fd)) waiter_.unwatch(old_fd);
  if (fd < 0) return;
  if (const Status watched = waiter_.watch(fd); !watched) {
    run.watched_fd = -1;
    run.failed = run.down = true;
    run.trouble = watched.error().message;
    ++run.failures;
    run.retry_ns = kRetryMaxNs;
    report_lost(run, run.trouble, now_ns);
  }
}

bool Pump::is_watched(int fd) const {
  for (const std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (const PortRun& run : *runs)
      if (run.watched_fd == fd) return true;
  return false;
}

void Pump::notify(NoticeLevel level, std::string_view id, const PortRun& run, const std::string& text,
                  Universe universe) const {
  if (!options_.on_notice) return;
  const std::string line = fmt::format("{}: {}", run.name, text);
  options_.on_notice({.level = level, .id = id, .text = line, .port = run.name, .universe = universe});
}

// --- Time ------------------------------------------------------------------------------------------------------------

TimeNs Pump::deadline_of(const PortRun& run) const {
  if (run.source != nullptr && run.port->state() == PortState::kEnded) return kTimeNever;
  const TimeNs own_ns = run.port->next_deadline_ns();
  if (!run.down) return own_ns;
  if (own_ns == kTimeNever) return run.polled_ns + kRetryMaxNs;
  return std::max(own_ns, run.polled_ns + (run.failed ? run.retry_ns : kRetryMinNs));
}

bool Pump::is_due(const PortRun& run, TimeNs now_ns) const { return run.ready || deadline_of(run) <= now_ns; }

TimeNs Pump::next_deadline_ns() {
  TimeNs next_ns = std::min(merge_.next_expiry_ns(), rates_since_ns_ + options_.status_period_ns);
  for (std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (PortRun& run : *runs) {
      run.armed_ns = deadline_of(run);
      next_ns = std::min({next_ns, run.armed_ns, run.held_until_ns});
    }
  return next_ns;
}

// A deadline that was in the past when it was read means "at once": counted from the last tick.
void Pump::record_lateness(PortRun& run, TimeNs deadline_ns, TimeNs now_ns) {
  if (deadline_ns <= now_ns) run.lateness.record(now_ns - std::max(deadline_ns, tick_ns_));
}

// --- Begin and end ---------------------------------------------------------------------------------------------------

Pump::Pump(Universes& universes, Clock& clock, Waiter& waiter, PumpOptions options)
    : Pump(std::shared_ptr<Universes>(std::shared_ptr<void>(), &universes), clock, waiter, std::move(options)) {}

Pump::Pump(std::shared_ptr<Universes> universes, Clock& clock, Waiter& waiter, PumpOptions options)
    : universes_(std::move(universes)),
      clock_(clock),
      waiter_(waiter),
      options_(std::move(options)),
      merge_(universes_->count(), options_.merge),
      inlet_(*this),
      universe_runs_(static_cast<std::size_t>(universes_->count())) {
  FL_CHECK_GT(options_.status_period_ns, 0);
}

void Pump::add_source(Source& source, SourceRole role) {
  FL_CHECK(!in_tick_);
  PortRun& run = sources_.emplace_back();
  run.port = run.source = &source;
  run.source_id = ++last_source_id_;
  run.priority_max = role.may_override ? kPriorityOverride : kPriorityMax;
  add(run, source.universes());
}

void Pump::add_sink(Sink& sink, SinkRole role) {
  FL_CHECK(!in_tick_);
  FL_CHECK(role.standby_for == nullptr || run_of(role.standby_for) != nullptr);
  PortRun& run = sinks_.emplace_back();
  run.port = run.sink = &sink;
  run.standby_for = role.standby_for;
  run.period_ns = period_ns_of(sink);
  run.line_frames_before = sink.frames_on_line();
  add(run, sink.universes());
}

void Pump::add(PortRun& run, std::span<const Universe> universes) {
  run.name = run.port->name();
  run.lanes.resize(universes.size());
  for (std::size_t i = 0; i < universes.size(); ++i) run.lanes[i].universe = universes[i];
  find_lanes(run);
  std::vector<Universe> unused;
  for (const Lane& lane : run.lanes) {
    if (universes_->index_of(lane.universe) < 0) unused.push_back(lane.universe);
  }
  if (!unused.empty()) {
    notify(NoticeLevel::kWarning, "universe-unused", run, unused_text(unused), unused.front());
  }
  if (run.sink != nullptr) {
    run.pending.reserve(run.lanes.size());
    run.batch.reserve(run.lanes.size());
    run.batch_lanes.reserve(run.lanes.size());
    run.resting = run.standby_for != nullptr;  // until set_standbys() decides
  }
  ready_fds_.resize(std::max<std::size_t>(1, sources_.size() + sinks_.size()));
  if (!started_) return;
  const TimeNs now_ns = clock_.now_ns();
  attach(run, now_ns);
  set_standbys(now_ns);
}

void Pump::find_lanes(PortRun& run) const {
  run.lane_of_index.assign(universe_runs_.size(), -1);
  for (std::size_t i = 0; i < run.lanes.size(); ++i) {
    Lane& lane = run.lanes[i];
    lane.index = universes_->index_of(lane.universe);
    if (lane.index < 0) continue;
    // A universe listed twice is carried once, in its first lane.
    int& number = run.lane_of_index[static_cast<std::size_t>(lane.index)];
    if (number >= 0) {
      lane.index = -1;
    } else {
      number = static_cast<int>(i);
    }
  }
}

// Reads a new port's state; a sink gets every existing snapshot.
void Pump::attach(PortRun& run, TimeNs now_ns) {
  run.ready = false;
  run.muted = false;
  run.polled_ns = now_ns;
  settle(run, {}, now_ns);
  if (run.sink != nullptr) mark_every_snapshot(run);
}

void Pump::detach(PortRun& run) {
  const int fd = std::exchange(run.watched_fd, -1);
  if (fd >= 0 && !is_watched(fd)) waiter_.unwatch(fd);
}

void Pump::remove_source(Source& source) {
  FL_CHECK(!in_tick_);
  const auto run =
      std::find_if(sources_.begin(), sources_.end(), [&](const PortRun& r) { return r.source == &source; });
  FL_CHECK(run != sources_.end());
  detach(*run);
  merge_.forget_source(run->source_id);
  sources_.erase(run);
}

void Pump::remove_sink(Sink& sink) {
  FL_CHECK(!in_tick_);
  const auto run = std::find_if(sinks_.begin(), sinks_.end(), [&](const PortRun& r) { return r.sink == &sink; });
  FL_CHECK(run != sinks_.end());
  const TimeNs now_ns = clock_.now_ns();
  if (started_) {
    send_pending(*run, now_ns, /*ignore_cap=*/true);
    run->sink->close(now_ns);
  }
  detach(*run);
  const Sink* const before_it = run->standby_for;
  sinks_.erase(run);
  for (PortRun& other : sinks_)
    if (other.standby_for == &sink) other.standby_for = before_it;
  set_standbys(now_ns);
}

void Pump::add_tap(FrameReceiver& tap) {
  FL_CHECK(!in_tick_);
  taps_.push_back(&tap);
}

void Pump::remove_tap(FrameReceiver& tap) {
  FL_CHECK(!in_tick_);
  taps_.erase(std::remove(taps_.begin(), taps_.end(), &tap), taps_.end());
}

void Pump::set_mode(Universe universe, MergeMode mode) {
  FL_CHECK(!in_tick_);
  const int index = universes_->index_of(universe);
  FL_CHECK_GE(index, 0);
  merge_.set_mode(index, mode);
}

void Pump::set_slot_modes(Universe universe, const SlotSet& ltp) {
  FL_CHECK(!in_tick_);
  const int index = universes_->index_of(universe);
  FL_CHECK_GE(index, 0);
  merge_.set_slot_modes(index, ltp);
}

void Pump::move_to(std::shared_ptr<Universes> universes, const MergeOptions& merge) {
  FL_CHECK(!in_tick_);
  FL_CHECK(universes != nullptr);
  FL_CHECK(universes != universes_);
  options_.merge = merge;
  const auto count = static_cast<std::size_t>(universes->count());
  std::vector<UniverseRun> universe_runs(count);
  std::vector<int> old_index(count);
  for (std::size_t i = 0; i < count; ++i) {
    old_index[i] = universes_->index_of(universes->numbers()[i]);
    if (old_index[i] >= 0) universe_runs[i] = universe_runs_[static_cast<std::size_t>(old_index[i])];
  }
  Merge next(universes->count(), merge);
  next.adopt(merge_, old_index);
  merge_ = std::move(next);
  universe_runs_ = std::move(universe_runs);
  {
    const std::lock_guard lock(published_mutex_);
    universes_ = std::move(universes);
  }
  for (int index = 0; index < universes_->count(); ++index) {
    if (universe_runs_[static_cast<std::size_t>(index)].has_snapshot) {
      universes_->write(index, merge_.snapshot(index));
    } else if (started_) {
      take_from_buffer(index);
    }
  }
  for (std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (PortRun& run : *runs) {
      std::vector<bool> had(run.lanes.size());
      for (std::size_t i = 0; i < run.lanes.size(); ++i) had[i] = run.lanes[i].index >= 0;
      find_lanes(run);
      if (run.sink == nullptr) continue;
      std::erase_if(run.pending, [&run](int number) {
        Lane& lane = run.lanes[static_cast<std::size_t>(number)];
        if (lane.index >= 0) return false;
        ++lane.replaced;
        lane.flags = 0;
        return true;
      });
      if (!started_ || run.resting) continue;
      for (std::size_t i = 0; i < run.lanes.size(); ++i) {
        const int index = run.lanes[i].index;
        if (had[i] || index < 0 || !universe_runs_[static_cast<std::size_t>(index)].has_snapshot) continue;
        mark_pending(run, static_cast<int>(i), kPending);
      }
    }
}

std::shared_ptr<const Universes> Pump::universes() const {
  const std::lock_guard lock(published_mutex_);
  return universes_;
}

// Adopts levels that are in the buffer already: from an earlier run, or written by the main program.
void Pump::take_from_buffer(int index) {
  std::array<std::uint8_t, kSlotCountMax> levels;
  FrameStamp stamp;
  universes_->snapshot(index, levels, stamp);
  if (stamp.revision == 0) return;
  universe_runs_[static_cast<std::size_t>(index)].has_snapshot = true;
  FrameView frame;
  frame.stamp_ns = stamp.stamp_ns;
  frame.sender = stamp.sender;
  frame.sequence = stamp.sequence;
  frame.slots = levels;
  merge_.set_snapshot(index, frame);
}

void Pump::call(std::function<void()> job) {
  {
    const std::lock_guard lock(jobs_mutex_);
    jobs_.push_back(std::move(job));
  }
  has_jobs_.store(true, std::memory_order_release);
  waiter_.interrupt();
}

void Pump::run_jobs() {
  std::vector<std::function<void()>> jobs;
  has_jobs_.store(false, std::memory_order_release);
  {
    const std::lock_guard lock(jobs_mutex_);
    std::swap(jobs, jobs_);
  }
  for (const auto& job : jobs) job();
}

void Pump::request_stop() noexcept {
  stop_requested_.store(true, std::memory_order_release);
  waiter_.interrupt();
}

void Pump::start() {
  FL_CHECK(!started_);
  started_ = true;
  const TimeNs now_ns = clock_.now_ns();
  rates_since_ns_ = tick_ns_ = now_ns;
  for (int index = 0; index < universes_->count(); ++index) take_from_buffer(index);
  for (std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (PortRun& run : *runs) {
      attach(run, now_ns);
      if (run.sink != nullptr) send_pending(run, now_ns);
    }
  fill(spare_status_, now_ns);
  const std::lock_guard lock(published_mutex_);
  published_ = spare_status_;
}

void Pump::stop() {
  if (!started_) return;
  run_jobs();
  const TimeNs now_ns = clock_.now_ns();
  for (PortRun& run : sinks_) {
    send_pending(run, now_ns, /*ignore_cap=*/true);
    run.sink->close(now_ns);
  }
  for (std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (PortRun& run : *runs) detach(run);
  started_ = false;
}

// --- What is counted -------------------------------------------------------------------------------------------------

void Pump::count_rates(TimeNs now_ns) {
  const double period_s = static_cast<double>(now_ns - rates_since_ns_) / static_cast<double>(kNsPerS);
  rates_since_ns_ = now_ns;
  for (UniverseRun& universe : universe_runs_) {
    universe.rate_hz = static_cast<double>(universe.writes - universe.writes_before) / period_s;
    universe.writes_before = universe.writes;
  }
  for (std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (PortRun& run : *runs)
      for (Lane& lane : run.lanes) {
        lane.rate_hz = static_cast<double>(lane.frames - lane.frames_before) / period_s;
        lane.frames_before = lane.frames;
      }
  for (PortRun& run : sinks_) {
    if (run.lanes.empty()) {
      const std::uint64_t frames = run.port->counters().frames;
      run.own_rate_hz = static_cast<double>(frames - run.own_frames_before) / period_s;
      run.own_frames_before = frames;
    }
    // Frames that are passed faster than the line sends them never leave.
    const auto line_frames = run.sink->frames_on_line();
    const auto before = std::exchange(run.line_frames_before, line_frames);
    // Only if both ends of the period have a count and the device was not replaced in between.
    if (!line_frames || !before || *line_frames < *before || run.lanes.size() != 1) continue;
    run.lanes[0].rate_hz = static_cast<double>(*line_frames - *before) / period_s;
  }
  merge_.count_rates(period_s);

  if (!status_wanted_.exchange(false, std::memory_order_acq_rel)) return;
  fill(spare_status_, now_ns);
  const std::unique_lock lock(published_mutex_, std::try_to_lock);
  if (lock.owns_lock()) {
    std::swap(published_, spare_status_);
  } else {
    status_wanted_.store(true, std::memory_order_release);  // a reader is copying the last one: publish next time
  }
}

PumpStatus Pump::status() const {
  PumpStatus status;
  fill(status, clock_.now_ns());
  return status;
}

PumpStatus Pump::latest_status() const {
  status_wanted_.store(true, std::memory_order_release);
  const std::lock_guard lock(published_mutex_);
  return published_;
}

void Pump::fill(PumpStatus& status, TimeNs now_ns) const {
  status.stamp_ns = now_ns;
  status.ticks = ticks_;
  status.ports.resize(sources_.size() + sinks_.size());
  std::size_t port_number = 0;
  for (const std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (const PortRun& run : *runs) fill(status.ports[port_number++], run);
  status.universes.resize(universe_runs_.size());
  for (int index = 0; index < universes_->count(); ++index)
    fill(status.universes[static_cast<std::size_t>(index)], index, now_ns);
}

void Pump::fill(PortStatus& port, const PortRun& run) const {
  port.name = run.name;
  port.is_sink = run.sink != nullptr;
  port.standby = run.resting;
  const PortRun* const main = run_of(run.standby_for);
  port.standby_for = main != nullptr ? main->name : std::string();
  port.state = run.down ? PortState::kGone : run.port->state();
  port.trouble = run.failed ? run.trouble : run.port->trouble();
  port.port = run.port->counters();
  run.port->take_figures(port.figures);
  port.frames = port.snapshots = port.replaced = port.refused = port.waiting = 0;
  port.rate_hz = 0.0;
  port.unrouted = run.unrouted;
  port.failures = run.failures;
  port.lateness = timing_of(run.lateness);
  port.latency = timing_of(run.latency);
  port.universes.resize(run.lanes.size());
  for (std::size_t i = 0; i < run.lanes.size(); ++i) {
    const Lane& lane = run.lanes[i];
    PortUniverseStatus& universe = port.universes[i];
    universe = {.universe = lane.universe,
                .frames = lane.frames,
                .rate_hz = lane.rate_hz,
                .snapshots = lane.snapshots,
                .replaced = lane.replaced,
                .refused = lane.refused,
                .waiting = (lane.flags & kPending) != 0 ? 1u : 0u};
    port.frames += universe.frames;
    port.rate_hz += universe.rate_hz;
    port.snapshots += universe.snapshots;
    port.replaced += universe.replaced;
    port.refused += universe.refused;
    port.waiting += universe.waiting;
  }
  if (run.sink != nullptr && run.lanes.empty()) {
    port.frames = port.snapshots = port.port.frames;
    port.rate_hz = run.own_rate_hz;
  }
}

void Pump::fill(UniverseStatus& universe, int index, TimeNs now_ns) const {
  const auto i = static_cast<std::size_t>(index);
  universe.universe = universes_->numbers()[i];
  std::array<std::uint8_t, kSlotCountMax> levels;
  universes_->snapshot(index, levels, universe.newest);
  universe.priority = merge_.snapshot(index).priority;
  universe.rate_hz = universe_runs_[i].rate_hz;
  universe.writes = universe_runs_[i].writes;
  universe.winners = merge_.winner_count(index);
  universe.merge = merge_.counters(index);
  const int count = merge_.sender_count(index);
  universe.senders.resize(static_cast<std::size_t>(count));
  // The highest priority first.
  std::array<MergeSender, kSendersPerUniverseMax> all;
  std::array<std::uint8_t, kSendersPerUniverseMax> order;
  for (int k = 0; k < count; ++k) {
    all[static_cast<std::size_t>(k)] = merge_.sender(index, k);
    order[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(k);
  }
  std::sort(order.begin(), order.begin() + count, [&](std::uint8_t x, std::uint8_t y) {
    const MergeSender& a = all[x];
    const MergeSender& b = all[y];
    return a.priority != b.priority ? a.priority > b.priority : a.id < b.id;
  });
  for (std::size_t k = 0; k < universe.senders.size(); ++k) {
    const MergeSender& sender = all[order[k]];
    SenderStatus& shown = universe.senders[k];
    shown.name.clear();
    for (const PortRun& run : sources_) {
      if (run.source_id != sender.source) continue;
      shown.name = run.source->sender_text(sender.id);
      if (shown.name.empty()) shown.name = run.name;
      if (const int lane = run.lane_of_index[i]; lane >= 0)
        shown.losses = run.source->sender_losses(static_cast<std::size_t>(lane), sender.id);
    }
    shown.id = sender.id;
    shown.priority = sender.priority;
    shown.age_ns = now_ns - sender.received_ns;
    shown.rate_hz = sender.rate_hz;
    shown.wins = sender.wins;
    shown.per_address = sender.per_address;
  }
  fill_slot_senders(universe, index, {order.data(), universe.senders.size()});
}

void Pump::fill_slot_senders(UniverseStatus& universe, int index, std::span<const std::uint8_t> order) const {
  universe.slot_senders.clear();
  const auto winners = std::count_if(universe.senders.begin(), universe.senders.end(),
                                     [](const SenderStatus& sender) { return sender.wins; });
  if (winners < 2) return;
  Merge::SlotSenders of_merge;
  merge_.slot_senders(index, of_merge);
  universe.slot_senders.resize(of_merge.size());
  for (std::size_t slot = 0; slot < of_merge.size(); ++slot) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < order.size(); ++k) bits |= (unsigned{of_merge[slot]} >> order[k] & 1u) << k;
    universe.slot_senders[slot] = static_cast<std::uint8_t>(bits);
  }
}

std::int64_t unaccounted(const UniverseStatus& universe) {
  const MergeCounters& m = universe.merge;
  return static_cast<std::int64_t>(m.frames - m.frames_shown - m.frames_outranked - m.frames_priorities -
                                   m.frames_early - m.frames_ended - m.refused_priority - m.refused_full);
}

std::int64_t unaccounted(const PortStatus& port) {
  if (!port.is_sink) return 0;  // its frames are counted as `unrouted` or in their universes
  return static_cast<std::int64_t>(port.snapshots - port.frames - port.replaced - port.refused - port.waiting);
}

}  // namespace footlight

#include "sim/pump.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "sim/core/check.h"

namespace footlight {
namespace {

// A port that is gone is not polled more often than this, whatever deadline it names.
constexpr DurationNs kRetryMinNs = 10 * kNsPerMs;
// A port whose calls fail is left alone for at most this long, and a gone one that names no deadline for just this
// long.
constexpr DurationNs kRetryMaxNs = kNsPerS;

// Flags of a look that waits to be sent.
constexpr std::uint8_t kPending = 1;
constexpr std::uint8_t kHeard = 2;  // because a frame came, so that its age is the latency of this program
constexpr std::uint8_t kHeld = 4;   // the rate cap holds it back

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
  tick(clock_.now_ns());
  if (stop_requested_.load(std::memory_order_acquire)) return false;
  const bool ended = !sources_.empty() && std::all_of(sources_.begin(), sources_.end(), [](const PortRun& run) {
    return run.port->state() == PortState::kEnded;
  });
  return !(options_.stop_at_end && ended);
}

void Pump::tick(TimeNs now_ns) {
  FL_CHECK(started_);
  ++ticks_;
  receive_ready(now_ns);
  merge_changed(now_ns);
  send_due(now_ns);
  tick_ns_ = now_ns;
  if (now_ns - rates_since_ns_ >= options_.status_period_ns) count_rates(now_ns);
}

void Pump::receive_ready(TimeNs now_ns) {
  for (PortRun& run : sources_)
    if (is_due(run, now_ns)) poll(run, now_ns);
}

void Pump::Inlet::receive(const FrameView& frame) {
  for (FrameReceiver* tap : pump_.taps_) tap->receive(frame);
  const int index = pump_.universes_.index_of(frame.universe);
  const int position = index < 0 ? -1 : run->position_of_index[static_cast<std::size_t>(index)];
  if (position < 0) {
    ++run->unrouted;
    return;
  }
  ++run->frames[static_cast<std::size_t>(position)];
  UniverseRun& universe = pump_.universe_runs_[static_cast<std::size_t>(index)];
  universe.heard_tick = pump_.ticks_;
  const Merge::Received received = pump_.merge_.receive(index, frame, now_ns);
  if (received == Merge::Received::kRefusedFull && !universe.said_full) {
    universe.said_full = true;
    pump_.say(NoticeLevel::kWarning, "sender-refused", *run,
              fmt::format("universe {} has {} senders already; frames of further ones are refused and counted",
                          frame.universe, kSendersPerUniverseMax),
              frame.universe);
  }
  if (received == Merge::Received::kRefusedPriority && !universe.said_priority) {
    universe.said_priority = true;
    pump_.say(NoticeLevel::kWarning, "priority-refused", *run,
              fmt::format("universe {}: a sender has priority {}; expected 0 to {}; its frames are ignored and counted",
                          frame.universe, frame.priority, kPriorityMax),
              frame.universe);
  }
}

void Pump::merge_changed(TimeNs now_ns) {
  merge_.expire(now_ns);
  for (const int index : merge_.changed()) {
    if (!merge_.resolve(index)) continue;
    universes_.write(index, merge_.look(index));
    UniverseRun& universe = universe_runs_[static_cast<std::size_t>(index)];
    universe.has_look = true;
    ++universe.writes;
    const std::uint8_t flags = universe.heard_tick == ticks_ ? kPending | kHeard : kPending;
    for (PortRun& run : sinks_) {
      const int position = run.position_of_index[static_cast<std::size_t>(index)];
      if (position >= 0) mark_pending(run, position, flags);
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
  run.batch_positions.clear();
  run.held_until_ns = kTimeNever;
  std::size_t held_count = 0;
  for (const int position : run.pending) {
    const auto p = static_cast<std::size_t>(position);
    const TimeNs due_ns = run.paces[p].due_ns();
    if (run.period_ns > 0.0 && due_ns > now_ns && !ignore_cap) {
      run.pending_flags[p] |= kHeld;
      run.held_until_ns = std::min(run.held_until_ns, due_ns);
      run.pending[held_count++] = position;
      continue;
    }
    if ((run.pending_flags[p] & kHeld) != 0) record_lateness(run, due_ns, now_ns);
    if (run.period_ns > 0.0) run.paces[p].happened(now_ns, run.period_ns);
    FrameView& frame = run.batch.emplace_back(merge_.look(run.index_of_position[p]));
    frame.universe = run.universes[p];
    run.batch_positions.push_back(position);
  }
  run.pending.resize(held_count);
  if (run.batch.empty()) return;

  const Status sent = run.sink->send(now_ns, run.batch);
  const TimeNs sent_ns = clock_.now_ns();
  for (std::size_t i = 0; i < run.batch.size(); ++i) {
    const auto p = static_cast<std::size_t>(run.batch_positions[i]);
    if (sent) ++run.frames[p];
    if (sent && (run.pending_flags[p] & kHeard) != 0) run.latency.record(sent_ns - run.batch[i].stamp_ns);
    run.pending_flags[p] = 0;
  }
  settle(run, sent, now_ns);
  if (!run.down) say_back(run);
}

void Pump::mark_pending(PortRun& run, int position, std::uint8_t flags) {
  const auto p = static_cast<std::size_t>(position);
  if ((run.pending_flags[p] & kPending) != 0) {
    ++run.replaced;
  } else {
    run.pending.push_back(position);
  }
  run.pending_flags[p] |= flags;
}

void Pump::mark_every_look(PortRun& run) {
  for (std::size_t p = 0; p < run.universes.size(); ++p) {
    const int index = run.index_of_position[p];
    if (index < 0 || (run.pending_flags[p] & kPending) != 0) continue;
    if (!universe_runs_[static_cast<std::size_t>(index)].has_look) continue;
    mark_pending(run, static_cast<int>(p), kPending);
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
  while (const auto notice = run.port->take_notice()) say(notice->level, notice->id, run, notice->text);
  const bool mute = run.down && woken_by_descriptor;
  if (mute != run.muted) {
    run.muted = mute;
    watch(run, false);
  }
}

// After every call of a port: has it gone, has it come back?
void Pump::settle(PortRun& run, const Status& result, TimeNs now_ns) {
  const PortState state = run.port->state();
  const bool was_down = run.down;
  run.failed = !result.has_value();
  run.down = run.failed || state == PortState::kGone;
  if (!was_down && !run.down) {
    const int fd = state == PortState::kEnded ? -1 : run.port->poll_fd();
    if (fd != run.watched_fd) watch(run, false);
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
    if (!run.said_down) {
      say(NoticeLevel::kWarning, "port-lost", run,
          fmt::format("lost: {}", run.failed ? run.trouble : run.port->trouble()));
    }
    run.said_down = true;
  } else {
    if (run.sink != nullptr) mark_every_look(run);
    if (run.pending.empty()) say_back(run);  // else when it has taken a look
  }
  watch(run, true);
}

// A port has done its work: whatever was wrong is over.
void Pump::say_back(PortRun& run) {
  run.retry_ns = 0;
  if (!run.said_down) return;
  run.said_down = false;
  run.trouble.clear();
  say(NoticeLevel::kInfo, "port-back", run, "back");
}

// Listens to the port's descriptor, or to none. `again`: even if the number is the one that is listened to.
void Pump::watch(PortRun& run, bool again) {
  const bool deaf = run.failed || run.muted || run.port->state() == PortState::kEnded;
  const int fd = deaf ? -1 : run.port->poll_fd();
  if (fd == run.watched_fd && (fd < 0 || !again)) return;
  const int old_fd = run.watched_fd;
  run.watched_fd = fd;
  if (old_fd >= 0 && old_fd != fd) {
    bool shared = false;
    for (const std::vector<PortRun>* runs : {&sources_, &sinks_})
      for (const PortRun& other : *runs) shared = shared || other.watched_fd == old_fd;
    if (!shared) waiter_.unwatch(old_fd);
  }
  if (fd < 0) return;
  if (const Status watched = waiter_.watch(fd); !watched) {
    run.watched_fd = -1;
    run.failed = run.down = true;
    run.trouble = watched.error().message;
    ++run.failures;
    run.retry_ns = kRetryMaxNs;
    run.said_down = true;
    say(NoticeLevel::kWarning, "port-lost", run, fmt::format("lost: {}", run.trouble));
  }
}

void Pump::say(NoticeLevel level, std::string_view id, const PortRun& run, const std::string& text,
               Universe universe) const {
  if (!options_.say) return;
  const std::string line = fmt::format("{}: {}", run.name, text);
  options_.say({.level = level, .id = id, .text = line, .port = run.name, .universe = universe});
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

// A deadline that lay in the past already when it was asked for means "at once": it counts from the last tick.
void Pump::record_lateness(PortRun& run, TimeNs deadline_ns, TimeNs now_ns) {
  if (deadline_ns <= now_ns) run.lateness.record(now_ns - std::max(deadline_ns, tick_ns_));
}

// --- Begin and end ---------------------------------------------------------------------------------------------------

Pump::Pump(Universes& universes, Clock& clock, Waiter& waiter, PumpOptions options)
    : universes_(universes),
      clock_(clock),
      waiter_(waiter),
      options_(std::move(options)),
      merge_(universes.count(), options_.merge),
      inlet_(*this),
      universe_runs_(static_cast<std::size_t>(universes.count())) {
  FL_CHECK_GT(options_.status_period_ns, 0);
}

Pump::PortRun Pump::make_run(Port& port, std::span<const Universe> universes) const {
  FL_CHECK(!started_);
  PortRun run;
  run.port = &port;
  run.name = port.name();
  run.universes.assign(universes.begin(), universes.end());
  run.position_of_index.assign(universe_runs_.size(), -1);
  for (const Universe universe : run.universes) {
    const int index = universes_.index_of(universe);
    // A universe named twice is carried once, at its first position.
    const bool is_new = index >= 0 && run.position_of_index[static_cast<std::size_t>(index)] < 0;
    if (is_new) run.position_of_index[static_cast<std::size_t>(index)] = static_cast<int>(run.index_of_position.size());
    run.index_of_position.push_back(is_new ? index : -1);
    if (index < 0)
      say(NoticeLevel::kWarning, "universe-unused", run,
          fmt::format("universe {} is not among those of this run; it stays unused", universe), universe);
  }
  run.frames.resize(run.universes.size());
  run.frames_before.resize(run.universes.size());
  run.rates_hz.resize(run.universes.size());
  return run;
}

void Pump::add_source(Source& source) {
  PortRun run = make_run(source, source.universes());
  run.source = &source;
  sources_.push_back(std::move(run));
}

void Pump::add_sink(Sink& sink) {
  PortRun run = make_run(sink, sink.universes());
  run.sink = &sink;
  if (sink.rate_hz_max() > 0.0) run.period_ns = static_cast<double>(kNsPerS) / sink.rate_hz_max();
  run.pending.reserve(run.universes.size());
  run.batch.reserve(run.universes.size());
  run.batch_positions.reserve(run.universes.size());
  run.pending_flags.resize(run.universes.size());
  run.paces.resize(run.universes.size());
  sinks_.push_back(std::move(run));
}

void Pump::add_tap(FrameReceiver& tap) {
  FL_CHECK(!started_);
  taps_.push_back(&tap);
}

void Pump::set_mode(Universe universe, MergeMode mode) {
  FL_CHECK(!started_);
  const int index = universes_.index_of(universe);
  FL_CHECK_GE(index, 0);
  merge_.set_mode(index, mode);
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
  ready_fds_.resize(std::max<std::size_t>(1, sources_.size() + sinks_.size()));

  // Looks that are in the buffer already: from before, or filled by the main.
  std::array<std::uint8_t, kSlotCountMax> levels;
  FrameStamp stamp;
  for (int index = 0; index < universes_.count(); ++index) {
    universes_.snapshot(index, levels, stamp);
    if (stamp.revision == 0) continue;
    universe_runs_[static_cast<std::size_t>(index)].has_look = true;
    FrameView frame;
    frame.stamp_ns = stamp.stamp_ns;
    frame.sender = stamp.sender;
    frame.sequence = stamp.sequence;
    frame.slots = levels;
    merge_.set_look(index, frame);
  }

  for (std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (PortRun& run : *runs) {
      run.ready = false;
      run.muted = false;
      run.polled_ns = now_ns;
      settle(run, {}, now_ns);
      if (run.sink == nullptr) continue;
      mark_every_look(run);
      send_pending(run, now_ns);
    }
  fill(spare_status_, now_ns);
  const std::lock_guard lock(published_mutex_);
  published_ = spare_status_;
}

void Pump::stop() {
  if (!started_) return;
  const TimeNs now_ns = clock_.now_ns();
  for (PortRun& run : sinks_) {
    send_pending(run, now_ns, /*ignore_cap=*/true);
    run.sink->close(now_ns);
  }
  for (std::vector<PortRun>* runs : {&sources_, &sinks_})
    for (PortRun& run : *runs) {
      if (run.watched_fd >= 0) waiter_.unwatch(run.watched_fd);
      run.watched_fd = -1;
    }
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
      for (std::size_t p = 0; p < run.frames.size(); ++p) {
        run.rates_hz[p] = static_cast<double>(run.frames[p] - run.frames_before[p]) / period_s;
        run.frames_before[p] = run.frames[p];
      }

  if (!status_wanted_.exchange(false, std::memory_order_acq_rel)) return;
  fill(spare_status_, now_ns);
  const std::unique_lock lock(published_mutex_, std::try_to_lock);
  if (lock.owns_lock()) {
    std::swap(published_, spare_status_);
  } else {
    status_wanted_.store(true, std::memory_order_release);  // somebody is copying the last one: next time
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
    for (const PortRun& run : *runs) {
      PortStatus& port = status.ports[port_number++];
      port.name = run.name;
      port.is_sink = run.sink != nullptr;
      port.state = run.down ? PortState::kGone : run.port->state();
      port.trouble = run.failed ? run.trouble : run.port->trouble();
      port.port = run.port->counters();
      port.frames = 0;
      port.rate_hz = 0.0;
      port.replaced = run.replaced;
      port.unrouted = run.unrouted;
      port.failures = run.failures;
      port.lateness = timing_of(run.lateness);
      port.latency = timing_of(run.latency);
      port.universes.resize(run.universes.size());
      for (std::size_t p = 0; p < run.universes.size(); ++p) {
        port.universes[p] = {.universe = run.universes[p], .frames = run.frames[p], .rate_hz = run.rates_hz[p]};
        port.frames += run.frames[p];
        port.rate_hz += run.rates_hz[p];
      }
    }
  status.universes.resize(universe_runs_.size());
  std::array<std::uint8_t, kSlotCountMax> levels;
  for (int index = 0; index < universes_.count(); ++index) {
    const auto i = static_cast<std::size_t>(index);
    UniverseStatus& universe = status.universes[i];
    universe.universe = universes_.numbers()[i];
    universes_.snapshot(index, levels, universe.newest);
    universe.priority = merge_.look(index).priority;
    universe.rate_hz = universe_runs_[i].rate_hz;
    universe.writes = universe_runs_[i].writes;
    universe.senders = merge_.sender_count(index);
    universe.winners = merge_.winner_count(index);
    universe.merge = merge_.counters(index);
  }
}

}  // namespace footlight

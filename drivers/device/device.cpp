#include "drivers/device/device.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "drivers/fd.h"
#include "drivers/rdm/rdm_widget.h"
#include "drivers/wait/real_time.h"
#include "sim/core/check.h"
#include "sim/core/no_signals.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kLineLostNs = 1'250 * kNsPerMs;  // when a receiver considers the line lost, E1.11 section 9.3 plus
                                                      // a frame
constexpr int kTimeoutCountMax = 3;                   // consecutive sends; then the device is opened again

}  // namespace

struct DevicePort {
  const DevicePortConfig config;
  const LineUse use;
  const std::vector<Universe> universes;
  EventFd event;

  // Guarded by the device's mutex.
  PortCounters counters;
  bool settled = false;  // the thread has accepted it, or rejected it with `refusal`
  bool leaving = false;
  bool left = false;
  Status refusal;
};

// run() is the device thread. Members above `mutex_` are used by that thread only, and by start() before it exists.
class Device final : private WidgetContext {
 public:
  Device(DevicePlan plan, std::string identity, Clock& clock)
      : retry_ns_(plan.retry_ns),
        widget_(std::move(plan.widget)),
        opener_(std::move(plan.opener)),
        clock_(clock),
        uses_(static_cast<std::size_t>(widget_->line_count()), LineUse::kUnused),
        outs_(uses_.size()),
        shared_{.identity = std::move(identity)} {
    shared_.boxes.resize(uses_.size());
  }
  ~Device() override {
    if (!thread_.joinable()) return;
    opener_->abort();
    thread_.request_stop();
    thread_.join();
  }

  [[nodiscard]] bool is(const std::string& identity, const Clock& clock) {
    const std::lock_guard lock(mutex_);
    return !identity.empty() && &clock == &clock_ && !shared_.ended && shared_.identity == identity;
  }

  // Adds the lines of a port, before start() or while the device runs.
  Status join(const std::shared_ptr<DevicePort>& port) {
    for (const DeviceLine& line : port->config.lines) {
      if (line.line < 0 || line.line >= widget_->line_count())
        return fail(ErrorCode::kBadInput, "{}: has {} DMX connector{}, there is no connector {}", port->config.name,
                    widget_->line_count(), widget_->line_count() == 1 ? "" : "s", line.line + 1);
      if (const Status can = widget_->can(line.line, port->use); !can)
        return fail(can.error().code, "{}: {}", port->config.name, can.error().message);
    }
    std::unique_lock lock(mutex_);
    if (shared_.ended) return fail(ErrorCode::kPermission, "{}: is being closed; try again", port->config.name);
    for (const DeviceLine& line : port->config.lines)
      if (const auto& owner = box_of(line).port)
        return fail(ErrorCode::kPermission, "{}: connector {} is in use by {} of this program", port->config.name,
                    line.line + 1, owner == port ? "the same port" : owner->config.name);
    for (const DeviceLine& line : port->config.lines) box_of(line) = {.port = port};
    shared_.ports.push_back(port);
    if (!thread_.joinable()) return {};
    shared_.lines_changed = true;
    opener_->wake();
    settled_.wait(lock, [&] { return port->settled; });
    if (!port->refusal) return port->refusal;
    return {};
  }

  // Opens the device on the caller's thread, once, then starts the device thread.
  Status start() {
    if (Status opened = open_device(); !opened) {
      const bool waits = std::all_of(shared_.ports.begin(), shared_.ports.end(),
                                     [](const auto& port) { return port->config.wait_for_device; });
      if (!waits || opened.error().code != ErrorCode::kNotFound) return opened;
      lose(opened.error());
    }
    const NoSignals for_the_thread;
    thread_ = std::jthread([this](const std::stop_token& stop) {
      (void)enter_real_time();  // the main program reports a refusal once
      stop_ = stop;
      run();
    });
    return {};
  }

  // politely: sends the final frames and the widget's final messages; otherwise ends at once.
  void leave(const std::shared_ptr<DevicePort>& port, bool politely) {
    std::unique_lock lock(mutex_);
    if (port->left) return;
    port->leaving = true;
    const bool last =
        std::all_of(shared_.ports.begin(), shared_.ports.end(), [](const auto& other) { return other->leaving; });
    if (!last) {
      shared_.lines_changed = true;
      opener_->wake();
      settled_.wait(lock, [&] { return port->left; });
      return;
    }
    shared_.ended = true;  // no port can join from here on
    lock.unlock();
    thread_.request_stop();
    if (politely)
      opener_->wake();
    else
      opener_->abort();
    if (thread_.joinable()) thread_.join();
    lock.lock();
    while (!shared_.ports.empty()) forget(*shared_.ports.back());
    shared_.state = PortState::kEnded;
    shared_.trouble.clear();
  }

  [[nodiscard]] bool has_ended() {
    const std::lock_guard lock(mutex_);
    return shared_.ended;
  }
  [[nodiscard]] bool has_rdm() const { return dynamic_cast<const RdmWidget*>(widget_.get()) != nullptr; }

  void post(DeviceJob job) {
    std::unique_lock lock(mutex_);
    if (shared_.ended) {
      lock.unlock();
      return job(*widget_, nullptr);
    }
    shared_.jobs.push_back(std::move(job));
    opener_->wake();
  }

  struct Box {  // the mailbox of a line
    std::shared_ptr<DevicePort> port;
    std::array<std::uint8_t, kLineFrameMax> frame{};  // output: the snapshot to send; input: the newest frame
    std::size_t size = 0;                             // 0: no frame yet
    bool fresh = false;                               // the other side has not used `frame` yet
    bool resting = false;                             // output: the last frame is not repeated
    TimeNs stamp_ns = 0;                              // input: when it was received
  };
  struct Shared {
    std::string identity;  // of the connector
    PortState state = PortState::kGone;
    std::string trouble;
    WidgetTraits traits;
    DeviceStats stats;
    std::uint64_t rejected = 0;
    std::uint64_t errors = 0;
    std::vector<Box> boxes;  // per line
    std::vector<std::shared_ptr<DevicePort>> ports;
    bool lines_changed = false;  // a port has joined or is leaving
    bool ended = false;
    std::vector<DeviceJob> jobs;
    std::vector<WidgetFigure> figures;
    bool figures_wanted = false;
  };
  // Runs f(shared) under the lock and returns its result. f must not block.
  template <class F>
  decltype(auto) with_shared(F&& f) {
    const std::lock_guard lock(mutex_);
    return f(shared_);
  }
  Opener& opener() { return *opener_; }

 private:
  // The thread's state of an output line.
  struct Out {
    Slots snapshot{};
    bool have_snapshot = false;
    bool sent = false;  // since the lines were set up
    bool owed = false;  // taken from its mailbox and not sent yet
    TimeNs due_ns = 0;  // when the repeat is due
  };

  // --- WidgetContext
  Transport& transport() override { return *transport_; }
  TimeNs now_ns() const override { return clock_.now_ns(); }
  void sleep_until_ns(TimeNs deadline_ns) override { clock_.sleep_until_ns(deadline_ns); }
  std::span<const LineUse> lines() const override { return uses_; }
  bool stopping() const override { return stop_.stop_requested(); }
  void deliver(int line, std::span<const std::uint8_t> line_frame, TimeNs stamp_ns) override {
    FL_CHECK_LE(line_frame.size(), kLineFrameMax);
    if (line_frame.empty()) return;
    with_shared([&](Shared& shared) {
      Box& box = shared.boxes[static_cast<std::size_t>(line)];
      if (!box.port || box.port->use != LineUse::kInput) return;
      if (line_frame[0] != kStartCodeLevels) {
        ++shared.stats.other_start_codes;
        return;
      }
      if (box.fresh) ++box.port->counters.dropped;
      ++box.port->counters.frames;
      std::copy(line_frame.begin(), line_frame.end(), box.frame.begin());
      box.size = line_frame.size();
      box.fresh = true;
      box.stamp_ns = stamp_ns;
      box.port->event.signal();
    });
  }
  void count_rejected(std::uint64_t count) override {
    with_shared([&](Shared& shared) { shared.rejected += count; });
  }

  Box& box_of(const DeviceLine& line) { return shared_.boxes[static_cast<std::size_t>(line.line)]; }
  void forget(const DevicePort& port);
  void run();
  Status open_device();
  Status begin();
  Status set_lines_up();
  void run_jobs();
  void take_figures();
  Status work();
  Status send(std::size_t line);
  void take_snapshot(std::size_t line);
  Status send_final_frames(const DevicePort& port);
  void lose(const Error& error);
  void signal_all();

  const DurationNs retry_ns_;
  const std::unique_ptr<Widget> widget_;
  const std::unique_ptr<Opener> opener_;
  Clock& clock_;
  std::stop_token stop_;
  std::unique_ptr<Transport> transport_;  // empty while the device is gone
  std::vector<LineUse> uses_;             // per line, as passed to the widget
  std::vector<Out> outs_;                 // per line
  std::size_t next_line_ = 0;             // the line that is checked first
  int timeout_count_ = 0;
  DurationNs keep_alive_ns_ = kTimeNever;
  bool host_timed_ = false;

  std::mutex mutex_;
  std::condition_variable settled_;
  Shared shared_;        // guarded by mutex_
  std::jthread thread_;  // last member: it ends before the members that it uses
};

// Call with the lock held.
void Device::forget(const DevicePort& port) {
  for (Box& box : shared_.boxes)
    if (box.port.get() == &port) box = {};
  const auto found =
      std::find_if(shared_.ports.begin(), shared_.ports.end(), [&](const auto& one) { return one.get() == &port; });
  if (found == shared_.ports.end()) return;
  const std::shared_ptr<DevicePort> kept = *found;
  shared_.ports.erase(found);
  kept->left = kept->settled = true;
  settled_.notify_all();
}

void Device::run() {
  while (!stopping()) {
    if (with_shared([](Shared& shared) { return shared.lines_changed; })) {
      if (const Status set_up = set_lines_up(); !set_up) lose(set_up.error());
    }
    if (!transport_) {
      run_jobs();
      if (const Status opened = open_device(); !opened) {
        lose(opened.error());
        opener_->wait(clock_.now_ns() + retry_ns_);
        continue;
      }
    }
    run_jobs();
    const Status worked = work();
    take_figures();
    if (!worked) {
      lose(worked.error());
      // With a pause: a device that opens and then always fails must not use a whole processor core.
      if (!stopping()) opener_->wait(clock_.now_ns() + retry_ns_);
    }
  }
  std::vector<std::shared_ptr<DevicePort>> ports = with_shared([](Shared& shared) { return shared.ports; });
  Status sent;
  for (const auto& port : ports)
    if (transport_ && sent) sent = send_final_frames(*port);
  if (transport_ && sent) sent = widget_->end(*this);
  if (!sent) lose(sent.error());
  with_shared([](Shared& shared) { shared.figures_wanted = true; });  // the last values stay
  take_figures();
  transport_.reset();
  run_jobs();
}

void Device::lose(const Error& error) {
  transport_.reset();
  for (Out& out : outs_) out.sent = false;
  with_shared([&](Shared& shared) {
    if (shared.state != PortState::kGone) ++shared.errors;
    shared.state = PortState::kGone;
    shared.trouble = error.message;
  });
  signal_all();
}

void Device::signal_all() {
  with_shared([](Shared& shared) {
    for (const auto& port : shared.ports) port->event.signal();
  });
}

// Adds the ports that have joined, and sends the final frames of those that leave.
Status Device::set_lines_up() {
  struct Change {
    std::vector<std::shared_ptr<DevicePort>> joined, leaving;
  };
  const Change change = with_shared([](Shared& shared) {
    Change found;
    shared.lines_changed = false;
    for (const auto& port : shared.ports) {
      if (port->leaving) found.leaving.push_back(port);
      if (!port->leaving && !port->settled) found.joined.push_back(port);
    }
    return found;
  });
  Status worked;
  for (const auto& port : change.leaving) {
    if (transport_ && worked) worked = send_final_frames(*port);
    with_shared([&](Shared&) { forget(*port); });
  }
  if (transport_ && worked) worked = begin();
  if (!worked && transport_ && worked.error().code == ErrorCode::kUnsupported && !change.joined.empty()) {
    // The device works; the new port requests something that it does not support.
    for (const auto& port : change.joined) {
      port->refusal = fail(ErrorCode::kUnsupported, "{}: {}", port->config.name, worked.error().message);
      with_shared([&](Shared&) { forget(*port); });
    }
    worked = begin();
  }
  for (const auto& port : change.joined) with_shared([&](Shared&) { port->settled = true; });
  settled_.notify_all();
  return worked;
}

Status Device::open_device() {
  FL_ASSIGN(transport_, opener_->connect());
  std::string identity = opener_->identity();
  if (Status begun = begin(); !begun) {
    transport_.reset();
    return begun;
  }
  with_shared([&](Shared& shared) {
    if (!identity.empty()) shared.identity = std::move(identity);
    shared.state = PortState::kWorking;
    shared.trouble.clear();
    ++shared.stats.connects;
    for (const auto& port : shared.ports) port->settled = true;
  });
  settled_.notify_all();
  signal_all();
  return {};
}

// Configures the widget for its lines; every snapshot is sent again.
Status Device::begin() {
  with_shared([&](Shared& shared) {
    for (std::size_t line = 0; line < uses_.size(); ++line) {
      uses_[line] = shared.boxes[line].port ? shared.boxes[line].port->use : LineUse::kUnused;
      outs_[line].sent = false;
      if (uses_[line] != LineUse::kOutput) outs_[line] = {};
    }
  });
  timeout_count_ = 0;
  FL_ASSIGN(WidgetTraits traits, widget_->begin(*this));
  keep_alive_ns_ = traits.keep_alive_ns;
  host_timed_ = traits.host_timed;
  with_shared([&](Shared& shared) { shared.traits = std::move(traits); });
  return {};
}

void Device::run_jobs() {
  const auto jobs = with_shared([](Shared& shared) { return std::exchange(shared.jobs, {}); });
  for (const DeviceJob& job : jobs) job(*widget_, transport_ ? this : nullptr);
}

void Device::take_figures() {
  if (!with_shared([](Shared& shared) { return shared.figures_wanted; })) return;
  auto figures = widget_->figures();
  with_shared([&](Shared& shared) {
    shared.figures = std::move(figures);
    shared.figures_wanted = false;
  });
  signal_all();
}

void Device::take_snapshot(std::size_t line) {
  Out& out = outs_[line];
  with_shared([&](Shared& shared) {
    Box& box = shared.boxes[line];
    if (std::exchange(box.resting, false)) out.have_snapshot = out.owed = false;
    if (!box.fresh || uses_[line] != LineUse::kOutput) return;
    if (out.owed && box.port) ++box.port->counters.dropped;
    std::copy(box.frame.begin() + 1, box.frame.end(), out.snapshot.begin());
    box.fresh = false;
    out.have_snapshot = out.owed = true;
  });
}

// Sends one snapshot, or listens until there is one to send.
Status Device::work() {
  const TimeNs now_ns = clock_.now_ns();
  TimeNs due_ns = kTimeNever;
  for (std::size_t i = 0; i < outs_.size(); ++i) {
    const std::size_t line = (next_line_ + i) % outs_.size();
    take_snapshot(line);
    Out& out = outs_[line];
    if (!out.have_snapshot) continue;
    if (out.owed || !out.sent || now_ns >= out.due_ns) {
      next_line_ = line + 1;
      return send(line);
    }
    due_ns = std::min(due_ns, out.due_ns);
  }
  return widget_->listen(*this, due_ns);
}

Status Device::send(std::size_t line) {
  Out& out = outs_[line];
  const TimeNs now_ns = clock_.now_ns();
  const Status sent = widget_->send(*this, static_cast<int>(line), out.snapshot);
  if (!sent) {
    // A failed snapshot is due again, unless a newer one arrives before.
    if (sent.error().code != ErrorCode::kTimeout || ++timeout_count_ >= kTimeoutCountMax) return sent;
    out.sent = false;
    with_shared([](Shared& shared) { ++shared.errors; });
    return {};
  }
  timeout_count_ = 0;
  const bool again = !out.owed && out.sent;
  // If the host times the frames, the delay of one frame does not shift the next.
  const bool on_time = host_timed_ && again && now_ns < out.due_ns + keep_alive_ns_;
  out.due_ns = keep_alive_ns_ == kTimeNever ? kTimeNever : (on_time ? out.due_ns : now_ns) + keep_alive_ns_;
  out.sent = true;
  out.owed = false;
  with_shared([&](Shared& shared) {
    if (shared.boxes[line].port) ++shared.boxes[line].port->counters.frames;
    if (again) ++shared.stats.keep_alives;
  });
  return {};
}

// Sends the newest unsent snapshot, or zeros.
Status Device::send_final_frames(const DevicePort& port) {
  if (port.use != LineUse::kOutput) return {};
  for (const DeviceLine& at : port.config.lines) {
    const auto line = static_cast<std::size_t>(at.line);
    take_snapshot(line);
    Out& out = outs_[line];
    if (port.config.blackout_on_exit) {
      out.snapshot.fill(0);
      out.owed = true;
    }
    if (out.owed) FL_TRY(send(line));
  }
  return {};
}

// --- Shared by sinks and sources

namespace {

// All open devices, so that none is opened twice. Entries expire with their devices.
struct OpenDevices {
  std::mutex mutex;
  std::vector<std::weak_ptr<Device>> devices;  // guarded by mutex
};
OpenDevices& open_devices() {
  static OpenDevices open;
  return open;
}

std::vector<Universe> universes_of(const DevicePortConfig& config) {
  std::vector<Universe> universes;
  for (const DeviceLine& line : config.lines) universes.push_back(line.universe);
  return universes;
}

}  // namespace

DeviceLink::DeviceLink(std::shared_ptr<Device> device, std::shared_ptr<DevicePort> port)
    : device_(std::move(device)), port_(std::move(port)) {}
DeviceLink::DeviceLink(DeviceLink&&) noexcept = default;
DeviceLink::~DeviceLink() {
  if (device_) device_->leave(port_, false);
}

Result<DeviceLink> DeviceLink::open(DevicePlan plan, const DevicePortConfig& config, LineUse use, Clock& clock) {
  FL_CHECK(plan.widget && plan.opener);
  for (const DeviceLine& line : config.lines) FL_CHECK(is_universe(line.universe));
  auto port = std::make_shared<DevicePort>(config, use, universes_of(config));
  FL_CHECK(port->event);
  const std::string identity = plan.opener->identity();
  OpenDevices& open = open_devices();
  const std::lock_guard lock(open.mutex);
  std::erase_if(open.devices, [](const auto& device) { return device.expired(); });
  for (const auto& entry : open.devices) {
    std::shared_ptr<Device> device = entry.lock();
    if (!device || !device->is(identity, clock)) continue;
    FL_TRY(device->join(port));
    return DeviceLink(std::move(device), std::move(port));
  }
  auto device = std::make_shared<Device>(std::move(plan), identity, clock);
  FL_TRY(device->join(port));
  FL_TRY(device->start());
  open.devices.push_back(device);
  return DeviceLink(std::move(device), std::move(port));
}

void DeviceLink::close() { device_->leave(port_, true); }
void DeviceLink::run_on_device(DeviceJob job) const { device_->post(std::move(job)); }
std::span<const DeviceLine> DeviceLink::lines() const { return port_->config.lines; }
bool DeviceLink::has_rdm() const { return device_->has_rdm(); }

bool DeviceHandle::is_gone() const {
  const auto device = device_.lock();
  return !device || device->has_ended();
}
bool DeviceHandle::run_on_device(DeviceJob job) const {
  const auto device = device_.lock();
  if (!device || device->has_ended()) return false;
  device->post(std::move(job));
  return true;
}

std::string DeviceLink::identity() const {
  return device_->with_shared([](const auto& shared) { return shared.traits.identity; });
}
std::vector<std::string> DeviceLink::remarks() const {
  return device_->with_shared([](const auto& shared) { return shared.traits.remarks; });
}
DeviceStats DeviceLink::stats() const {
  return device_->with_shared([](const auto& shared) { return shared.stats; });
}
std::vector<WidgetFigure> DeviceLink::figures() const {
  std::vector<WidgetFigure> figures;
  take_figures(figures);
  return figures;
}
void DeviceLink::take_figures(std::vector<PortFigure>& into) const {
  const bool ended = device_->with_shared([&](auto& shared) {
    shared.figures_wanted = true;
    into.resize(shared.figures.size());
    std::copy(shared.figures.begin(), shared.figures.end(), into.begin());
    return shared.ended;
  });
  if (!ended) device_->opener().wake();
}

namespace {

PortState state_of(const DeviceLink& link) {
  return link.device().with_shared(
      [&](const auto& shared) { return link.port().left ? PortState::kEnded : shared.state; });
}
std::string trouble_of(const DeviceLink& link) {
  return link.device().with_shared([&](const auto& shared) {
    return shared.trouble.empty() ? std::string{} : fmt::format("{}: {}", link.port().config.name, shared.trouble);
  });
}
PortCounters counters_of(const DeviceLink& link) {
  return link.device().with_shared([&](const auto& shared) {
    PortCounters counters = link.port().counters;
    counters.rejected += shared.rejected;
    counters.errors += shared.errors;
    return counters;
  });
}

}  // namespace

// --- Sink

Result<std::unique_ptr<DeviceSink>> DeviceSink::open(DevicePlan plan, const DevicePortConfig& config, Clock& clock) {
  FL_ASSIGN(DeviceLink link, DeviceLink::open(std::move(plan), config, LineUse::kOutput, clock));
  return std::unique_ptr<DeviceSink>(new DeviceSink(std::move(link)));
}

std::string DeviceSink::name() const { return link_.port().config.name; }
int DeviceSink::poll_fd() const { return link_.port().event.get(); }
PortState DeviceSink::state() const { return state_of(link_); }
std::string DeviceSink::trouble() const { return trouble_of(link_); }
PortCounters DeviceSink::counters() const { return counters_of(link_); }
std::span<const Universe> DeviceSink::universes() const { return link_.port().universes; }
double DeviceSink::rate_hz_max() const {
  return link_.device().with_shared([](const auto& shared) { return shared.traits.rate_hz_max; });
}

std::optional<std::uint64_t> DeviceSink::frames_on_line() const {
  return link_.device().with_shared([&](const auto& shared) -> std::optional<std::uint64_t> {
    if (!shared.traits.host_timed) return std::nullopt;
    return link_.port().counters.frames;
  });
}

Status DeviceSink::send(TimeNs, std::span<const FrameView> frames) {
  const DevicePort& port = link_.port();
  for (const FrameView& frame : frames) {
    if (frame.terminated || frame.start_code != kStartCodeLevels) continue;
    const auto position = std::find(port.universes.begin(), port.universes.end(), frame.universe);
    if (position == port.universes.end()) continue;
    const DeviceLine& at = port.config.lines[static_cast<std::size_t>(position - port.universes.begin())];
    FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
    const bool open = link_.device().with_shared([&](auto& shared) {
      Device::Box& box = shared.boxes[static_cast<std::size_t>(at.line)];
      if (box.port.get() != &port) return false;  // closed
      if (box.fresh) ++box.port->counters.dropped;
      std::copy(frame.slots.begin(), frame.slots.end(), box.frame.begin() + 1);
      box.size = box.frame.size();
      box.fresh = true;
      return shared.state == PortState::kWorking;
    });
    // A lost device is searched for at its own interval, not at that of the frames.
    if (open) link_.device().opener().wake();
  }
  return {};
}

Status DeviceSink::poll(TimeNs) {
  link_.port().event.clear();
  return {};
}

void DeviceSink::rest(TimeNs) {
  const DevicePort& port = link_.port();
  link_.device().with_shared([&](auto& shared) {
    for (const DeviceLine& at : port.config.lines) {
      Device::Box& box = shared.boxes[static_cast<std::size_t>(at.line)];
      if (box.port.get() != &port) continue;  // closed
      box.fresh = false;
      box.resting = true;
    }
  });
  link_.device().opener().wake();
}

void DeviceSink::close(TimeNs) { link_.close(); }

// --- Source

DeviceSource::DeviceSource(DeviceLink link) : link_(std::move(link)), lines_(link_.port().config.lines.size()) {}
DeviceSource::~DeviceSource() { link_.close(); }

Result<std::unique_ptr<DeviceSource>> DeviceSource::open(DevicePlan plan, const DevicePortConfig& config,
                                                         Clock& clock) {
  FL_ASSIGN(DeviceLink link, DeviceLink::open(std::move(plan), config, LineUse::kInput, clock));
  return std::unique_ptr<DeviceSource>(new DeviceSource(std::move(link)));
}

std::string DeviceSource::name() const { return link_.port().config.name; }
int DeviceSource::poll_fd() const { return link_.port().event.get(); }
std::string DeviceSource::trouble() const { return trouble_of(link_); }
PortCounters DeviceSource::counters() const { return counters_of(link_); }
std::span<const Universe> DeviceSource::universes() const { return link_.port().universes; }

TimeNs DeviceSource::next_deadline_ns() const {
  TimeNs deadline_ns = kTimeNever;
  for (const Line& line : lines_)
    if (!line.quiet) deadline_ns = std::min(deadline_ns, line.received_ns + kLineLostNs);
  return deadline_ns;
}

PortState DeviceSource::state() const {
  const bool quiet = std::all_of(lines_.begin(), lines_.end(), [](const Line& line) { return line.quiet; });
  const PortState state = state_of(link_);
  return state == PortState::kWorking && quiet ? PortState::kWaiting : state;
}

Status DeviceSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  const DevicePort& port = link_.port();
  // Cleared first: a frame that arrives after the copy below makes it readable again.
  link_.port().event.clear();
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    std::uint64_t sequence = 0;
    const bool fresh = link_.device().with_shared([&](auto& shared) {
      Device::Box& box = shared.boxes[static_cast<std::size_t>(port.config.lines[i].line)];
      if (box.port.get() != &port || !box.fresh) return false;
      box.fresh = false;
      line.frame = box.frame;
      line.size = box.size;
      line.received_ns = box.stamp_ns;
      sequence = port.counters.frames;
      return true;
    });
    if (fresh) {
      receiver.receive({.universe = port.universes[i],
                        .stamp_ns = line.received_ns,
                        .sender = std::hash<std::string>{}(port.config.name) | 1u,
                        .sequence = static_cast<std::uint32_t>(sequence),
                        .slots = std::span<const std::uint8_t>(line.frame).subspan(1, line.size - 1)});
      line.quiet = false;
    }
    if (!line.quiet && now_ns >= line.received_ns + kLineLostNs) line.quiet = true;
  }
  return {};
}

}  // namespace footlight::drivers

#include "drivers/usb/enttec_pro.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <mutex>
#include <thread>

#include "drivers/usb/libusb_connector.h"
#include "drivers/wait/real_time.h"
#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kLineLost_ns = 1'250 * kNsPerMs;    // a receiver's patience, E1.11 section 9.3 plus a frame
constexpr DurationNs kSplitMessage_ns = 100 * kNsPerMs;  // silence inside a message: the rest was lost
constexpr int kWriteTimeoutCountMax = 3;                 // then the device is opened afresh
constexpr double kLineRateHzMax = 44.0;                  // 513 slots of 44 us with the shortest break

// A counter in the kernel that poll() and epoll can wait for.
class EventFd {
 public:
  EventFd() : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) { FL_CHECK_GE(fd_, 0); }
  ~EventFd() { ::close(fd_); }
  EventFd(const EventFd&) = delete;
  EventFd& operator=(const EventFd&) = delete;
  [[nodiscard]] int fd() const { return fd_; }
  // Both can fail only by being signalled or quiet already.
  void signal() { (void)!::write(fd_, &kOne, sizeof kOne); }
  void clear() {
    std::uint64_t count = 0;
    (void)!::read(fd_, &count, sizeof count);
  }

 private:
  static constexpr std::uint64_t kOne = 1;
  const int fd_;
};

}  // namespace

// Named parts: open_device() to get to a talking widget, send_frames() and take_frames() as the two working loops,
// run() around them. What the port's thread shares with the device thread is in shared_, under mutex_.
class EnttecPro {
 public:
  enum class Direction { kOutput, kInput };

  EnttecPro(EnttecProConfig config, Direction direction, std::unique_ptr<Connector> connector, Clock& clock)
      : config_(std::move(config)), direction_(direction), connector_(std::move(connector)), clock_(clock) {
    FL_CHECK(is_universe(config_.universe));
  }
  ~EnttecPro() {
    if (thread_.joinable()) connector_->abort();
  }  // ~jthread asks the thread to stop and waits for it

  // Called once, before anything else.
  Status start() {
    if (Status opened = open_device({}); !opened) {
      if (!config_.wait_for_device || opened.error().code != ErrorCode::kNotFound) return opened;
      lose(opened.error());
    }
    thread_ = std::jthread([this](std::stop_token stop) {
      (void)enter_real_time();  // a refusal is said once, by the main
      run(stop);
    });
    return {};
  }

  // Lets the thread finish its last words and give the device back.
  void stop() {
    if (!thread_.joinable()) return;
    thread_.request_stop();
    connector_->wake();
    thread_.join();
    const std::lock_guard lock(mutex_);
    shared_.state = PortState::kEnded;
    shared_.trouble.clear();
  }

  // Everything below but the thread's functions: from the port's thread.
  struct Shared {
    PortState state = PortState::kGone;
    std::string trouble;
    PortCounters counters;
    EnttecProStats stats;
    EnttecProIdentity identity;
    LineFrame frame{};           // output: the look to send; input: the newest frame, start code first
    std::size_t frame_size = 0;  // 0: none came yet
    bool fresh = false;          // the other side has not taken `frame` yet
    TimeNs stamp_ns = 0;         // input: when it came
  };
  // Runs f(shared) under the lock; returns what f returns. f must not block.
  template <class F>
  decltype(auto) with_shared(F&& f) {
    const std::lock_guard lock(mutex_);
    return f(shared_);
  }
  EventFd& event() { return event_; }
  Connector& connector() { return *connector_; }
  const EnttecProConfig& config() const { return config_; }

 private:
  void run(const std::stop_token& stop);
  Status open_device(const std::stop_token& stop);
  Result<ProMessageView> ask(Transport& transport, const ProMessage& question, ProLabel label,
                             const std::stop_token& stop);
  Status send_frames(const std::stop_token& stop);
  Status write_look(const LineFrame& look);
  Status send_last_words();
  Status take_frames(const std::stop_token& stop);
  void take_message(const ProMessageView& message);
  void publish_line_frame();
  void lose(const Error& error);
  void count_parsed();

  const EnttecProConfig config_;
  const Direction direction_;
  const std::unique_ptr<Connector> connector_;
  Clock& clock_;
  EventFd event_;

  // The device thread's own, and start()'s before there is one.
  std::unique_ptr<Transport> transport_;  // empty while the device is gone
  ProParser parser_;
  std::array<std::uint8_t, 1024> input_{};  // bytes of the last read; unread_ points into it
  std::span<const std::uint8_t> unread_;
  LineFrame line_{};
  std::size_t line_size_ = 0;
  bool look_sent_ = false;  // since the device was opened
  bool cut_short_ = false;  // the last write ended in the middle
  std::uint64_t bad_payload_count_ = 0;
  std::uint64_t line_error_count_ = 0;

  std::mutex mutex_;
  Shared shared_;        // guarded by mutex_
  std::jthread thread_;  // last: it ends before what it uses
};

void EnttecPro::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!transport_) {
      if (const Status opened = open_device(stop); !opened) {
        lose(opened.error());
        connector_->wait(clock_.now_ns() + config_.retry_ns);
        continue;
      }
    }
    const Status worked = direction_ == Direction::kOutput ? send_frames(stop) : take_frames(stop);
    if (!worked) {
      lose(worked.error());
      // Not at once: a device that opens and then fails every time must not keep a processor busy.
      connector_->wait(clock_.now_ns() + config_.retry_ns);
    }
  }
  if (transport_ && direction_ == Direction::kOutput)
    if (const Status said = send_last_words(); !said) lose(said.error());
  transport_.reset();
}

void EnttecPro::lose(const Error& error) {
  count_parsed();
  transport_.reset();
  with_shared([&](Shared& shared) {
    if (shared.state != PortState::kGone) ++shared.counters.errors;
    shared.state = PortState::kGone;
    shared.trouble = fmt::format("{}: {}", config_.name, error.message);
  });
  event_.signal();
}

void EnttecPro::count_parsed() {
  with_shared([&](Shared& shared) {
    shared.stats.garbage_bytes = parser_.garbage_byte_count();
    shared.stats.bad_messages = parser_.rejected_count() + bad_payload_count_;
    shared.stats.line_errors = line_error_count_;
    shared.counters.rejected = shared.stats.bad_messages + line_error_count_;
  });
}

// Sends a question and waits for the message with that label; what else arrives meanwhile is dropped.
Result<ProMessageView> EnttecPro::ask(Transport& transport, const ProMessage& question, ProLabel label,
                                      const std::stop_token& stop) {
  FL_TRY(transport.write(question.bytes(), clock_.now_ns() + config_.write_timeout_ns));
  const TimeNs deadline_ns = clock_.now_ns() + config_.reply_timeout_ns;
  while (true) {
    ProMessageView message;
    while (parser_.next(unread_, message))
      if (message.label == static_cast<std::uint8_t>(label)) return message;
    if (stop.stop_requested()) return fail(ErrorCode::kDisconnected, "{}: closed", transport.where());
    if (clock_.now_ns() >= deadline_ns)
      return fail(ErrorCode::kTimeout, "{}: no answer to label {} within {} ms; is it a DMX USB Pro?",
                  transport.where(), static_cast<int>(label), config_.reply_timeout_ns / kNsPerMs);
    FL_ASSIGN(const std::size_t count, transport.read(input_, deadline_ns));
    unread_ = std::span<const std::uint8_t>(input_).first(count);
  }
}

Status EnttecPro::open_device(const std::stop_token& stop) {
  FL_ASSIGN(std::unique_ptr<Transport> transport, connector_->connect());
  parser_.reset();
  unread_ = {};
  EnttecProIdentity identity{.usb_serial = transport->serial(), .widget_serial = 0, .params = {}};

  // A program that was killed in the middle of a message, this one included, leaves the widget waiting for the rest of
  // it.
  FL_TRY(transport->write(pro_flush_bytes(), clock_.now_ns() + config_.write_timeout_ns));
  // A widget may not know its number (a blank EEPROM answers FF FF FF FF, some relatives nothing); it works all the
  // same.
  if (const auto answer = ask(*transport, encode_get_serial(), ProLabel::kSerialNumber, stop)) {
    identity.widget_serial = decode_serial(answer->payload).value_or(0);
  } else if (answer.error().code != ErrorCode::kTimeout) {
    return tl::unexpected(answer.error());
  }
  FL_ASSIGN(const ProMessageView answer, ask(*transport, encode_get_params(), ProLabel::kGetParams, stop));
  FL_ASSIGN(identity.params, decode_params(answer.payload));
  if (direction_ == Direction::kInput) {
    FL_TRY(transport->write(encode_receive_mode(config_.receive_mode).bytes(),
                            clock_.now_ns() + config_.write_timeout_ns));
    line_.fill(0);
    line_size_ = 0;
  }
  look_sent_ = false;
  cut_short_ = false;
  transport_ = std::move(transport);
  with_shared([&](Shared& shared) {
    shared.identity = std::move(identity);
    shared.state = PortState::kWorking;
    shared.trouble.clear();
    ++shared.stats.connects;
  });
  event_.signal();
  return {};
}

Status EnttecPro::send_frames(const std::stop_token& stop) {
  LineFrame look{};
  bool have_look = false;
  bool fresh = false;
  TimeNs sent_ns = 0;
  int timeout_count = 0;
  while (!stop.stop_requested()) {
    with_shared([&](Shared& shared) {
      have_look = shared.frame_size > 0;
      if (shared.fresh) fresh = true;
      if (shared.fresh || !look_sent_) look = shared.frame;
      shared.fresh = false;
    });
    const TimeNs now_ns = clock_.now_ns();
    if (have_look && (fresh || !look_sent_ || now_ns >= sent_ns + config_.keep_alive_ns)) {
      const Status sent = write_look(look);
      if (sent) {
        timeout_count = 0;
        sent_ns = now_ns;
        with_shared([&](Shared& shared) {
          ++shared.counters.frames;
          if (!fresh && look_sent_) ++shared.stats.keep_alives;
        });
        look_sent_ = true;
        fresh = false;
      } else {
        // A look that did not get through is due again, unless a newer one has come by then.
        with_shared([&](Shared& shared) {
          if (!shared.fresh && fresh) shared.fresh = true;
        });
        if (sent.error().code != ErrorCode::kTimeout || ++timeout_count >= kWriteTimeoutCountMax) return sent;
        with_shared([](Shared& shared) { ++shared.counters.errors; });
      }
      continue;
    }
    // Nothing to send: sleep in a read, which notices an unplug and takes what the widget has to say off its hands.
    const TimeNs due_ns = have_look ? sent_ns + config_.keep_alive_ns : kTimeNever;
    FL_ASSIGN(const std::size_t count, transport_->read(input_, due_ns));
    unread_ = std::span<const std::uint8_t>(input_).first(count);
    ProMessageView message;
    while (parser_.next(unread_, message)) {
    }
    count_parsed();
  }
  return {};
}

Status EnttecPro::write_look(const LineFrame& look) {
  const TimeNs deadline_ns = clock_.now_ns() + config_.write_timeout_ns;
  if (cut_short_) {
    // The widget still waits for the rest of a message and would take this one for it.
    FL_TRY(transport_->write(pro_flush_bytes(), deadline_ns));
    cut_short_ = false;
  }
  const Status sent = transport_->write(encode_send_dmx(std::span(look).subspan(1)).bytes(), deadline_ns);
  cut_short_ = !sent;
  return sent;
}

// The newest look that was never sent, or darkness.
Status EnttecPro::send_last_words() {
  LineFrame look{};
  bool wanted = config_.blackout_on_exit;
  if (!wanted)
    with_shared([&](Shared& shared) {
      wanted = shared.fresh;
      look = shared.frame;
      shared.fresh = false;
    });
  if (!wanted) return {};
  FL_TRY(write_look(look));
  with_shared([](Shared& shared) { ++shared.counters.frames; });
  return {};
}

Status EnttecPro::take_frames(const std::stop_token& stop) {
  TimeNs heard_ns = clock_.now_ns();
  while (!stop.stop_requested()) {
    ProMessageView message;
    while (parser_.next(unread_, message)) take_message(message);
    count_parsed();
    FL_ASSIGN(const std::size_t count,
              transport_->read(input_, parser_.pending() ? heard_ns + kSplitMessage_ns : kTimeNever));
    unread_ = std::span<const std::uint8_t>(input_).first(count);
    const TimeNs now_ns = clock_.now_ns();
    if (count > 0)
      heard_ns = now_ns;
    else if (parser_.pending() && now_ns >= heard_ns + kSplitMessage_ns)
      parser_.abandon();
  }
  return {};
}

void EnttecPro::take_message(const ProMessageView& message) {
  switch (static_cast<ProLabel>(message.label)) {
    case ProLabel::kReceived: {
      const auto received = decode_received(message.payload);
      if (!received) {
        ++bad_payload_count_;
        return;
      }
      if (received->queue_overflow || received->overrun) {
        // Slots may be missing anywhere in it, so that the rest sits at wrong addresses.
        ++line_error_count_;
        return;
      }
      std::copy(received->frame.begin(), received->frame.end(), line_.begin());
      line_size_ = received->frame.size();
      break;
    }
    case ProLabel::kChangeOfState:
      if (!apply_change_of_state(message.payload, line_)) {
        ++bad_payload_count_;
        return;
      }
      line_size_ = line_.size();
      break;
    default: return;  // late answers, and labels of relatives
  }
  publish_line_frame();
}

void EnttecPro::publish_line_frame() {
  if (line_[0] != 0) {
    with_shared([](Shared& shared) { ++shared.stats.other_start_codes; });
    return;
  }
  const TimeNs now_ns = clock_.now_ns();
  with_shared([&](Shared& shared) {
    if (shared.fresh) ++shared.counters.dropped;
    ++shared.counters.frames;
    shared.frame = line_;
    shared.frame_size = line_size_;
    shared.fresh = true;
    shared.stamp_ns = now_ns;
  });
  event_.signal();
}

// --- Sink

EnttecProSink::EnttecProSink(std::unique_ptr<EnttecPro> device) : device_(std::move(device)) {}
EnttecProSink::~EnttecProSink() = default;

Result<std::unique_ptr<EnttecProSink>> EnttecProSink::open(EnttecProConfig config, std::unique_ptr<Connector> connector,
                                                           Clock& clock) {
  auto device =
      std::make_unique<EnttecPro>(std::move(config), EnttecPro::Direction::kOutput, std::move(connector), clock);
  FL_TRY(device->start());
  return std::unique_ptr<EnttecProSink>(new EnttecProSink(std::move(device)));
}

std::string EnttecProSink::name() const { return device_->config().name; }
int EnttecProSink::poll_fd() const { return device_->event().fd(); }
PortState EnttecProSink::state() const {
  return device_->with_shared([](const auto& shared) { return shared.state; });
}
std::string EnttecProSink::trouble() const {
  return device_->with_shared([](const auto& shared) { return shared.trouble; });
}
PortCounters EnttecProSink::counters() const {
  return device_->with_shared([](const auto& shared) { return shared.counters; });
}
EnttecProIdentity EnttecProSink::identity() const {
  return device_->with_shared([](const auto& shared) { return shared.identity; });
}
EnttecProStats EnttecProSink::stats() const {
  return device_->with_shared([](const auto& shared) { return shared.stats; });
}
std::span<const Universe> EnttecProSink::universes() const { return {&device_->config().universe, 1}; }

double EnttecProSink::rate_hz_max() const {
  const std::uint8_t rate_hz = identity().params.rate_hz;
  return rate_hz == 0 ? kLineRateHzMax : rate_hz;
}

Status EnttecProSink::send(TimeNs, std::span<const FrameView> frames) {
  for (const FrameView& frame : frames) {
    if (frame.universe != device_->config().universe || frame.terminated) continue;
    FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
    const bool open = device_->with_shared([&](auto& shared) {
      if (shared.fresh) ++shared.counters.dropped;
      std::copy(frame.slots.begin(), frame.slots.end(), shared.frame.begin() + 1);
      shared.frame_size = shared.frame.size();
      shared.fresh = true;
      return shared.state == PortState::kWorking;
    });
    // A gone device is looked for at its own pace, not at that of the frames.
    if (open) device_->connector().wake();
  }
  return {};
}

Status EnttecProSink::poll(TimeNs) {
  device_->event().clear();
  return {};
}

void EnttecProSink::close(TimeNs) { device_->stop(); }

// --- Source

EnttecProSource::EnttecProSource(std::unique_ptr<EnttecPro> device) : device_(std::move(device)) {}
EnttecProSource::~EnttecProSource() { device_->stop(); }

Result<std::unique_ptr<EnttecProSource>> EnttecProSource::open(EnttecProConfig config,
                                                               std::unique_ptr<Connector> connector, Clock& clock) {
  auto device =
      std::make_unique<EnttecPro>(std::move(config), EnttecPro::Direction::kInput, std::move(connector), clock);
  FL_TRY(device->start());
  return std::unique_ptr<EnttecProSource>(new EnttecProSource(std::move(device)));
}

std::string EnttecProSource::name() const { return device_->config().name; }
int EnttecProSource::poll_fd() const { return device_->event().fd(); }
TimeNs EnttecProSource::next_deadline_ns() const { return line_is_quiet_ ? kTimeNever : heard_ns_ + kLineLost_ns; }
PortState EnttecProSource::state() const {
  const PortState state = device_->with_shared([](const auto& shared) { return shared.state; });
  return state == PortState::kWorking && line_is_quiet_ ? PortState::kWaiting : state;
}
std::string EnttecProSource::trouble() const {
  return device_->with_shared([](const auto& shared) { return shared.trouble; });
}
PortCounters EnttecProSource::counters() const {
  return device_->with_shared([](const auto& shared) { return shared.counters; });
}
EnttecProIdentity EnttecProSource::identity() const {
  return device_->with_shared([](const auto& shared) { return shared.identity; });
}
EnttecProStats EnttecProSource::stats() const {
  return device_->with_shared([](const auto& shared) { return shared.stats; });
}
std::span<const Universe> EnttecProSource::universes() const { return {&device_->config().universe, 1}; }

Status EnttecProSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  // Cleared first: a frame that comes after the copy below makes it readable again.
  device_->event().clear();
  std::size_t size = 0;
  std::uint64_t sequence = 0;
  device_->with_shared([&](auto& shared) {
    if (!shared.fresh) return;
    shared.fresh = false;
    frame_ = shared.frame;
    size = shared.frame_size;
    heard_ns_ = shared.stamp_ns;
    sequence = shared.counters.frames;
  });
  if (size > 0) {
    receiver.receive({.universe = device_->config().universe,
                      .stamp_ns = heard_ns_,
                      .sender = std::hash<std::string>{}(device_->config().name) | 1u,
                      .sequence = static_cast<std::uint32_t>(sequence),
                      .slots = std::span<const std::uint8_t>(frame_).subspan(1, size - 1)});
    line_is_quiet_ = false;
  }
  if (!line_is_quiet_ && now_ns >= heard_ns_ + kLineLost_ns) line_is_quiet_ = true;
  return {};
}

// --- The driver's row

namespace {

constexpr UsbModelId kModels[] = {
    {.vendor = 0x0403,
     .product = 0x6001,
     .manufacturer_text = "ENTTEC",
     .product_text = "DMX USB PRO Mk2",
     .model_name = "ENTTEC DMX USB Pro Mk2",
     .quirks = kQuirkGenericUsbIds | kQuirkFirstPortOnly},
    {.vendor = 0x0403,
     .product = 0x6001,
     .manufacturer_text = "ENTTEC",
     .product_text = "DMX USB PRO",
     .model_name = "ENTTEC DMX USB Pro",
     .quirks = kQuirkGenericUsbIds},
    {.vendor = 0x0403,
     .product = 0x6001,
     .manufacturer_text = "DMXking",
     .product_text = "",
     .model_name = "DMXking ultraDMX",
     .quirks = kQuirkGenericUsbIds | kQuirkFirstPortOnly},
};

Result<EnttecProConfig> config_of(const PortRequest& request) {
  if (request.universes.size() != 1)
    return fail(ErrorCode::kBadInput, "{}: carries one universe, {} were asked for", name_of(request),
                request.universes.size());
  return EnttecProConfig{.universe = request.universes[0],
                         .name = name_of(request),
                         .blackout_on_exit = request.blackout_on_exit,
                         .wait_for_device = request.wait_for_device};
}

Result<std::unique_ptr<Sink>> open_enttec_pro_sink(const PortRequest& request, Clock& clock) {
  FL_ASSIGN(EnttecProConfig config, config_of(request));
  FL_ASSIGN(auto connector, make_libusb_connector({.driver_id = "enttec-pro", .target = request.target}, clock));
  return EnttecProSink::open(std::move(config), std::move(connector), clock);
}

Result<std::unique_ptr<Source>> open_enttec_pro_source(const PortRequest& request, Clock& clock) {
  FL_ASSIGN(EnttecProConfig config, config_of(request));
  // A short latency timer: the end of a frame waits for it inside the chip.
  FL_ASSIGN(auto connector,
            make_libusb_connector({.driver_id = "enttec-pro", .target = request.target, .latency_ms = 2}, clock));
  return EnttecProSource::open(std::move(config), std::move(connector), clock);
}

}  // namespace

extern constinit const DriverInfo enttec_pro_driver{
    .id = "enttec-pro",
    .full_name = "ENTTEC DMX USB Pro and compatible",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kCanInput | kKeepsLookAlive,
    .notes = "One universe, in or out. The widget times the line itself. Two-port models: the first port.",
    .open_sink = open_enttec_pro_sink,
    .open_source = open_enttec_pro_source,
};

}  // namespace footlight::drivers

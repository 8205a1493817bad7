#include "drivers/mock/mock_usb.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "drivers/transport/ftdi.h"
#include "drivers/usb_match.h"

namespace footlight::drivers::mock {

MockUsb::MockUsb(std::unique_ptr<UsbModel> model, std::string where, Script script)
    : where_(std::move(where)), script_(std::move(script)), model_(std::move(model)) {
  model_->power_on();
}

void MockUsb::unplug() {
  const Notifier notifier{*this};
  const std::lock_guard lock(mutex_);
  plugged_ = false;
}

void MockUsb::plug() {
  const Notifier notifier{*this};
  const std::lock_guard lock(mutex_);
  if (plugged_) return;
  plugged_ = true;
  ++plug_count_;
  data_since_ns_ = kTimeNever;
  model_->power_on();
}

void MockUsb::unplug_after(std::size_t byte_count) {
  const std::lock_guard lock(mutex_);
  unplug_after_ = byte_count;
}

void MockUsb::stall(bool stalled) {
  const Notifier notifier{*this};
  const std::lock_guard lock(mutex_);
  stalled_ = stalled;
}

void MockUsb::cut_next_write(std::size_t byte_count) {
  const std::lock_guard lock(mutex_);
  cut_next_write_ = byte_count;
}

void MockUsb::limit_reads(std::size_t byte_count) {
  const std::lock_guard lock(mutex_);
  read_size_max_ = byte_count;
}

void MockUsb::slow_down(DurationNs by_ns) {
  const Notifier notifier{*this};
  const std::lock_guard lock(mutex_);
  slow_ns_ = by_ns;
}

void MockUsb::move_clock(BusTime time) {
  const std::lock_guard lock(mutex_);
  moves_clock_ = true;
  bus_time_ = time;
}

bool MockUsb::claimed() {
  const std::lock_guard lock(mutex_);
  return claimed_;
}

bool MockUsb::wait_for_claim(bool claimed, std::chrono::milliseconds patience) {
  return wait_for([&](const UsbModel&) { return claimed_ == claimed; }, patience);
}

namespace {

std::optional<std::size_t> number_of(std::string_view text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<Bytes> bytes_of_hex(std::string_view text) {
  if (text.empty() || text.size() % 2 != 0) return std::nullopt;
  Bytes bytes;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    std::uint8_t byte = 0;
    const auto [end, error] = std::from_chars(text.data() + i, text.data() + i + 2, byte, 16);
    if (error != std::errc{} || end != text.data() + i + 2) return std::nullopt;
    bytes.push_back(byte);
  }
  return bytes;
}

}  // namespace

Status MockUsb::obey(std::string_view command) {
  const std::size_t space = command.find(' ');
  const std::string_view verb = command.substr(0, space);
  const std::string_view object = space == std::string_view::npos ? std::string_view{} : command.substr(space + 1);
  const auto number = number_of(object);
  if (verb == "unplug" && object.empty())
    unplug();
  else if (verb == "plug" && object.empty())
    plug();
  else if (verb == "unplug-after" && number)
    unplug_after(*number);
  else if (verb == "stall" && (object == "on" || object == "off"))
    stall(object == "on");
  else if (verb == "cut-write" && number)
    cut_next_write(*number);
  else if (verb == "limit-reads" && number)
    limit_reads(*number);
  else if (verb == "slow" && number)
    slow_down(static_cast<DurationNs>(*number) * kNsPerMs);
  else if (verb == "serial" && !object.empty())
    with_model([&](UsbModel& model) { model.serial = object; });
  else if (const auto bytes = bytes_of_hex(object); verb == "garbage" && bytes)
    with_model([&](UsbModel& model) { model.send_to_host(*bytes); });
  else
    return fail(ErrorCode::kBadInput,
                "mock command '{}': expected unplug, plug, unplug-after N, stall on|off, cut-write N, limit-reads N, "
                "slow MS, garbage HEX or serial TEXT",
                command);
  return {};
}

namespace {

std::uint16_t word_of(const Bytes& bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
}
UsbMatch match_of(const UsbModel& model) {
  const Bytes device = model.device_descriptor();
  return match_usb_device(word_of(device, 8), word_of(device, 10), model.manufacturer, model.product);
}

}  // namespace

// Shared by an opener and its transport; guarded by the mutex of the MockUsb.
struct Wakeups {
  bool woken = false;
  bool aborted = false;
};

class MockTransport final : public Transport {
 public:
  // Call with the lock of the MockUsb held.
  MockTransport(std::shared_ptr<MockUsb> usb, Clock& clock, std::shared_ptr<Wakeups> wakeups)
      : usb_(std::move(usb)),
        clock_(clock),
        wakeups_(std::move(wakeups)),
        plug_count_(usb_->plug_count_),
        serial_(usb_->model_->serial) {
    usb_->claimed_ = true;
  }
  ~MockTransport() override {
    const MockUsb::Notifier notifier{*usb_};
    const std::lock_guard lock(usb_->mutex_);
    usb_->claimed_ = false;
  }

  std::string where() const override { return usb_->where_; }
  std::string serial() const override { return serial_; }

  Status wait(TimeNs deadline_ns) override {
    std::unique_lock lock(usb_->mutex_);
    while (true) {
      FL_TRY(still_there());
      const TimeNs next_ns = play();
      if (std::exchange(wakeups_->woken, false) || clock_.now_ns() >= deadline_ns) return {};
      sleep_until_changed(*usb_, lock, clock_, std::min(deadline_ns, next_ns));
    }
  }

  Status write(std::span<const std::uint8_t>, TimeNs) override {
    return fail(ErrorCode::kUnsupported, "{}: is not a serial line", usb_->where_);
  }
  Result<std::size_t> read(std::span<std::uint8_t>, TimeNs) override {
    return fail(ErrorCode::kUnsupported, "{}: is not a serial line", usb_->where_);
  }

  Status control_out(const ControlRequest& request, std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    FL_TRY(control(request, bytes, static_cast<std::uint16_t>(bytes.size()), deadline_ns));
    return {};
  }
  Result<std::size_t> control_in(const ControlRequest& request, std::span<std::uint8_t> into,
                                 TimeNs deadline_ns) override {
    FL_ASSIGN(const Bytes answer, control(request, {}, static_cast<std::uint16_t>(into.size()), deadline_ns));
    const std::size_t count = std::min(answer.size(), into.size());
    std::copy_n(answer.begin(), count, into.begin());
    return count;
  }

  Status write_endpoint(std::uint8_t endpoint, std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    const MockUsb::Notifier notifier{*usb_};
    std::unique_lock lock(usb_->mutex_);
    FL_TRY(wait_until_taken(lock, deadline_ns));
    take_time(lock, usb_->bus_time_.bulk_ns);
    std::size_t taken = 0;
    const std::size_t unplug_at =
        std::exchange(usb_->unplug_after_, usb_->unplug_after_ < bytes.size() ? SIZE_MAX : usb_->unplug_after_);
    const std::size_t cut_at =
        std::exchange(usb_->cut_next_write_, usb_->cut_next_write_ < bytes.size() ? SIZE_MAX : usb_->cut_next_write_);
    const std::size_t end = std::min({bytes.size(), unplug_at, cut_at});
    while (taken < end) {
      FL_TRY(still_there());
      const TimeNs next_ns = play();
      const std::size_t room = usb_->stalled_ ? 0 : std::min(usb_->model_->room(endpoint), end - taken);
      usb_->model_->data_out(endpoint, bytes.subspan(taken, room));
      taken += room;
      if (taken == end) break;
      if (clock_.now_ns() >= deadline_ns)
        return fail(ErrorCode::kTimeout, "{}: took {} of {} bytes", usb_->where_, taken, bytes.size());
      if (room == 0) sleep_until_changed(*usb_, lock, clock_, std::min(deadline_ns, next_ns));
    }
    if (unplug_at < bytes.size()) {
      usb_->plugged_ = false;
      return still_there();
    }
    if (cut_at < bytes.size())
      return fail(ErrorCode::kTimeout, "{}: took {} of {} bytes", usb_->where_, taken, bytes.size());
    if (bytes.empty()) usb_->model_->data_out(endpoint, bytes);
    return {};
  }

  Result<std::size_t> read_endpoint(std::uint8_t endpoint, std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    std::unique_lock lock(usb_->mutex_);
    while (true) {
      FL_TRY(still_there());
      if (std::exchange(wakeups_->woken, false)) return 0;
      TimeNs next_ns = play();
      const TimeNs now_ns = clock_.now_ns();
      if (waiting_.empty() && !usb_->stalled_ && usb_->model_->has_data(endpoint)) {
        if (usb_->data_since_ns_ == kTimeNever) usb_->data_since_ns_ = now_ns;
        if (now_ns >= usb_->data_since_ns_ + usb_->slow_ns_) {
          usb_->data_since_ns_ = kTimeNever;
          const std::size_t limit =
              usb_->read_size_max_ > 0 ? usb_->read_size_max_ + usb_->model_->in_overhead() : kUsbTransferSizeMax;
          waiting_ = usb_->model_->data_in(endpoint, std::min(limit, kUsbTransferSizeMax));
        } else {
          next_ns = std::min(next_ns, usb_->data_since_ns_ + usb_->slow_ns_);
        }
      }
      if (!waiting_.empty()) {
        const std::size_t count = std::min(into.size(), waiting_.size());
        std::copy_n(waiting_.begin(), count, into.begin());
        waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
        return count;
      }
      if (now_ns >= deadline_ns) return 0;
      sleep_until_changed(*usb_, lock, clock_, std::min(deadline_ns, next_ns));
    }
  }

  // May return early when anything happens, and at most one real second late: callers check in a loop. With a simulated
  // clock, clock_moved() makes them check.
  static void sleep_until_changed(MockUsb& usb, std::unique_lock<std::mutex>& lock, Clock& clock, TimeNs deadline_ns) {
    if (usb.moves_clock_) {
      FL_CHECK(deadline_ns != kTimeNever);  // it would wait for ever
      lock.unlock();
      clock.sleep_until_ns(deadline_ns);
      lock.lock();
      return;
    }
    const DurationNs left_ns = std::clamp<DurationNs>(deadline_ns - clock.now_ns(), 0, kNsPerS);
    usb.changed_.wait_until(lock, std::chrono::system_clock::now() + std::chrono::nanoseconds(left_ns));
  }

 private:
  Result<Bytes> control(const ControlRequest& request, std::span<const std::uint8_t> bytes, std::uint16_t size,
                        TimeNs deadline_ns) {
    const MockUsb::Notifier notifier{*usb_};
    std::unique_lock lock(usb_->mutex_);
    FL_TRY(wait_until_taken(lock, deadline_ns));
    take_time(lock, usb_->bus_time_.control_ns);
    (void)play();
    if (!bytes.empty() && usb_->unplug_after_ < bytes.size()) {
      usb_->unplug_after_ = SIZE_MAX;
      usb_->plugged_ = false;
      FL_TRY(still_there());
    }
    if (!bytes.empty() && usb_->cut_next_write_ < bytes.size()) {
      usb_->cut_next_write_ = SIZE_MAX;
      return fail(ErrorCode::kTimeout, "{}: no answer to control request {} in time", usb_->where_, request.request);
    }
    auto answer =
        usb_->model_->control({request.request_type, request.request, request.value, request.index, size}, bytes);
    if (!answer) return fail(ErrorCode::kIo, "{}: refused control request {}", usb_->where_, request.request);
    return std::move(*answer);
  }

  // Advances the model and its script; returns the time of the next event.
  TimeNs play() {
    const TimeNs now_ns = clock_.now_ns();
    const TimeNs model_ns = usb_->model_->pass_time(now_ns);
    if (!usb_->script_) return model_ns;
    if (now_ns >= usb_->script_due_ns_) usb_->script_due_ns_ = usb_->script_(*usb_->model_, now_ns);
    return std::min(model_ns, usb_->script_due_ns_);
  }
  void take_time(std::unique_lock<std::mutex>& lock, DurationNs duration_ns) {
    if (usb_->moves_clock_ && duration_ns > 0) sleep_until_changed(*usb_, lock, clock_, clock_.now_ns() + duration_ns);
  }
  Status wait_until_taken(std::unique_lock<std::mutex>& lock, TimeNs deadline_ns) {
    while (true) {
      FL_TRY(still_there());
      if (!usb_->stalled_) return {};
      if (clock_.now_ns() >= deadline_ns) return fail(ErrorCode::kTimeout, "{}: accepts no data", usb_->where_);
      sleep_until_changed(*usb_, lock, clock_, deadline_ns);
    }
  }
  Status still_there() const {
    if (wakeups_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", usb_->where_);
    if (!usb_->plugged_ || usb_->plug_count_ != plug_count_)
      return fail(ErrorCode::kDisconnected, "{}: unplugged", usb_->where_);
    return {};
  }

  std::shared_ptr<MockUsb> usb_;
  Clock& clock_;
  std::shared_ptr<Wakeups> wakeups_;
  const std::uint64_t plug_count_;
  const std::string serial_;
  Bytes waiting_;  // arrived and not read yet
};

// A pipe on one endpoint each way, as the kernel's drivers for serial devices and for HID provide it.
class PipeTransport final : public Transport {
 public:
  PipeTransport(std::unique_ptr<Transport> usb, const UsbModel& model, bool is_hid)
      : usb_(std::move(usb)), is_hid_(is_hid) {
    constexpr std::uint8_t kEndpointDescriptor = 5, kAttributesBulk = 2;
    const Bytes config = model.config_descriptor();
    for (std::size_t at = 0; at + 3 < config.size() && config[at] > 0; at += config[at]) {
      if (config[at + 1] != kEndpointDescriptor) continue;
      if (!is_hid_ && config[at + 3] != kAttributesBulk) continue;  // not the endpoint for notifications
      std::uint8_t& endpoint = (config[at + 2] & 0x80u) != 0 ? in_ : out_;
      if (endpoint == 0) endpoint = config[at + 2];
    }
  }
  std::string where() const override { return usb_->where(); }
  std::string serial() const override { return usb_->serial(); }
  Status wait(TimeNs deadline_ns) override { return usb_->wait(deadline_ns); }
  Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    if (is_hid_ && !bytes.empty() && bytes[0] == 0) bytes = bytes.subspan(1);  // reports without a number
    return usb_->write_endpoint(out_, bytes, deadline_ns);
  }
  Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    if (!is_hid_) return usb_->read_endpoint(in_, into, deadline_ns);
    FL_ASSIGN(const std::size_t size, usb_->read_endpoint(in_, into.subspan(1), deadline_ns));
    into[0] = 0;  // the report number comes first
    return size > 0 ? 1 + size : 0;
  }
  Result<std::size_t> control_in(const ControlRequest& request, std::span<std::uint8_t> into,
                                 TimeNs deadline_ns) override {
    return usb_->control_in(request, into, deadline_ns);
  }
  Status set_line(const LineSettings&, TimeNs deadline_ns) override {
    constexpr std::uint8_t kCoding[] = {0x90, 0xD0, 0x03, 0x00, 2, 0, 8};  // 250000 baud, 2 stop bits, no parity
    return usb_->control_out({0x21, 0x20, 0, 0}, kCoding, deadline_ns);
  }

 private:
  const std::unique_ptr<Transport> usb_;
  const bool is_hid_;
  std::uint8_t in_ = 0, out_ = 0;
};

class MockOpener final : public Opener {
 public:
  MockOpener(std::shared_ptr<MockUsb> usb, Clock& clock, std::string serial)
      : usb_(std::move(usb)), clock_(clock), serial_(std::move(serial)) {}

  Result<std::unique_ptr<Transport>> connect() override {
    std::unique_lock lock(usb_->mutex_);
    tried_plug_count_ = usb_->plugged_ ? usb_->plug_count_ : 0;
    const UsbModel& model = *usb_->model_;
    if (wakeups_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", usb_->where_);
    if (!usb_->plugged_) return fail(ErrorCode::kNotFound, "{}: not plugged in", usb_->where_);
    if (!serial_.empty() && model.serial != serial_)
      return fail(ErrorCode::kNotFound, "{}: not plugged in; there is another device, with the serial number {}",
                  serial_, model.serial);
    if (usb_->claimed_)
      return fail(ErrorCode::kPermission, "{}: in use by another port of this program; name a second one '{}/NAME'",
                  usb_->where_, usb_->where_);
    serial_ = model.serial;
    const UsbMatch match = match_of(model);
    const TransportKind kind = match.model != nullptr ? match.model->transport : TransportKind::kFtdi;
    std::unique_ptr<Transport> raw = std::make_unique<MockTransport>(usb_, clock_, wakeups_);
    lock.unlock();
    switch (kind) {
      case TransportKind::kUsb: return raw;
      case TransportKind::kFtdi: return open_ftdi(std::move(raw), word_of(model.device_descriptor(), 12), clock_);
      case TransportKind::kTty:
      case TransportKind::kHid: break;
    }
    return std::make_unique<PipeTransport>(std::move(raw), model, kind == TransportKind::kHid);
  }

  void wait(TimeNs deadline_ns) override {
    std::unique_lock lock(usb_->mutex_);
    while (!wakeups_->aborted && !std::exchange(wakeups_->woken, false) && clock_.now_ns() < deadline_ns) {
      if (usb_->plugged_ && usb_->plug_count_ != tried_plug_count_) return;
      MockTransport::sleep_until_changed(*usb_, lock, clock_, deadline_ns);
    }
  }

  void wake() override {
    const MockUsb::Notifier notifier{*usb_};
    const std::lock_guard lock(usb_->mutex_);
    wakeups_->woken = true;
  }

  void abort() override {
    const MockUsb::Notifier notifier{*usb_};
    const std::lock_guard lock(usb_->mutex_);
    wakeups_->aborted = true;
  }

  std::string identity() override { return fmt::format("mock {}", fmt::ptr(usb_.get())); }

 private:
  std::shared_ptr<MockUsb> usb_;
  Clock& clock_;
  std::string serial_;                  // used by the device thread only
  std::uint64_t tried_plug_count_ = 0;  // the plug cycle of the last connect(); 0: none
  std::shared_ptr<Wakeups> wakeups_ = std::make_shared<Wakeups>();
};

std::unique_ptr<Opener> make_mock_opener(std::shared_ptr<MockUsb> usb, Clock& clock, std::string serial) {
  return std::make_unique<MockOpener>(std::move(usb), clock, std::move(serial));
}

Result<MockTarget> mock_of_target(std::string_view target, bool for_output) {
  static std::mutex mutex;
  static std::map<std::string, std::shared_ptr<MockUsb>, std::less<>> devices;  // guarded by mutex
  const std::size_t slash = target.find('/');
  const std::string_view name = slash == std::string_view::npos ? std::string_view{} : target.substr(slash + 1);
  const DriverInfo* driver = find_driver(target.substr(0, slash));
  if (driver == nullptr || driver->make_model == nullptr || (slash != std::string_view::npos && name.empty())) {
    std::string known;
    for (const DriverInfo* one : drivers())
      if (one->make_model != nullptr) known += fmt::format("{}mock:{}", known.empty() ? "" : ", ", one->id);
    return fail(ErrorCode::kBadInput,
                "mock:{}: expected one of {}, followed by /NAME to use several; or an input that plays a pattern: "
                "mock:chase, mock:full, mock:sine",
                target, known);
  }
  const std::string key =
      fmt::format("{}/{}", driver->id, name.empty() ? (for_output ? ":output" : ":input") : std::string(name));
  const std::lock_guard lock(mutex);
  std::shared_ptr<MockUsb>& device = devices[key];
  if (!device) device = std::make_shared<MockUsb>(driver->make_model(), fmt::format("mock:{}", target), slow_sine());
  const UsbMatch match = device->with_model([](UsbModel& model) { return match_of(model); });
  return MockTarget{driver, match.model != nullptr ? *match.model : UsbModelId{}, device};
}

MockUsb::Script slow_sine() {
  return [](UsbModel& model, TimeNs now_ns) {
    constexpr DurationNs kFrameNs = 25 * kNsPerMs, kPeriodNs = 10 * kNsPerS;
    constexpr int kLineCountMax = 8;
    for (int line = 0; line < kLineCountMax; ++line) {
      if (!model.listens(line)) continue;
      std::array<std::uint8_t, 513> line_frame{};
      const double turns = static_cast<double>(now_ns % kPeriodNs) / static_cast<double>(kPeriodNs);
      for (std::size_t slot = 0; slot < 512; ++slot) {
        const double phase_rad = 2.0 * std::numbers::pi * (turns - static_cast<double>(slot) / 511.0);
        line_frame[1 + slot] = static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::sin(phase_rad)));
      }
      model.receive_line_frame(line, line_frame);
    }
    return now_ns + kFrameNs;
  };
}

}  // namespace footlight::drivers::mock

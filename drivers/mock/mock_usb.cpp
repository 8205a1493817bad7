#include "drivers/mock/mock_usb.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "drivers/usb/ftdi.h"

namespace footlight::drivers::mock {

MockUsb::MockUsb(std::string where, Script script) : where_(std::move(where)), script_(std::move(script)) {
  model_.power_on();
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
  model_.power_on();
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

bool MockUsb::claimed() {
  const std::lock_guard lock(mutex_);
  return claimed_;
}

bool MockUsb::wait_for_claim(bool claimed, std::chrono::milliseconds patience) {
  return wait_for([&](const EnttecProModel&) { return claimed_ == claimed; }, patience);
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
  else if (verb == "serial" && !object.empty())
    with_model([&](EnttecProModel& model) { model.serial = object; });
  else if (const auto bytes = bytes_of_hex(object); verb == "garbage" && bytes)
    with_model([&](EnttecProModel& model) { model.say(*bytes); });
  else
    return fail(ErrorCode::kBadInput,
                "mock command '{}': expected unplug, plug, unplug-after N, stall on|off, cut-write N, limit-reads N, "
                "garbage HEX or serial TEXT",
                command);
  return {};
}

// What a connector and its transport share; guarded by the mutex of the MockUsb.
struct Wakeups {
  bool woken = false;
  bool aborted = false;
};

class MockTransport final : public Transport {
 public:
  MockTransport(std::shared_ptr<MockUsb> usb, Clock& clock, std::shared_ptr<Wakeups> wakeups)
      : usb_(std::move(usb)),
        clock_(clock),
        wakeups_(std::move(wakeups)),
        plug_count_(usb_->plug_count_),
        serial_(usb_->model_.serial) {
    usb_->claimed_ = true;
    for (const ftdi::Request& request : ftdi::kOpening)
      usb_->model_.control({ftdi::kRequestTypeOut, request.request, request.value, request.index, 0}, {});
  }
  ~MockTransport() override {
    const MockUsb::Notifier notifier{*usb_};
    const std::lock_guard lock(usb_->mutex_);
    usb_->claimed_ = false;
  }

  Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    const MockUsb::Notifier notifier{*usb_};
    std::unique_lock lock(usb_->mutex_);
    while (true) {
      FL_TRY(still_there());
      if (!usb_->stalled_) break;
      if (clock_.now_ns() >= deadline_ns) return fail(ErrorCode::kTimeout, "{}: does not take data", usb_->where_);
      sleep(lock, deadline_ns);
    }
    if (usb_->unplug_after_ < bytes.size()) {
      usb_->model_.data_out(ftdi::kEndpointOut, bytes.first(usb_->unplug_after_));
      usb_->unplug_after_ = SIZE_MAX;
      usb_->plugged_ = false;
      return still_there();
    }
    if (usb_->cut_next_write_ < bytes.size()) {
      const std::size_t taken = usb_->cut_next_write_;
      usb_->model_.data_out(ftdi::kEndpointOut, bytes.first(taken));
      usb_->cut_next_write_ = SIZE_MAX;
      return fail(ErrorCode::kTimeout, "{}: took {} of {} bytes", usb_->where_, taken, bytes.size());
    }
    usb_->model_.data_out(ftdi::kEndpointOut, bytes);
    return {};
  }

  Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    std::unique_lock lock(usb_->mutex_);
    while (true) {
      FL_TRY(still_there());
      if (std::exchange(wakeups_->woken, false)) return 0;
      const TimeNs now_ns = clock_.now_ns();
      if (usb_->script_ && now_ns >= usb_->script_due_ns_) usb_->script_due_ns_ = usb_->script_(usb_->model_, now_ns);
      if (waiting_.empty() && !usb_->stalled_ && usb_->model_.has_data(ftdi::kEndpointIn)) {
        waiting_ = usb_->model_.data_in(ftdi::kEndpointIn, kTransferSize);
        waiting_.resize(ftdi::strip_status(waiting_, ftdi::kFullSpeedPacketSize));
      }
      if (!waiting_.empty()) {
        std::size_t count = std::min(into.size(), waiting_.size());
        if (usb_->read_size_max_ > 0) count = std::min(count, usb_->read_size_max_);
        std::copy_n(waiting_.begin(), count, into.begin());
        waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
        return count;
      }
      if (now_ns >= deadline_ns) return 0;
      sleep(lock, usb_->script_ ? std::min(deadline_ns, usb_->script_due_ns_) : deadline_ns);
    }
  }

  std::string where() const override { return usb_->where_; }
  std::string serial() const override { return serial_; }

 private:
  static constexpr std::size_t kTransferSize = 512;

  Status still_there() const {
    if (wakeups_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", usb_->where_);
    if (!usb_->plugged_ || usb_->plug_count_ != plug_count_)
      return fail(ErrorCode::kDisconnected, "{}: unplugged", usb_->where_);
    return {};
  }
  void sleep(std::unique_lock<std::mutex>& lock, TimeNs deadline_ns) {
    sleep_until_changed(*usb_, lock, clock_, deadline_ns);
  }

 public:
  // Returns early whenever anything happens, and late never by more than a real second: callers look again in a loop.
  // On a clock that is moved by hand, clock_moved() makes them look.
  static void sleep_until_changed(MockUsb& usb, std::unique_lock<std::mutex>& lock, Clock& clock, TimeNs deadline_ns) {
    const DurationNs left_ns = std::clamp<DurationNs>(deadline_ns - clock.now_ns(), 0, kNsPerS);
    usb.changed_.wait_until(lock, std::chrono::system_clock::now() + std::chrono::nanoseconds(left_ns));
  }

 private:
  std::shared_ptr<MockUsb> usb_;
  Clock& clock_;
  std::shared_ptr<Wakeups> wakeups_;
  const std::uint64_t plug_count_;
  const std::string serial_;
  Bytes waiting_;  // arrived and not yet read
};

class MockConnector final : public Connector {
 public:
  MockConnector(std::shared_ptr<MockUsb> usb, Clock& clock, std::string serial)
      : usb_(std::move(usb)), clock_(clock), serial_(std::move(serial)) {}

  Result<std::unique_ptr<Transport>> connect() override {
    const std::lock_guard lock(usb_->mutex_);
    tried_plug_count_ = usb_->plugged_ ? usb_->plug_count_ : 0;
    if (wakeups_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", usb_->where_);
    if (!usb_->plugged_) return fail(ErrorCode::kNotFound, "{}: not plugged in", usb_->where_);
    if (!serial_.empty() && usb_->model_.serial != serial_)
      return fail(ErrorCode::kNotFound, "{}: not plugged in; there is another device, with the serial number {}",
                  serial_, usb_->model_.serial);
    if (usb_->claimed_)
      return fail(ErrorCode::kPermission,
                  "{}: in use by another port of this program; name a second one 'mock:enttec-pro/NAME'", usb_->where_);
    serial_ = usb_->model_.serial;
    return std::make_unique<MockTransport>(usb_, clock_, wakeups_);
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

 private:
  std::shared_ptr<MockUsb> usb_;
  Clock& clock_;
  std::string serial_;                  // the device thread's alone
  std::uint64_t tried_plug_count_ = 0;  // the plugging in that connect() saw last; 0: none
  std::shared_ptr<Wakeups> wakeups_ = std::make_shared<Wakeups>();
};

std::unique_ptr<Connector> make_mock_connector(std::shared_ptr<MockUsb> usb, Clock& clock, std::string serial) {
  return std::make_unique<MockConnector>(std::move(usb), clock, std::move(serial));
}

Result<std::shared_ptr<MockUsb>> mock_of_target(std::string_view target, bool for_output) {
  static std::mutex mutex;
  static std::map<std::string, std::shared_ptr<MockUsb>, std::less<>> widgets;  // guarded by mutex
  constexpr std::string_view kModel = "enttec-pro";
  std::string_view name = target.substr(0, kModel.size()) == kModel ? target.substr(kModel.size()) : target;
  if (!target.starts_with(kModel) || (!name.empty() && (name[0] != '/' || name.size() == 1)))
    return fail(ErrorCode::kBadInput, "mock:{}: expected mock:enttec-pro or mock:enttec-pro/NAME", target);
  const std::string key = name.empty() ? (for_output ? "output" : "input") : std::string(name);
  const std::lock_guard lock(mutex);
  std::shared_ptr<MockUsb>& widget = widgets[key];
  if (!widget) widget = std::make_shared<MockUsb>(fmt::format("mock:{}", target), slow_sine());
  return widget;
}

MockUsb::Script slow_sine() {
  return [](EnttecProModel& model, TimeNs now_ns) {
    constexpr DurationNs kFrame_ns = 25 * kNsPerMs, kPeriod_ns = 10 * kNsPerS;
    if (model.receive_mode >= 0) {
      std::array<std::uint8_t, 513> line_frame{};
      const double turns = static_cast<double>(now_ns % kPeriod_ns) / static_cast<double>(kPeriod_ns);
      for (std::size_t slot = 0; slot < 512; ++slot) {
        const double phase_rad = 2.0 * std::numbers::pi * (turns - static_cast<double>(slot) / 511.0);
        line_frame[1 + slot] = static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::sin(phase_rad)));
      }
      model.receive_line_frame(line_frame);
    }
    return now_ns + kFrame_ns;
  };
}

}  // namespace footlight::drivers::mock

#include "drivers/usb/libusb_connector.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <optional>
#include <vector>

#include <libusb.h>

#include "drivers/usb/ftdi.h"

namespace footlight::drivers {

bool built_with_usb() { return true; }

namespace {

constexpr int kInterface = 0;
constexpr unsigned kControlTimeoutMs = 500;
constexpr std::size_t kInTransferCount = 4;         // enough that the chip never waits for a buffer while we copy
constexpr std::size_t kInTransferSize = 512;        // whole packets at full and at high speed
constexpr std::size_t kWaitingSizeMax = 16 * 1024;  // 30 frames; beyond it the chip is left to hold its data
constexpr DurationNs kEventSliceMax_ns = 60 * kNsPerS;
constexpr DurationNs kCancelPatience_ns = 5 * kNsPerS;

template <auto close>
struct Closes {
  template <class T>
  void operator()(T* handle) const {
    close(handle);
  }
};
using OwnedContext = std::unique_ptr<libusb_context, Closes<libusb_exit>>;
using OwnedHandle = std::unique_ptr<libusb_device_handle, Closes<libusb_close>>;
using OwnedTransfer = std::unique_ptr<libusb_transfer, Closes<libusb_free_transfer>>;
using OwnedDevice = std::unique_ptr<libusb_device, Closes<libusb_unref_device>>;

// The one place where libusb's codes become ours. code: LIBUSB_ERROR_*.
tl::unexpected<Error> usb_error(int code, std::string_view where, std::string_view action) {
  switch (code) {
    case LIBUSB_ERROR_NO_DEVICE: return fail(ErrorCode::kDisconnected, "{}: unplugged", where);
    case LIBUSB_ERROR_NOT_FOUND: return fail(ErrorCode::kNotFound, "{}: {}: not found", where, action);
    case LIBUSB_ERROR_ACCESS:
      return fail(ErrorCode::kPermission, "{}: permission denied; run: {}", where, udev_install_command());
    case LIBUSB_ERROR_BUSY:
      return fail(ErrorCode::kPermission, "{}: in use by another program; see: sudo fuser -v {}", where, where);
    case LIBUSB_ERROR_TIMEOUT: return fail(ErrorCode::kTimeout, "{}: {}: no answer in time", where, action);
    case LIBUSB_ERROR_OVERFLOW:
      return fail(ErrorCode::kProtocol, "{}: {}: more data than its packets may carry", where, action);
    case LIBUSB_ERROR_NOT_SUPPORTED:
      return fail(ErrorCode::kUnsupported, "{}: {}: not supported on this system", where, action);
    default: return fail(ErrorCode::kIo, "{}: {}: {}; try another cable or port", where, action, libusb_strerror(code));
  }
}

// What a finished transfer reports, as the code that a call would have returned.
int code_of(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED: return LIBUSB_SUCCESS;
    case LIBUSB_TRANSFER_TIMED_OUT: return LIBUSB_ERROR_TIMEOUT;
    case LIBUSB_TRANSFER_CANCELLED: return LIBUSB_ERROR_INTERRUPTED;
    case LIBUSB_TRANSFER_STALL: return LIBUSB_ERROR_PIPE;
    case LIBUSB_TRANSFER_NO_DEVICE: return LIBUSB_ERROR_NO_DEVICE;
    case LIBUSB_TRANSFER_OVERFLOW: return LIBUSB_ERROR_OVERFLOW;
    case LIBUSB_TRANSFER_ERROR: return LIBUSB_ERROR_IO;
  }
  return LIBUSB_ERROR_OTHER;
}

// One libusb context for one device, so that the events of one never wait for another's thread.
struct Bus {
  OwnedContext context;
  Clock& clock;
  std::atomic<bool> woken{false};
  std::atomic<bool> aborted{false};
  bool arrived = false;  // a device was plugged in; the device thread's

  explicit Bus(libusb_context* opened, Clock& used_clock) : context(opened), clock(used_clock) {}

  void interrupt() { libusb_interrupt_event_handler(context.get()); }
  // Runs the callbacks that are due; waits for one until the deadline at most, less where wake() or abort() is called.
  void handle_events(TimeNs deadline_ns) {
    const DurationNs left_ns = std::clamp<DurationNs>(deadline_ns - clock.now_ns(), 0, kEventSliceMax_ns);
    timeval left{.tv_sec = static_cast<time_t>(left_ns / kNsPerS),
                 .tv_usec = static_cast<suseconds_t>(left_ns % kNsPerS / kNsPerUs)};
    libusb_handle_events_timeout_completed(context.get(), &left, nullptr);
  }
};

class LibusbTransport final : public Transport {
 public:
  LibusbTransport(std::shared_ptr<Bus> bus, OwnedHandle handle, std::string where, std::string serial,
                  std::size_t packet_size)
      : bus_(std::move(bus)),
        handle_(std::move(handle)),
        where_(std::move(where)),
        serial_(std::move(serial)),
        packet_size_(packet_size) {}

  ~LibusbTransport() override {
    closing_ = true;  // one that ends with data now must not be submitted again
    for (InTransfer& in : in_)
      if (in.in_flight) libusb_cancel_transfer(in.transfer.get());
    const TimeNs patience_ns = bus_->clock.now_ns() + kCancelPatience_ns;
    while (in_flight_count() > 0 && bus_->clock.now_ns() < patience_ns) bus_->handle_events(patience_ns);
    if (in_flight_count() > 0) {
      // The kernel still owns the buffers: what it may write to is left to the end of the process.
      for (InTransfer& in : in_) (void)in.transfer.release();
      (void)new decltype(in_)(std::move(in_));
      (void)handle_.release();
      return;
    }
    libusb_release_interface(handle_.get(), kInterface);  // binds the kernel driver again
  }

  // After the interface was claimed.
  Status start(int latency_ms) {
    const ftdi::Request latency{ftdi::kLatencyTimer, static_cast<std::uint16_t>(latency_ms), 0};
    for (const ftdi::Request& request : ftdi::kOpening) FL_TRY(control(request));
    FL_TRY(control(latency));
    in_.resize(kInTransferCount);
    waiting_.reserve(kWaitingSizeMax + kInTransferCount * kInTransferSize);
    for (InTransfer& in : in_) {
      in.owner = this;
      in.buffer = std::make_unique<std::array<std::uint8_t, kInTransferSize>>();
      in.transfer.reset(libusb_alloc_transfer(0));
      libusb_fill_bulk_transfer(in.transfer.get(), handle_.get(), ftdi::kEndpointIn, in.buffer->data(), kInTransferSize,
                                &LibusbTransport::on_in, &in, 0);
      submit(in);
    }
    return failure_ == LIBUSB_SUCCESS ? Status{} : usb_error(failure_, where_, "read");
  }

  Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    Out out{.buffer = std::vector<std::uint8_t>(bytes.begin(), bytes.end())};
    const OwnedTransfer transfer(libusb_alloc_transfer(0));
    std::size_t written = 0;
    while (written < bytes.size()) {
      if (bus_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
      out.done = false;
      libusb_fill_bulk_transfer(transfer.get(), handle_.get(), ftdi::kEndpointOut, out.buffer.data() + written,
                                static_cast<int>(bytes.size() - written), &LibusbTransport::on_out, &out, 0);
      if (const int code = libusb_submit_transfer(transfer.get()); code != LIBUSB_SUCCESS)
        return usb_error(code, where_, "write");
      bool cancelled = false;
      while (!out.done) {
        const bool late = bus_->clock.now_ns() >= deadline_ns;
        if ((late || bus_->aborted) && !cancelled) {
          libusb_cancel_transfer(transfer.get());
          cancelled = true;
        }
        bus_->handle_events(cancelled ? kTimeNever : deadline_ns);
      }
      written += static_cast<std::size_t>(transfer->actual_length);
      if (transfer->status == LIBUSB_TRANSFER_CANCELLED && bus_->aborted)
        return fail(ErrorCode::kDisconnected, "{}: closed", where_);
      if (transfer->status == LIBUSB_TRANSFER_CANCELLED)
        return fail(ErrorCode::kTimeout, "{}: took {} of {} bytes in time", where_, written, bytes.size());
      if (transfer->status != LIBUSB_TRANSFER_COMPLETED) return usb_error(code_of(transfer->status), where_, "write");
      if (transfer->actual_length == 0 && bus_->clock.now_ns() >= deadline_ns)
        return fail(ErrorCode::kTimeout, "{}: took {} of {} bytes in time", where_, written, bytes.size());
    }
    return {};
  }

  Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    while (true) {
      if (bus_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
      if (bus_->woken.exchange(false)) return 0;
      if (!waiting_.empty()) {
        const std::size_t count = std::min(into.size(), waiting_.size());
        std::copy_n(waiting_.begin(), count, into.begin());
        waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
        for (InTransfer& in : in_)
          if (!in.in_flight && failure_ == LIBUSB_SUCCESS && waiting_.size() < kWaitingSizeMax) submit(in);
        return count;
      }
      if (failure_ != LIBUSB_SUCCESS) return usb_error(failure_, where_, "read");
      if (bus_->clock.now_ns() >= deadline_ns) return 0;
      bus_->handle_events(deadline_ns);
    }
  }

  std::string where() const override { return where_; }
  std::string serial() const override { return serial_; }

 private:
  struct InTransfer {
    LibusbTransport* owner = nullptr;
    std::unique_ptr<std::array<std::uint8_t, kInTransferSize>> buffer;
    OwnedTransfer transfer;
    bool in_flight = false;
  };
  struct Out {
    std::vector<std::uint8_t> buffer;
    bool done = false;
  };

  std::size_t in_flight_count() const {
    return static_cast<std::size_t>(
        std::count_if(in_.begin(), in_.end(), [](const InTransfer& in) { return in.in_flight; }));
  }

  Status control(const ftdi::Request& request) {
    const int code = libusb_control_transfer(handle_.get(), ftdi::kRequestTypeOut, request.request, request.value,
                                             request.index, nullptr, 0, kControlTimeoutMs);
    return code >= 0 ? Status{} : usb_error(code, where_, "set up the FTDI chip");
  }

  void submit(InTransfer& in) {
    const int code = libusb_submit_transfer(in.transfer.get());
    in.in_flight = code == LIBUSB_SUCCESS;
    if (!in.in_flight) failure_ = code;
  }

  // Both run inside handle_events(), so on the device thread.
  static void LIBUSB_CALL on_in(libusb_transfer* transfer) {
    auto& in = *static_cast<InTransfer*>(transfer->user_data);
    LibusbTransport& self = *in.owner;
    in.in_flight = false;
    if (transfer->status != LIBUSB_TRANSFER_COMPLETED) {
      if (self.failure_ == LIBUSB_SUCCESS) self.failure_ = code_of(transfer->status);
      return;
    }
    const auto bytes = std::span(*in.buffer).first(static_cast<std::size_t>(transfer->actual_length));
    const std::size_t count = ftdi::strip_status(bytes, self.packet_size_);
    self.waiting_.insert(self.waiting_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
    if (self.waiting_.size() < kWaitingSizeMax && !self.closing_) self.submit(in);
  }
  static void LIBUSB_CALL on_out(libusb_transfer* transfer) { static_cast<Out*>(transfer->user_data)->done = true; }

  std::shared_ptr<Bus> bus_;
  OwnedHandle handle_;
  const std::string where_;
  const std::string serial_;
  const std::size_t packet_size_;
  std::vector<InTransfer> in_;         // never resized while one is in flight: callbacks point into it
  std::vector<std::uint8_t> waiting_;  // stripped bytes that nobody has read yet
  bool closing_ = false;
  int failure_ = LIBUSB_SUCCESS;  // of the first IN transfer that ended badly
};

class LibusbConnector final : public Connector {
 public:
  LibusbConnector(LibusbConfig config, std::shared_ptr<Bus> bus) : config_(std::move(config)), bus_(std::move(bus)) {
    // Without hotplug support wait() simply lasts until its deadline.
    (void)libusb_hotplug_register_callback(bus_->context.get(), LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED, 0,
                                           LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY,
                                           &LibusbConnector::on_arrival, bus_.get(), nullptr);
  }

  Result<std::unique_ptr<Transport>> connect() override {
    if (bus_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", config_.driver_id);
    FL_ASSIGN(const FoundDevice found, choose(find_devices(config_.find)));
    switch (found.readiness) {
      case Readiness::kReady:
      case Readiness::kNotDmx: break;  // named by the user; whether it answers will show
      case Readiness::kUnsupported: return fail(ErrorCode::kUnsupported, "{}", found.reason);
      case Readiness::kNoNode: return fail(ErrorCode::kNotFound, "{}", found.reason);
      case Readiness::kNoPermission:
      case Readiness::kBusy:
        return fail(ErrorCode::kPermission, "{}: {}; run: {}", found.node, found.reason, found.remedy);
    }
    FL_ASSIGN(const OwnedDevice device, device_at(found.node));

    libusb_device_handle* opened = nullptr;
    if (const int code = libusb_open(device.get(), &opened); code != LIBUSB_SUCCESS)
      return usb_error(code, found.node, "open");
    OwnedHandle handle(opened);
    libusb_set_auto_detach_kernel_driver(handle.get(), 1);
    if (const int code = libusb_claim_interface(handle.get(), kInterface); code != LIBUSB_SUCCESS)
      return usb_error(code, found.node, "claim");
    const int packet_size = libusb_get_max_packet_size(device.get(), ftdi::kEndpointIn);
    auto transport = std::make_unique<LibusbTransport>(bus_, std::move(handle), found.node, found.serial,
                                                       packet_size > static_cast<int>(ftdi::kStatusSize)
                                                           ? static_cast<std::size_t>(packet_size)
                                                           : ftdi::kFullSpeedPacketSize);
    FL_TRY(transport->start(config_.latency_ms));
    if (!pinned_)
      pinned_ = found.serial.empty() ? Pin{.serial = {}, .port_path = found.port_path}
                                     : Pin{.serial = found.serial, .port_path = {}};
    return transport;
  }

  void wait(TimeNs deadline_ns) override {
    while (!bus_->aborted && !bus_->woken.exchange(false) && !std::exchange(bus_->arrived, false) &&
           bus_->clock.now_ns() < deadline_ns)
      bus_->handle_events(deadline_ns);
  }
  void wake() override {
    bus_->woken = true;
    bus_->interrupt();
  }
  void abort() override {
    bus_->aborted = true;
    bus_->interrupt();
  }

 private:
  struct Pin {
    std::string serial;
    std::string port_path;
  };

  static int LIBUSB_CALL on_arrival(libusb_context*, libusb_device*, libusb_hotplug_event, void* bus) {
    static_cast<Bus*>(bus)->arrived = true;
    return 0;
  }

  Result<FoundDevice> choose(const DeviceList& list) const {
    constexpr std::string_view kPort = "port-";
    const std::string& target = config_.target;
    const bool by_port = target.starts_with(kPort);
    std::vector<const FoundDevice*> fitting;
    std::string others;
    for (const FoundDevice& device : list.devices) {
      const bool ours = device.driver_id == config_.driver_id;
      bool fits = ours && target.empty();
      if (pinned_)
        fits = pinned_->serial.empty() ? device.port_path == pinned_->port_path : device.serial == pinned_->serial;
      else if (by_port)
        fits = device.port_path == target.substr(kPort.size());
      else if (!target.empty())
        fits = device.serial == target;
      if (fits)
        fitting.push_back(&device);
      else if (ours)
        others += fmt::format("{}{}", others.empty() ? "" : ", ", device.endpoint);
    }
    if (fitting.size() == 1) return *fitting[0];
    const std::string named =
        pinned_ ? fmt::format("{}:{}", config_.driver_id,
                              pinned_->serial.empty() ? "port-" + pinned_->port_path : pinned_->serial)
                : fmt::format("{}{}{}", config_.driver_id, target.empty() ? "" : ":", target);
    if (fitting.empty())
      return fail(ErrorCode::kNotFound, "{}: not plugged in{}{}", named, others.empty() ? "" : "; there is ", others);
    std::string ports;
    for (const FoundDevice* device : fitting)
      ports += fmt::format("{}{}:port-{}", ports.empty() ? "" : ", ", config_.driver_id, device->port_path);
    return fail(ErrorCode::kBadInput, "{}: {} devices fit; name one of {}", named, fitting.size(), ports);
  }

  // node: "/dev/bus/usb/001/004", whose last two parts are libusb's bus number and device address.
  Result<OwnedDevice> device_at(const std::string& node) const {
    libusb_device** all = nullptr;
    const ssize_t count = libusb_get_device_list(bus_->context.get(), &all);
    if (count < 0) return usb_error(static_cast<int>(count), node, "list devices");
    OwnedDevice found;
    for (ssize_t i = 0; i < count && !found; ++i) {
      const std::string tail =
          fmt::format("/{:03}/{:03}", libusb_get_bus_number(all[i]), libusb_get_device_address(all[i]));
      if (node.ends_with(tail)) found.reset(libusb_ref_device(all[i]));
    }
    libusb_free_device_list(all, 1);
    if (!found) return fail(ErrorCode::kNotFound, "{}: unplugged", node);
    return found;
  }

  const LibusbConfig config_;
  const std::shared_ptr<Bus> bus_;  // outlives the transport, which holds it too
  std::optional<Pin> pinned_;
};

}  // namespace

Result<std::unique_ptr<Connector>> make_libusb_connector(LibusbConfig config, Clock& clock) {
  libusb_context* context = nullptr;
  if (const int code = libusb_init(&context); code != LIBUSB_SUCCESS) return usb_error(code, "libusb", "start");
  return std::make_unique<LibusbConnector>(std::move(config), std::make_shared<Bus>(context, clock));
}

}  // namespace footlight::drivers

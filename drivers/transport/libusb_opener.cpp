#include "drivers/transport/libusb_opener.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <vector>

#include <libusb.h>

#include "drivers/permission.h"
#include "drivers/transport/ftdi.h"

namespace footlight::drivers {

bool built_with_usb() { return true; }

namespace {

constexpr int kInterface = 0;
constexpr std::size_t kInTransferCount = 4;         // so that the device never waits for a buffer during a copy
constexpr std::size_t kWaitingSizeMax = 16u << 10;  // 30 frames; above it no transfer is submitted
constexpr int kInTransferSize = kUsbTransferSizeMax;
constexpr DurationNs kEventSliceMaxNs = 60 * kNsPerS;
constexpr DurationNs kCancelPatienceNs = 5 * kNsPerS;

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

// Translates libusb's error codes. code: LIBUSB_ERROR_*.
tl::unexpected<Error> usb_error(int code, std::string_view where, std::string_view action) {
  switch (code) {
    case LIBUSB_ERROR_NO_DEVICE: return fail(ErrorCode::kDisconnected, "{}: unplugged", where);
    case LIBUSB_ERROR_NOT_FOUND: return fail(ErrorCode::kNotFound, "{}: {}: not found", where, action);
    case LIBUSB_ERROR_ACCESS:
      return fail(ErrorCode::kPermission, "{}: permission denied; see: footlight devices", where);
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

// The status of a finished transfer as an error code, as a synchronous call would have returned it.
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

// Each device has its own libusb context, so that its events never wait for the thread of another device.
struct Bus {
  OwnedContext context;
  Clock& clock;
  std::atomic<bool> woken{false};
  std::atomic<bool> aborted{false};
  // Used by the device thread only; written inside handle_events().
  bool arrived = false;           // a device was plugged in
  libusb_device* open = nullptr;  // the device in use; only compared, never dereferenced
  bool open_has_left = false;

  explicit Bus(libusb_context* opened, Clock& used_clock) : context(opened), clock(used_clock) {}

  void interrupt() { libusb_interrupt_event_handler(context.get()); }
  // Runs the callbacks that are due. Waits for one until the deadline, wake() or abort().
  void handle_events(TimeNs deadline_ns) {
    const DurationNs left_ns = std::clamp<DurationNs>(deadline_ns - clock.now_ns(), 0, kEventSliceMaxNs);
    timeval left{.tv_sec = static_cast<time_t>(left_ns / kNsPerS),
                 .tv_usec = static_cast<suseconds_t>(left_ns % kNsPerS / kNsPerUs)};
    libusb_handle_events_timeout_completed(context.get(), &left, nullptr);
  }
};

// An IN endpoint: its transfers in flight, and the bytes that have arrived.
struct InStream {
  struct InTransfer {
    InStream* stream = nullptr;
    std::array<std::uint8_t, kUsbTransferSizeMax> buffer{};
    OwnedTransfer transfer;
    bool in_flight = false;
  };
  std::uint8_t endpoint = 0;
  // On the heap, since libusb keeps pointers to them.
  std::array<std::unique_ptr<InTransfer>, kInTransferCount> transfers;
  std::vector<std::uint8_t> waiting;  // per transfer its size (2 bytes), then its bytes; unread from waiting_begin on
  std::size_t waiting_begin = 0;
  bool closing = false;
  int failure = LIBUSB_SUCCESS;  // of the first transfer that failed

  void submit(InTransfer& in) {
    const int code = libusb_submit_transfer(in.transfer.get());
    in.in_flight = code == LIBUSB_SUCCESS;
    if (!in.in_flight) failure = code;
  }
  void submit_idle() {
    for (const auto& in : transfers)
      if (!in->in_flight && failure == LIBUSB_SUCCESS && waiting.size() < kWaitingSizeMax) submit(*in);
  }
  // Called inside handle_events(), so on the device thread.
  static void LIBUSB_CALL on_in(libusb_transfer* transfer) {
    auto& in = *static_cast<InTransfer*>(transfer->user_data);
    InStream& self = *in.stream;
    in.in_flight = false;
    if (transfer->status != LIBUSB_TRANSFER_COMPLETED) {
      if (self.failure == LIBUSB_SUCCESS) self.failure = code_of(transfer->status);
      return;
    }
    const int size = transfer->actual_length;
    if (size > 0) {
      self.waiting.push_back(static_cast<std::uint8_t>(size & 0xFF));
      self.waiting.push_back(static_cast<std::uint8_t>(size >> 8));
      self.waiting.insert(self.waiting.end(), in.buffer.begin(), in.buffer.begin() + size);
    }
    if (self.waiting.size() < kWaitingSizeMax && !self.closing) self.submit(in);
  }
  // Takes one transfer, or as much of it as fits into `into`.
  std::size_t take(std::span<std::uint8_t> into) {
    if (waiting_begin == waiting.size()) return 0;
    std::uint8_t* const head = waiting.data() + waiting_begin;
    const auto size = static_cast<std::size_t>(head[0] | head[1] << 8);
    const std::size_t count = std::min(into.size(), size);
    std::copy_n(head + 2, count, into.begin());
    if (count < size) {
      // The rest gets a new size field, over the bytes that were taken.
      std::uint8_t* const rest = head + count;
      rest[0] = static_cast<std::uint8_t>((size - count) & 0xFF);
      rest[1] = static_cast<std::uint8_t>((size - count) >> 8);
      waiting_begin += count;
    } else {
      waiting_begin += 2 + size;
    }
    if (waiting_begin == waiting.size()) {
      waiting.clear();
      waiting_begin = 0;
    }
    submit_idle();
    return count;
  }
};

class LibusbTransport final : public Transport {
 public:
  LibusbTransport(std::shared_ptr<Bus> bus, OwnedDevice device, OwnedHandle handle, std::string where,
                  std::string serial)
      : bus_(std::move(bus)),
        device_(std::move(device)),
        handle_(std::move(handle)),
        where_(std::move(where)),
        serial_(std::move(serial)) {
    bus_->open = device_.get();
    bus_->open_has_left = false;
  }

  ~LibusbTransport() override {
    bus_->open = nullptr;
    for (const auto& stream : streams_) {
      stream->closing = true;  // a transfer that ends with data now must not be submitted again
      for (const auto& in : stream->transfers)
        if (in->in_flight) libusb_cancel_transfer(in->transfer.get());
    }
    const TimeNs patience_ns = bus_->clock.now_ns() + kCancelPatienceNs;
    while (in_flight() && bus_->clock.now_ns() < patience_ns) bus_->handle_events(patience_ns);
    if (in_flight()) {
      // The kernel may still write to the buffers, so they are never freed.
      for (auto& stream : streams_) (void)stream.release();
      (void)handle_.release();
      return;
    }
    libusb_release_interface(handle_.get(), kInterface);  // binds the kernel driver again
  }

  std::string where() const override { return where_; }
  std::string serial() const override { return serial_; }

  Status wait(TimeNs deadline_ns) override {
    while (true) {
      if (bus_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
      if (bus_->open_has_left) return fail(ErrorCode::kDisconnected, "{}: unplugged", where_);
      if (bus_->woken.exchange(false) || bus_->clock.now_ns() >= deadline_ns) return {};
      bus_->handle_events(deadline_ns);
    }
  }

  Status write(std::span<const std::uint8_t>, TimeNs) override {
    return fail(ErrorCode::kUnsupported, "{}: is no serial line", where_);
  }
  Result<std::size_t> read(std::span<std::uint8_t>, TimeNs) override {
    return fail(ErrorCode::kUnsupported, "{}: is no serial line", where_);
  }

  Status control_out(const ControlRequest& request, std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    FL_ASSIGN(const std::size_t count,
              control(
                  request, bytes.size(), [&](std::uint8_t* data) { std::copy(bytes.begin(), bytes.end(), data); },
                  deadline_ns));
    if (count < bytes.size())
      return fail(ErrorCode::kIo, "{}: took {} of {} bytes of a control transfer", where_, count, bytes.size());
    return {};
  }
  Result<std::size_t> control_in(const ControlRequest& request, std::span<std::uint8_t> into,
                                 TimeNs deadline_ns) override {
    FL_ASSIGN(const std::size_t count, control(
                                           request, into.size(), [](std::uint8_t*) {}, deadline_ns));
    std::copy_n(buffer_.begin() + LIBUSB_CONTROL_SETUP_SIZE, count, into.begin());
    return count;
  }

  Status write_endpoint(std::uint8_t endpoint, std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    buffer_.assign(bytes.begin(), bytes.end());
    std::size_t written = 0;
    while (written < bytes.size()) {
      const auto fill = is_interrupt(endpoint) ? &libusb_fill_interrupt_transfer : &libusb_fill_bulk_transfer;
      fill(out_.get(), handle_.get(), endpoint, buffer_.data() + written, static_cast<int>(bytes.size() - written),
           &LibusbTransport::on_out, this, 0);
      const Status ran = run(deadline_ns, "write");
      // A halted endpoint refuses all transfers until the halt is cleared, also after the device is opened again.
      if (out_->status == LIBUSB_TRANSFER_STALL) (void)libusb_clear_halt(handle_.get(), endpoint);
      if (!ran) return ran;
      written += static_cast<std::size_t>(out_->actual_length);
      const bool late = out_->status == LIBUSB_TRANSFER_CANCELLED ||
                        (out_->actual_length == 0 && bus_->clock.now_ns() >= deadline_ns);
      if (late && written < bytes.size())
        return fail(ErrorCode::kTimeout, "{}: took {} of {} bytes in time", where_, written, bytes.size());
    }
    return {};
  }

  Result<std::size_t> read_endpoint(std::uint8_t endpoint, std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    InStream& in = stream(endpoint);
    while (true) {
      if (bus_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
      if (bus_->woken.exchange(false)) return 0;
      if (const std::size_t count = in.take(into); count > 0) return count;
      if (in.failure != LIBUSB_SUCCESS) return usb_error(in.failure, where_, "read");
      if (bus_->clock.now_ns() >= deadline_ns) return 0;
      bus_->handle_events(deadline_ns);
    }
  }

  std::size_t packet_size(std::uint8_t endpoint) const override {
    const int size = libusb_get_max_packet_size(device_.get(), endpoint);
    return size > 0 ? static_cast<std::size_t>(size) : Transport::packet_size(endpoint);
  }

 private:
  bool in_flight() const {
    return std::any_of(streams_.begin(), streams_.end(), [](const auto& stream) {
      return std::any_of(stream->transfers.begin(), stream->transfers.end(),
                         [](const auto& in) { return in->in_flight; });
    });
  }

  // Submits the transfers of the endpoint if that was not done yet.
  InStream& stream(std::uint8_t endpoint) {
    for (const auto& known : streams_)
      if (known->endpoint == endpoint) return *known;
    InStream& added = *streams_.emplace_back(std::make_unique<InStream>());
    added.endpoint = endpoint;
    added.waiting.reserve(kWaitingSizeMax + kInTransferCount * (kUsbTransferSizeMax + 2));
    for (auto& in : added.transfers) {
      in = std::make_unique<InStream::InTransfer>();
      in->stream = &added;
      in->transfer.reset(libusb_alloc_transfer(0));
    }
    for (auto& in : added.transfers) {
      const auto fill = is_interrupt(endpoint) ? &libusb_fill_interrupt_transfer : &libusb_fill_bulk_transfer;
      fill(in->transfer.get(), handle_.get(), endpoint, in->buffer.data(), kInTransferSize, &InStream::on_in, in.get(),
           0);
      if (added.failure == LIBUSB_SUCCESS) added.submit(*in);
    }
    return added;
  }

  bool is_interrupt(std::uint8_t endpoint) const {
    libusb_config_descriptor* config = nullptr;
    if (libusb_get_active_config_descriptor(device_.get(), &config) != LIBUSB_SUCCESS) return false;
    bool found = false;
    for (int i = 0; i < config->bNumInterfaces; ++i)
      for (int a = 0; a < config->interface[i].num_altsetting; ++a) {
        const libusb_interface_descriptor& setting = config->interface[i].altsetting[a];
        for (int e = 0; e < setting.bNumEndpoints; ++e)
          if (setting.endpoint[e].bEndpointAddress == endpoint)
            found = (setting.endpoint[e].bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) == LIBUSB_TRANSFER_TYPE_INTERRUPT;
      }
    libusb_free_config_descriptor(config);
    return found;
  }

  // Received bytes are in buffer_ behind the setup packet. Returns how many bytes were transferred.
  template <class Fill>
  Result<std::size_t> control(const ControlRequest& request, std::size_t size, Fill&& fill_data, TimeNs deadline_ns) {
    buffer_.assign(LIBUSB_CONTROL_SETUP_SIZE + size, 0);
    fill_data(buffer_.data() + LIBUSB_CONTROL_SETUP_SIZE);
    libusb_fill_control_setup(buffer_.data(), request.request_type, request.request, request.value, request.index,
                              static_cast<std::uint16_t>(size));
    libusb_fill_control_transfer(out_.get(), handle_.get(), buffer_.data(), &LibusbTransport::on_out, this, 0);
    FL_TRY(run(deadline_ns, "control transfer"));
    if (out_->status == LIBUSB_TRANSFER_CANCELLED)
      return fail(ErrorCode::kTimeout, "{}: no answer to control request {} in time", where_, request.request);
    return static_cast<std::size_t>(out_->actual_length);
  }

  // Submits out_ and waits until it is completed, or cancels it at the deadline.
  Status run(TimeNs deadline_ns, std::string_view action) {
    if (bus_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
    out_done_ = false;
    if (const int code = libusb_submit_transfer(out_.get()); code != LIBUSB_SUCCESS)
      return usb_error(code, where_, action);
    bool cancelled = false;
    while (!out_done_) {
      const bool late = bus_->clock.now_ns() >= deadline_ns;
      if ((late || bus_->aborted) && !cancelled) {
        libusb_cancel_transfer(out_.get());
        cancelled = true;
      }
      bus_->handle_events(cancelled ? kTimeNever : deadline_ns);
    }
    if (out_->status == LIBUSB_TRANSFER_CANCELLED && bus_->aborted)
      return fail(ErrorCode::kDisconnected, "{}: closed", where_);
    if (out_->status != LIBUSB_TRANSFER_COMPLETED && out_->status != LIBUSB_TRANSFER_CANCELLED)
      return usb_error(code_of(out_->status), where_, action);
    return {};
  }
  static void LIBUSB_CALL on_out(libusb_transfer* transfer) {
    static_cast<LibusbTransport*>(transfer->user_data)->out_done_ = true;
  }

  std::shared_ptr<Bus> bus_;
  OwnedDevice device_;
  OwnedHandle handle_;
  const std::string where_;
  const std::string serial_;
  std::vector<std::unique_ptr<InStream>> streams_;
  std::vector<std::uint8_t> buffer_;  // of out_
  OwnedTransfer out_{libusb_alloc_transfer(0)};
  bool out_done_ = false;
};

class LibusbOpener final : public Opener {
 public:
  LibusbOpener(LibusbConfig config, std::shared_ptr<Bus> bus)
      : unknown_kind_(config.unknown_kind), chooser_(std::move(config.chooser)), bus_(std::move(bus)) {
    // Without hotplug support wait() lasts until its deadline.
    (void)libusb_hotplug_register_callback(bus_->context.get(),
                                           LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, 0,
                                           LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY,
                                           &LibusbOpener::on_hotplug, bus_.get(), nullptr);
  }

  Result<std::unique_ptr<Transport>> connect() override {
    if (bus_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", chooser_->driver_id());
    FL_ASSIGN(const FoundDevice found, chooser_->choose());
    FL_ASSIGN(OwnedDevice device, device_at(found.node));

    libusb_device_handle* opened = nullptr;
    const int code = libusb_open(device.get(), &opened);
    if (code == LIBUSB_ERROR_ACCESS)
      return fail(ErrorCode::kPermission, "{}",
                  message_of(advise_on_permission(found, found.node, EACCES, chooser_->options())));
    if (code != LIBUSB_SUCCESS) return usb_error(code, found.node, "open");
    OwnedHandle handle(opened);
    libusb_set_auto_detach_kernel_driver(handle.get(), 1);
    if (const int claimed = libusb_claim_interface(handle.get(), kInterface); claimed != LIBUSB_SUCCESS)
      return usb_error(claimed, found.node, "claim");
    std::unique_ptr<Transport> transport =
        std::make_unique<LibusbTransport>(bus_, std::move(device), std::move(handle), found.node, found.serial);
    if ((found.driver_id.empty() ? unknown_kind_ : found.transport) == TransportKind::kFtdi) {
      FL_ASSIGN(transport, open_ftdi(std::move(transport), found.usb_release, bus_->clock));
    }
    chooser_->pin(found);
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
  std::string identity() override { return chooser_->identity(); }

 private:
  static int LIBUSB_CALL on_hotplug(libusb_context*, libusb_device* device, libusb_hotplug_event event, void* user) {
    auto& bus = *static_cast<Bus*>(user);
    if (event == LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED)
      bus.arrived = true;
    else if (device == bus.open)
      bus.open_has_left = true;
    return 0;
  }

  // node: "/dev/bus/usb/001/004"; the last two parts are libusb's bus number and device address.
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

  const TransportKind unknown_kind_;
  const std::shared_ptr<Chooser> chooser_;
  const std::shared_ptr<Bus> bus_;  // shared with the transport
};

}  // namespace

Result<std::unique_ptr<Opener>> make_libusb_opener(LibusbConfig config, Clock& clock) {
  libusb_context* context = nullptr;
  if (const int code = libusb_init(&context); code != LIBUSB_SUCCESS) return usb_error(code, "libusb", "start");
  return std::make_unique<LibusbOpener>(std::move(config), std::make_shared<Bus>(context, clock));
}

}  // namespace footlight::drivers

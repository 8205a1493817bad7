#include "tests/support/usb_fs.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "sim/core/check.h"
#include "tests/support/stock_kernel.h"

namespace footlight::testing {
namespace {

using drivers::mock::Bytes;
using drivers::mock::SetupPacket;

constexpr const char* kHub = "/sys/devices/pci0000:00/0000:00:14.0/usb1";
constexpr std::size_t kSetupSize = 8;

std::string hex_of(const Bytes& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02X}", byte);
  return text;
}

usbdevfs_urb& content_of(UMockdevIoctlData* urb) { return *reinterpret_cast<usbdevfs_urb*>(urb->data); }

void release(UMockdevIoctlData* urb, UMockdevIoctlData* buffer) {
  if (buffer != nullptr) umockdev_ioctl_data_unref(buffer);
  umockdev_ioctl_data_unref(urb);
}

}  // namespace

UsbSocket::UsbSocket(Testbed& testbed, drivers::mock::UsbModel& model, int socket)
    : testbed_(testbed), model_(model), socket_(socket), handler_(umockdev_ioctl_base_new()) {
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&UsbSocket::on_ioctl), this);
  thread_ = std::thread([this] { complete_in_time(); });
}

UsbSocket::~UsbSocket() {
  if (plugged_) unplug();
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
  for (const Urb& urb : in_flight_) release(urb.urb, urb.buffer);
  for (const Urb& urb : ended_) release(urb.urb, urb.buffer);
  g_object_unref(handler_);
}

std::string UsbSocket::node() const { return fmt::format("/dev/bus/usb/001/{:03}", socket_ + 1); }
std::string UsbSocket::port_path() const { return fmt::format("1-{}", socket_); }

bool UsbSocket::claimed() {
  const std::lock_guard lock(mutex_);
  return claimed_;
}

std::string UsbSocket::kernel_driver() {
  const std::lock_guard lock(mutex_);
  return driver_;
}

void UsbSocket::lose_kernel_driver() {
  const std::lock_guard lock(mutex_);
  bind("");
}

bool UsbSocket::transfer_in_flight(std::uint8_t endpoint) {
  return wait_for([&] {
    return std::any_of(in_flight_.begin(), in_flight_.end(),
                       [&](const Urb& urb) { return content_of(urb.urb).endpoint == endpoint; });
  });
}

void UsbSocket::plug() {
  FL_CHECK(umockdev_testbed_attach_ioctl(testbed_.get(), node().c_str(), handler_, nullptr));
  if (!std::filesystem::exists(testbed_.root() + kHub))  // libusb needs a parent for the port number
    add_device(
        testbed_.get(),
        fmt::format(
            "P: {}\nN: bus/usb/001/001\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: BUSNUM=001\nE: DEVNUM=001\n"
            "E: MAJOR=189\nE: MINOR=0\nE: DEVNAME=/dev/bus/usb/001/001\nA: busnum=1\\n\nA: devnum=1\\n\n"
            "A: speed=480\\n\nA: bConfigurationValue=1\\n\nA: idVendor=1d6b\\n\nA: idProduct=0002\\n\n"
            "H: descriptors=12010002090001406B1D020001060302010109021900010100E0000904000001090000000705810304000C\n\n",
            std::string(kHub).substr(4)));
  const Bytes device = model_.device_descriptor();
  std::vector<std::string> texts = model_.strings();
  texts.resize(3);
  const std::string ids = fmt::format(
      "A: idVendor={:02x}{:02x}\\n\nA: idProduct={:02x}{:02x}\\n\n"
      "A: bcdDevice={:02x}{:02x}\\n\n",
      device[9], device[8], device[11], device[10], device[13], device[12]);
  std::string attributes;
  const char* names[] = {"manufacturer", "product", "serial"};
  for (std::size_t i = 0; i < texts.size(); ++i)
    if (!texts[i].empty()) attributes += fmt::format("A: {}={}\\n\n", names[i], texts[i]);
  {
    const std::lock_guard lock(mutex_);
    model_.power_on();
    plugged_ = true;
    claimed_ = false;
  }
  add_device(
      testbed_.get(),
      fmt::format(
          "P: {}/{}\nN: bus/usb/001/{:03}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: BUSNUM=001\nE: DEVNUM={:03}\n"
          "E: MAJOR=189\nE: MINOR={}\nE: DEVNAME={}\nA: busnum=1\\n\nA: devnum={}\\n\nA: speed=12\\n\n"
          "A: bConfigurationValue=1\\n\n{}{}H: descriptors={}{}\n\n",
          std::string(kHub).substr(4), port_path(), socket_ + 1, socket_ + 1, socket_, node(), socket_ + 1, ids,
          attributes, hex_of(device), hex_of(model_.config_descriptor())));
  const std::lock_guard lock(mutex_);
  bind(stock_driver_of(model_));
  make_gate();
}

void UsbSocket::unplug() {
  {
    const Notifier notifier{*this};
    const std::lock_guard lock(mutex_);
    plugged_ = false;
    for (Urb& urb : in_flight_) {
      urb.status = -ESHUTDOWN;
      urb.actual_size = 0;
      ended_.push_back(urb);
    }
    in_flight_.clear();
    set_gate(true);
    ::close(gate_fd_);
    gate_fd_ = -1;
  }
  const std::string device = fmt::format("{}/{}", kHub, port_path());
  std::filesystem::remove_all(fmt::format("{}{}/{}:1.0", testbed_.root(), device, port_path()));
  umockdev_testbed_uevent(testbed_.get(), device.c_str(), "remove");
  umockdev_testbed_remove_device(testbed_.get(), device.c_str());
  umockdev_testbed_detach_ioctl(testbed_.get(), node().c_str(), nullptr);
  std::filesystem::remove(testbed_.root() + node());
}

// Call with the lock held. Makes the interface's folder in /sys, with the link to its driver.
void UsbSocket::bind(const std::string& driver) {
  driver_ = driver;
  const std::filesystem::path interface =
      fmt::format("{}{}/{}/{}:1.0", testbed_.root(), kHub, port_path(), port_path());
  std::filesystem::create_directories(interface);
  std::filesystem::remove(interface / "driver");
  if (!driver.empty())
    std::filesystem::create_symlink("../../../../../../bus/usb/drivers/" + driver, interface / "driver");
}

void UsbSocket::make_gate() {
  const std::string path = testbed_.root() + node();
  ::unlink(path.c_str());
  FL_CHECK_EQ(::mkfifo(path.c_str(), 0600), 0);
  gate_fd_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  FL_CHECK_GE(gate_fd_, 0);
  ::fcntl(gate_fd_, F_SETPIPE_SZ, 4096);  // one byte in a one-page pipe makes it full for poll()
  gate_open_ = true;
  set_gate(!ended_.empty());
}

void UsbSocket::set_gate(bool open) {
  if (open == gate_open_ || gate_fd_ < 0) return;
  gate_open_ = open;
  char byte = 0;
  const ssize_t moved = open ? ::read(gate_fd_, &byte, 1) : ::write(gate_fd_, &byte, 1);
  FL_CHECK_EQ(moved, 1);
}

gboolean UsbSocket::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, UsbSocket* self) {
  const Notifier notifier{*self};
  const std::lock_guard lock(self->mutex_);
  self->answer(client);
  return TRUE;
}

void UsbSocket::answer(UMockdevIoctlClient* client) {
  const unsigned long request = umockdev_ioctl_client_get_request(client);
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  if (!plugged_ && request != USBDEVFS_REAPURB && request != USBDEVFS_REAPURBNDELAY) return reply(client, -1, ENODEV);
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
      *Argument<guint32>(argument) = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION |
                                     USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_BULK_SCATTER_GATHER |
                                     USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      return reply(client, 0);
    case USBDEVFS_GETDRIVER: {
      if (driver_.empty()) return reply(client, -1, ENODATA);
      const Argument<usbdevfs_getdriver> driver(argument);
      std::snprintf(driver->driver, sizeof driver->driver, "%s", driver_.c_str());
      return reply(client, 0);
    }
    case USBDEVFS_IOCTL: {
      const Argument<usbdevfs_ioctl> inner(argument);
      if (static_cast<unsigned>(inner->ioctl_code) == USBDEVFS_CONNECT) {
        if (claimed_) return reply(client, -1, EBUSY);
        bind(stock_driver_of(model_));
        return reply(client, driver_.empty() ? 0 : 1);
      }
      if (static_cast<unsigned>(inner->ioctl_code) != USBDEVFS_DISCONNECT) return reply(client, -1, ENOTTY);
      if (driver_.empty()) return reply(client, -1, ENODATA);
      bind("");
      return reply(client, 0);
    }
    case USBDEVFS_DISCONNECT_CLAIM:
    case USBDEVFS_CLAIMINTERFACE:
      if (claim_error != 0) return reply(client, -1, claim_error);
      if (request == USBDEVFS_CLAIMINTERFACE && !driver_.empty()) return reply(client, -1, EBUSY);
      bind("usbfs");
      claimed_ = true;
      return reply(client, 0);
    case USBDEVFS_RELEASEINTERFACE:
      bind("");
      claimed_ = false;
      return reply(client, 0);
    case USBDEVFS_CLEAR_HALT: out_halted = false; return reply(client, 0);
    case USBDEVFS_RESET:
    case USBDEVFS_RESETEP:
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION: return reply(client, 0);
    case USBDEVFS_SUBMITURB: return submit(client, argument);
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY: return reap(client, argument);
    case USBDEVFS_DISCARDURB: return discard(client, argument);
    default: return reply(client, -1, ENOTTY);
  }
}

void UsbSocket::submit(UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
  Urb urb{.urb = umockdev_ioctl_data_resolve(argument, 0, sizeof(usbdevfs_urb), nullptr),
          .buffer = nullptr,
          .due = std::chrono::steady_clock::now()};
  const usbdevfs_urb& content = content_of(urb.urb);
  if (content.buffer_length > 0)
    urb.buffer = umockdev_ioctl_data_resolve(urb.urb, G_STRUCT_OFFSET(usbdevfs_urb, buffer),
                                             static_cast<gsize>(content.buffer_length), nullptr);
  const bool is_control = content.type == USBDEVFS_URB_TYPE_CONTROL;
  if (!is_control && !claimed_) {
    release(urb.urb, urb.buffer);
    return reply(client, -1, EINVAL);
  }
  if (is_control) {
    run_control(urb);
    finish(urb);
    return reply(client, 0);
  }
  if ((content.endpoint & 0x80) != 0)
    urb.due += std::chrono::milliseconds(std::max(model_.in_latency_ms(content.endpoint), 0));
  if (run_bulk(urb, std::chrono::steady_clock::now()))
    finish(urb);
  else
    in_flight_.push_back(urb);
  reply(client, 0);
}

void UsbSocket::run_control(Urb& urb) {
  pass_time();
  const std::uint8_t* bytes = urb.buffer->data;
  const auto word_at = [&](std::size_t i) { return static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8); };
  const SetupPacket setup{bytes[0], bytes[1], word_at(2), word_at(4), word_at(6)};
  const auto size = static_cast<std::size_t>(content_of(urb.urb).buffer_length);
  const auto answered = model_.control(setup, {bytes + kSetupSize, size - kSetupSize});
  if (!answered) {
    urb.status = -EPIPE;
  } else if ((setup.request_type & 0x80) != 0) {
    const std::size_t count = std::min(answered->size(), size - kSetupSize);
    std::memcpy(urb.buffer->data + kSetupSize, answered->data(), count);
    urb.actual_size = static_cast<int>(count);
  } else {
    urb.actual_size = setup.length;
  }
}

// On the same clock as SystemClock.
void UsbSocket::pass_time() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  (void)model_.pass_time(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
}

bool UsbSocket::run_bulk(Urb& urb, Time now) {
  pass_time();
  const usbdevfs_urb& content = content_of(urb.urb);
  if ((content.endpoint & 0x80) != 0) {
    const bool timer_ran_out = model_.in_latency_ms(content.endpoint) >= 0 && urb.due <= now;
    if (in_frozen || (!model_.has_data(content.endpoint) && !timer_ran_out)) return false;
    const Bytes bytes = model_.data_in(content.endpoint, static_cast<std::size_t>(content.buffer_length));
    std::memcpy(urb.buffer->data, bytes.data(), bytes.size());
    urb.actual_size = static_cast<int>(bytes.size());
    return true;
  }
  if (out_frozen) return false;
  urb.status = out_halted ? -EPIPE : out_status.load();
  if (urb.status != 0) return true;
  const int count = out_size_max < 0 ? content.buffer_length : std::min(content.buffer_length, out_size_max.load());
  if (urb.buffer != nullptr) model_.data_out(content.endpoint, {urb.buffer->data, static_cast<std::size_t>(count)});
  urb.actual_size = count;
  return true;
}

void UsbSocket::finish(const Urb& urb) {
  ended_.push_back(urb);
  set_gate(true);
}

void UsbSocket::reap(UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
  if (ended_.empty()) {
    if (plugged_) set_gate(false);
    return reply(client, -1, plugged_ ? EAGAIN : ENODEV);
  }
  const Urb urb = ended_.front();
  ended_.pop_front();
  content_of(urb.urb).status = urb.status;
  content_of(urb.urb).actual_length = urb.actual_size;
  UMockdevIoctlData* pointer = umockdev_ioctl_data_resolve(argument, 0, sizeof(gpointer), nullptr);
  umockdev_ioctl_data_set_ptr(pointer, 0, umockdev_ioctl_data_ref(urb.urb));
  reply(client, 0);  // copies the urb and its buffer to the caller
  umockdev_ioctl_data_unref(pointer);
  release(urb.urb, urb.buffer);
}

void UsbSocket::discard(UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
  const gulong address = *reinterpret_cast<gulong*>(argument->data);  // the pointer itself, as the caller passed it
  const auto found = std::find_if(in_flight_.begin(), in_flight_.end(),
                                  [&](const Urb& urb) { return urb.urb->client_addr == address; });
  if (found == in_flight_.end()) return reply(client, -1, EINVAL);
  found->status = -ENOENT;
  found->actual_size = 0;
  finish(*found);
  in_flight_.erase(found);
  reply(client, 0);
}

void UsbSocket::complete_in_time() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const Time now = std::chrono::steady_clock::now();
    Time next = now + std::chrono::seconds(1);
    bool ended_one = false;
    for (auto urb = in_flight_.begin(); urb != in_flight_.end();) {
      if (run_bulk(*urb, now)) {
        finish(*urb);
        urb = in_flight_.erase(urb);
        ended_one = true;
        continue;
      }
      if (!in_frozen && urb->due > now) next = std::min(next, urb->due);
      ++urb;
    }
    if (ended_one) changed_.notify_all();
    changed_.wait_until(lock, std::chrono::system_clock::now() + (next - now));
  }
}

}  // namespace footlight::testing

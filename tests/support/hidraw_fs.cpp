#include "tests/support/hidraw_fs.h"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <linux/input.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include <fmt/format.h>

#include "sim/core/check.h"
#include "tests/support/stock_kernel.h"

namespace footlight::testing {
namespace {

using drivers::mock::Bytes;

constexpr const char* kHub = "/devices/pci0000:00/0000:00:14.0/usb1";
constexpr std::uint8_t kEndpointOut = 0x01, kEndpointIn = 0x81;  // models of HID devices have one each

std::string hex_of(const Bytes& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02X}", byte);
  return text;
}

gboolean answer(UMockdevIoctlClient* client, long result, int error = 0) {
  reply(client, result, error);
  return TRUE;
}

}  // namespace

HidSocket::HidSocket(Testbed& testbed, drivers::mock::HidModel& model, int socket)
    : testbed_(testbed), model_(model), socket_(socket), handler_(umockdev_ioctl_base_new()) {
  g_signal_connect(handler_, "client-connected", G_CALLBACK(&HidSocket::on_client_connected), this);
  g_signal_connect(handler_, "client-vanished", G_CALLBACK(&HidSocket::on_client_vanished), this);
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&HidSocket::on_ioctl), this);
  g_signal_connect(handler_, "handle-read", G_CALLBACK(&HidSocket::on_read), this);
  g_signal_connect(handler_, "handle-write", G_CALLBACK(&HidSocket::on_write), this);
}

HidSocket::~HidSocket() {
  if (announced_) unplug();
  g_object_unref(handler_);
}

std::string HidSocket::node() const { return fmt::format("/dev/hidraw{}", socket_); }
std::string HidSocket::port_path() const { return fmt::format("1-{}", socket_); }
std::string HidSocket::folder() const { return fmt::format("{}/{}", kHub, port_path()); }

void HidSocket::plug() {
  FL_CHECK(stock_driver_of(model_) == "usbhid");  // others have no hidraw node; use a UsbSocket
  const Bytes device = model_.device_descriptor();
  const auto id = [&](std::size_t at) { return fmt::format("{:02x}{:02x}", device[at + 1], device[at]); };
  const std::string name = fmt::format("0003:{}:{}.{:04}", id(8), id(10), socket_);
  const std::string interface = fmt::format("{}/{}:1.0", folder(), port_path());
  std::string attributes;
  const char* names[] = {"manufacturer", "product", "serial"};
  std::vector<std::string> texts = model_.strings();
  texts.resize(3);
  for (std::size_t i = 0; i < texts.size(); ++i)
    if (!texts[i].empty()) attributes += fmt::format("A: {}={}\\n\n", names[i], texts[i]);

  FL_CHECK(umockdev_testbed_attach_ioctl(testbed_.get(), node().c_str(), handler_, nullptr));
  {
    const std::lock_guard lock(mutex_);
    model_.power_on();
    plugged_ = announced_ = true;
    ++plug_count_;
    write_count_ = 0;
    const std::string path = testbed_.root() + node();
    std::filesystem::create_directories(testbed_.root() + "/dev");
    ::unlink(path.c_str());
    FL_CHECK_EQ(::mkfifo(path.c_str(), 0600), 0);
    fifo_fd_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    FL_CHECK_GE(fifo_fd_, 0);
    FL_CHECK_EQ(::fcntl(fifo_fd_, F_SETFL, O_NONBLOCK | O_DIRECT), 0);  // packets: one write, one read
  }
  if (!std::filesystem::exists(testbed_.root() + "/sys" + kHub))
    add_device(testbed_.get(), fmt::format("P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: busnum=1\\n\n"
                                           "A: devnum=1\\n\nA: idVendor=1d6b\\n\nA: idProduct=0002\\n\n\n",
                                           kHub));
  add_device(testbed_.get(),
             fmt::format("P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: busnum=1\\n\nA: devnum={}\\n\n"
                         "A: idVendor={}\\n\nA: idProduct={}\\n\nA: bcdDevice={}\\n\n{}H: descriptors={}{}\n\n",
                         folder(), socket_ + 1, id(8), id(10), id(12), attributes, hex_of(device),
                         hex_of(model_.config_descriptor())));
  add_device(testbed_.get(), fmt::format("P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\n"
                                         "A: bInterfaceNumber=00\\n\n\n",
                                         interface));
  add_device(testbed_.get(), fmt::format("P: {}/{}\nE: SUBSYSTEM=hid\nE: DRIVER=hid-generic\n"
                                         "H: report_descriptor={}\n\n",
                                         interface, name, hex_of(model_.report_descriptor())));
  add_device(testbed_.get(),
             fmt::format("P: {}/{}/hidraw/hidraw{}\nE: SUBSYSTEM=hidraw\n\n", interface, name, socket_));
  ::chmod((testbed_.root() + node()).c_str(), 0660);  // as udev does, last
}

void HidSocket::unplug() {
  {
    const std::lock_guard lock(mutex_);
    plugged_ = announced_ = false;
    constexpr char kWakeUp = 0;
    (void)!::write(fifo_fd_, &kWakeUp, 1);  // so that poll() returns; read() then answers ENODEV
    ::close(fifo_fd_);
    fifo_fd_ = -1;
    std::filesystem::remove(testbed_.root() + node());
  }
  changed_.notify_all();
  const std::string path = "/sys" + folder();
  umockdev_testbed_uevent(testbed_.get(), path.c_str(), "remove");
  umockdev_testbed_remove_device(testbed_.get(), path.c_str());
  std::filesystem::remove_all(testbed_.root() + path);
  for (const char* bus : {"/sys/bus/usb/devices", "/sys/bus/hid/devices", "/sys/class/hidraw"}) {
    const std::filesystem::path links = testbed_.root() + bus;
    if (!std::filesystem::exists(links)) continue;
    std::vector<std::filesystem::path> dead;
    for (const auto& entry : std::filesystem::directory_iterator(links))
      if (!std::filesystem::exists(entry.path())) dead.push_back(entry.path());
    for (const auto& link : dead) std::filesystem::remove(link);
  }
  umockdev_testbed_detach_ioctl(testbed_.get(), node().c_str(), nullptr);
}

// Call with the lock held.
void HidSocket::send_reports() {
  while (plugged_ && model_.has_data(kEndpointIn)) {
    const Bytes report = model_.data_in(kEndpointIn, 64);
    (void)!::write(fifo_fd_, report.data(), report.size());  // a full queue drops it, as the kernel does
  }
}

void HidSocket::on_client_connected(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self) {
  const std::lock_guard lock(self->mutex_);
  self->plug_of_client_[client] = self->plug_count_;
}

void HidSocket::on_client_vanished(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self) {
  const std::lock_guard lock(self->mutex_);
  self->plug_of_client_.erase(client);
}

// Called with the lock.
bool HidSocket::is_there_for(UMockdevIoctlClient* client) const {
  const auto plug = plug_of_client_.find(client);
  FL_CHECK(plug != plug_of_client_.end());
  return plugged_ && plug->second == plug_count_;
}

gboolean HidSocket::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self) {
  const std::lock_guard lock(self->mutex_);
  if (!self->is_there_for(client)) return answer(client, -1, ENODEV);
  if (umockdev_ioctl_client_get_request(client) == HIDIOCGRDESCSIZE) {
    ++self->size_request_count_;
    const Argument<int> size(umockdev_ioctl_client_get_arg(client));
    *size = static_cast<int>(self->model_.report_descriptor().size());
    return answer(client, 0);
  }
  if (umockdev_ioctl_client_get_request(client) != HIDIOCGRAWINFO) return answer(client, -1, EINVAL);
  const Bytes device = self->model_.device_descriptor();
  const auto word = [&](std::size_t at) { return static_cast<__s16>(device[at] | device[at + 1] << 8); };
  const Argument<hidraw_devinfo> info(umockdev_ioctl_client_get_arg(client));
  *info = {.bustype = BUS_USB, .vendor = word(8), .product = word(10)};
  return answer(client, 0);
}

gboolean HidSocket::on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self) {
  const std::lock_guard lock(self->mutex_);
  return self->is_there_for(client) ? FALSE : answer(client, -1, ENODEV);  // FALSE: from the FIFO
}

gboolean HidSocket::on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self) {
  gboolean done = TRUE;
  {
    const std::lock_guard lock(self->mutex_);
    const int number = self->write_count_++;
    if (self->unplug_at_write >= 0 && number >= self->unplug_at_write) self->plugged_ = false;
    if (!self->is_there_for(client)) {
      done = answer(client, -1, ENODEV);
    } else if (self->write_error != 0) {
      done = answer(client, -1, self->write_error);
    } else {
      UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
      auto size = static_cast<std::size_t>(argument->data_len);
      if (self->write_size_max >= 0) size = std::min(size, static_cast<std::size_t>(self->write_size_max));
      if (size > 0) self->model_.data_out(kEndpointOut, {argument->data + 1, size - 1});  // without the report number
      self->send_reports();
      done = answer(client, static_cast<long>(size));
    }
  }
  self->changed_.notify_all();
  return done;
}

}  // namespace footlight::testing

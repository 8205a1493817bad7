#include "tests/support/tty_fs.h"

#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

#include "sim/core/check.h"

namespace footlight::testing {
namespace {

using drivers::mock::Bytes;

constexpr const char* kHub = "/devices/pci0000:00/0000:00:14.0/usb1";
constexpr std::uint8_t kVendorOut = 0x40, kSetLineData = 4, kVendorIn = 0xC0, kModemStatus = 5;
constexpr std::uint16_t kLineData = 0x1008, kBreakBit = 0x4000;

}  // namespace

TtySocket::TtySocket(Testbed& testbed, drivers::mock::SerialModel& model, std::string tty, int socket)
    : testbed_(testbed), model_(model), tty_(std::move(tty)), socket_(socket), handler_(umockdev_ioctl_base_new()) {
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&TtySocket::on_ioctl), this);
}

TtySocket::~TtySocket() {
  if (plugged_) unplug();
  g_object_unref(handler_);
}

unsigned TtySocket::baud() {
  const std::lock_guard lock(mutex_);
  return baud_;
}
bool TtySocket::has_two_stop_bits() {
  const std::lock_guard lock(mutex_);
  return two_stop_bits_;
}

void TtySocket::plug() {
  const std::string node = "/dev/" + tty_;
  FL_CHECK(umockdev_testbed_attach_ioctl(testbed_.get(), node.c_str(), handler_, nullptr));
  const Bytes device = model_.device_descriptor();
  const std::string path = fmt::format("{}/1-{}", kHub, socket_);
  std::string attributes;
  for (const auto& [name, text] : {std::pair{"manufacturer", model_.manufacturer}, std::pair{"product", model_.product},
                                   std::pair{"serial", model_.serial}})
    if (!text.empty()) attributes += fmt::format("A: {}={}\\n\n", name, text);
  {
    const std::lock_guard lock(mutex_);
    model_.power_on();
  }
  add_device(
      testbed_.get(),
      fmt::format("P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: busnum=1\\n\nA: devnum={}\\n\n"
                  "A: idVendor={:02x}{:02x}\\n\nA: idProduct={:02x}{:02x}\\n\nA: bcdDevice={:02x}{:02x}\\n\n{}\n",
                  path, socket_ + 1, device[9], device[8], device[11], device[10], device[13], device[12], attributes));
  const bool is_converter = tty_.starts_with("ttyUSB");
  const std::string interface = fmt::format("{}/1-{}:1.0", path, socket_);
  add_device(testbed_.get(), fmt::format("P: {}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\n\n", interface));
  const std::string parent = is_converter ? fmt::format("{}/{}", interface, tty_) : interface;
  if (is_converter) add_device(testbed_.get(), fmt::format("P: {}\nE: SUBSYSTEM=usb-serial\n\n", parent));
  add_device(testbed_.get(), fmt::format("P: {}/tty/{}\nE: SUBSYSTEM=tty\n\n", parent, tty_));
  std::filesystem::remove(fmt::format("{}/sys{}/driver", testbed_.root(), interface));
  const std::lock_guard lock(mutex_);
  // A pseudo-terminal of our own: closing its far end looks like a real unplug at the near end.
  far_end_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  FL_CHECK_GE(far_end_, 0);
  FL_CHECK_EQ(::grantpt(far_end_), 0);
  FL_CHECK_EQ(::unlockpt(far_end_), 0);
  char near_end[64];
  FL_CHECK_EQ(::ptsname_r(far_end_, near_end, sizeof near_end), 0);
  std::filesystem::create_directories(testbed_.root() + "/dev");
  std::filesystem::create_symlink(near_end, testbed_.root() + node);
  stop_fd_ = ::eventfd(0, EFD_CLOEXEC);
  FL_CHECK_GE(stop_fd_, 0);
  plugged_ = true;
  thread_ = std::thread([this] { carry(); });
}

void TtySocket::unplug() {
  {
    const std::lock_guard lock(mutex_);
    plugged_ = false;
    constexpr std::uint64_t kOne = 1;
    (void)!::write(stop_fd_, &kOne, sizeof kOne);
  }
  thread_.join();
  ::close(far_end_);
  ::close(stop_fd_);
  const std::string interface = fmt::format("/sys{}/1-{}/1-{}:1.0", kHub, socket_, socket_);
  const bool is_converter = tty_.starts_with("ttyUSB");
  const std::string parent = is_converter ? fmt::format("{}/{}", interface, tty_) : interface;
  std::vector<std::string> gone{fmt::format("{}/tty/{}", parent, tty_)};
  if (is_converter) gone.push_back(parent);
  gone.push_back(interface);
  gone.push_back(fmt::format("/sys{}/1-{}", kHub, socket_));
  for (const std::string& device : gone) {
    umockdev_testbed_uevent(testbed_.get(), device.c_str(), "remove");
    umockdev_testbed_remove_device(testbed_.get(), device.c_str());
  }
  umockdev_testbed_detach_ioctl(testbed_.get(), ("/dev/" + tty_).c_str(), nullptr);
  std::filesystem::remove(fmt::format("{}/dev/{}", testbed_.root(), tty_));
}

void TtySocket::carry() {
  while (true) {
    pollfd waited[] = {{.fd = far_end_, .events = POLLIN, .revents = 0},
                       {.fd = stop_fd_, .events = POLLIN, .revents = 0}};
    // The near end is not open: ignore its hang-up.
    const bool idle = ::poll(waited, 1, 0) == 1 && (waited[0].revents & POLLIN) == 0;
    ::poll(idle ? waited + 1 : waited, idle ? 1 : 2, 2);
    if ((waited[1].revents & POLLIN) != 0) return;
    Bytes bytes;
    if ((waited[0].revents & POLLIN) != 0) {
      bytes.resize(4096);
      const ssize_t count = ::read(far_end_, bytes.data(), bytes.size());
      bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    }
    const std::lock_guard lock(mutex_);
    if (!bytes.empty()) model_.take(bytes);
    const Bytes answer = model_.read(4096);
    if (!answer.empty()) FL_CHECK_EQ(::write(far_end_, answer.data(), answer.size()), std::ssize(answer));
    changed_.notify_all();
  }
}

gboolean TtySocket::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, TtySocket* self) {
  UMockdevIoctlData* const argument = umockdev_ioctl_client_get_arg(client);
  const unsigned long request = umockdev_ioctl_client_get_request(client);
  {
    const std::lock_guard lock(self->mutex_);
    if (!self->plugged_) {
      reply(client, -1, EIO);
      return TRUE;
    }
    if (request == TIOCSBRK || request == TIOCCBRK) {
      const auto value = static_cast<std::uint16_t>(kLineData | (request == TIOCSBRK ? kBreakBit : 0));
      (void)self->model_.control({kVendorOut, kSetLineData, value, 0, 0}, {});
      self->changed_.notify_all();
      reply(client, 0);
      return TRUE;
    }
    if (request == TIOCSERGETLSR) {
      constexpr std::uint8_t kEmpty = 0x40;
      const auto status = self->model_.control({kVendorIn, kModemStatus, 0, 0, 2}, {});
      *Argument<unsigned>(argument) = status && ((*status)[1] & kEmpty) != 0 ? TIOCSER_TEMT : 0u;
      reply(client, 0);
      return TRUE;
    }
    if (request == TCSETS2) {
      const Argument<termios2> line(argument);
      self->baud_ = line->c_ospeed;
      self->two_stop_bits_ = (line->c_cflag & CSTOPB) != 0;
    }
  }
  int error = 0;
  const int result = umockdev_ioctl_client_execute(client, &error, nullptr);  // the pseudo-terminal answers
  reply(client, result, error);
  return TRUE;
}

}  // namespace footlight::testing

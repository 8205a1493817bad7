// An independent FTDI chip: QEMU's FT232BM on its UHCI controller. The far end of its wire, a port of this guest, has
// the model of a widget.
#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include "drivers/mock/enttec_pro_model.h"
#include "tests/kernel/device_run.h"
#include "tests/kernel/guest.h"

namespace footlight::testing {
namespace {

class FarEnd {
 public:
  FarEnd()
      : fd_(::open("/dev/virtio-ports/wire", O_RDWR | O_NONBLOCK | O_CLOEXEC)), stop_fd_(::eventfd(0, EFD_CLOEXEC)) {
    REQUIRE(fd_ >= 0);
    model.power_on();
    thread_ = std::thread([this] { serve(); });
  }
  ~FarEnd() {
    const std::uint64_t one = 1;
    (void)!::write(stop_fd_, &one, sizeof one);
    thread_.join();
    ::close(fd_);
    ::close(stop_fd_);
  }
  FarEnd(const FarEnd&) = delete;
  FarEnd& operator=(const FarEnd&) = delete;

  template <class F>
  bool wait_for(F&& f, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, patience, f);
  }

  drivers::mock::EnttecProModel model;  // guarded by mutex_

 private:
  void serve() {
    while (true) {
      pollfd fds[2] = {{fd_, POLLIN, 0}, {stop_fd_, POLLIN, 0}};
      ::poll(fds, 2, -1);
      if (fds[1].revents != 0) return;
      std::uint8_t bytes[4096];
      const ssize_t size = ::read(fd_, bytes, sizeof bytes);
      if (size <= 0) continue;
      const std::lock_guard lock(mutex_);
      model.take({bytes, static_cast<std::size_t>(size)});
      const auto answer = model.read(sizeof bytes);
      (void)!::write(fd_, answer.data(), answer.size());
      changed_.notify_all();
    }
  }

  const int fd_, stop_fd_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;
};

// Loads the controller's driver while a test needs it; this guest does not load it automatically.
class Uhci {
 public:
  Uhci() { must_shell("modprobe uhci-hcd"); }
  ~Uhci() { shell("rmmod uhci-hcd"); }
  Uhci(const Uhci&) = delete;
  Uhci& operator=(const Uhci&) = delete;
  // Removes the whole bus and adds it again, as a replug.
  void replug() {
    const std::string driver = "/sys/bus/pci/drivers/uhci_hcd";
    const std::string address = must_shell("cd " + driver + " && echo 0000:*");
    must_shell("echo " + address.substr(0, address.find('\n')) + " > " + driver + "/unbind");
    must_shell("echo " + address.substr(0, address.find('\n')) + " > " + driver + "/bind");
  }
  [[nodiscard]] static std::string port() {
    std::string found;
    const bool there = eventually([&] {
      for (const auto& entry : std::filesystem::directory_iterator("/sys/bus/usb/devices")) {
        std::string product;
        std::ifstream file(entry.path() / "product");
        std::getline(file, product);
        if (product == "QEMU USB SERIAL") found = entry.path().filename();
      }
      return !found.empty();
    });
    REQUIRE(there);
    return found;
  }
};

TEST_CASE("a widget behind QEMU's FT232BM is driven through its tty by a member of dialout") {
  set_up_well();
  set_groups({"dialout"});
  const Uhci uhci;
  FarEnd far_end;
  const std::string port = Uhci::port();
  REQUIRE(eventually([&] { return kernel_driver(port) == "ftdi_sio"; }));
  must_shell("udevadm settle");
  DeviceRun run("enttec-pro:port-" + port);
  for (const std::size_t which : {7u, 200u}) CHECK(run.shows(far_end, far_end.model, some_snapshot(which)));
  CHECK(kernel_driver(port) == "ftdi_sio");
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
}

TEST_CASE("with the advised rule QEMU's FT232BM is opened through libusb, and again after each of 10 replugs") {
  set_up_well();
  Uhci uhci;
  FarEnd far_end;
  const std::string port = Uhci::port();
  REQUIRE(eventually([&] { return kernel_driver(port) == "ftdi_sio"; }));
  set_groups({"plugdev"});
  const Json device = device_at(port);
  CAPTURE(device.dump());
  must_shell(device.at("remedy"));
  set_groups({"plugdev", "dialout"});  // the user may open both paths
  must_shell("udevadm settle");
  DeviceRun run("enttec-pro:port-" + port);
  for (std::size_t i = 0; i <= 10; ++i) {
    CAPTURE(i);
    if (i > 0) uhci.replug();
    REQUIRE(run.shows(far_end, far_end.model, some_snapshot(i)));
    CHECK(kernel_driver(Uhci::port()) == "usbfs");
  }
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
  CHECK(eventually([&] { return kernel_driver(port) == "ftdi_sio"; }));
}

}  // namespace
}  // namespace footlight::testing

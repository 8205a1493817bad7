// Every driver that has a model, on the kernel's own USB stack: found, opened, fed, unplugged and plugged in again.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "drivers/driver.h"
#include "tests/kernel/device_run.h"
#include "tests/kernel/guest.h"
#include "tests/kernel/vhci_socket.h"

namespace footlight::testing {
namespace {

using drivers::DriverInfo;

// The endpoint; the driver's id for a device that the user must name.
std::string endpoint_of(const DriverInfo& driver, const Json& device) {
  const std::string endpoint = device.at("endpoint");
  return endpoint.empty() ? fmt::format("{}:port-{}", driver.id, device.at("port").get<std::string>()) : endpoint;
}

template <class Test>
void for_every_driver(Test&& test) {
  set_up_well();
  for (const DriverInfo* driver : drivers::drivers()) {
    if (driver->make_model == nullptr) continue;
    CAPTURE(driver->id);
    const auto model = driver->make_model();
    VhciSocket socket(*model);
    socket.plug();
    const std::string port = socket.port_path();
    test(*driver, *model, socket, device_at(port));
    CHECK(kernel_driver(port) != "usbfs");
    socket.unplug();
  }
}

TEST_CASE("every driver's model is listed by a stock kernel, as ready or as a device that the user must name") {
  for_every_driver([](const DriverInfo& driver, const auto&, VhciSocket&, const Json& device) {
    CAPTURE(device.dump());
    const bool is_named = device.at("readiness") == "not-dmx";
    if (!is_named) CHECK(device.at("driver") == std::string(driver.id));
    CHECK((is_named || device.at("readiness") == "ready"));
  });
}

TEST_CASE("every driver's frame reaches its model with start code 0 and 512 slots through a stock kernel") {
  for_every_driver([](const DriverInfo& driver, const auto& model, VhciSocket& socket, const Json& device) {
    DeviceRun run(endpoint_of(driver, device));
    for (const std::size_t which : {7u, 200u, 13u}) CHECK(run.shows(socket, model, some_snapshot(which)));
    run.program().signal(SIGTERM);
    CHECK(run.program().wait().exit_code == 0);
  });
}

// Models of drivers, each in its own socket, for one program that drives them all.
class Devices {
 public:
  explicit Devices(std::span<const DriverInfo* const> its) {
    for (const DriverInfo* driver : its) {
      Device& device = devices_.emplace_back();
      device.driver = driver;
      device.model = driver->make_model();
      device.socket = std::make_unique<VhciSocket>(*device.model, static_cast<int>(devices_.size()) - 1);
    }
    plug();
    for (Device& device : devices_) device.port = device.socket->port_path();
  }

  [[nodiscard]] std::string endpoint_of_first() const { return endpoint_at(0); }
  // The options of a DeviceRun that add all devices but the first.
  [[nodiscard]] std::vector<std::string> outs_of_others() const {
    std::vector<std::string> words;
    for (std::size_t i = 1; i < devices_.size(); ++i) words.insert(words.end(), {"--out", endpoint_at(i)});
    return words;
  }

  void plug() {
    for (Device& device : devices_) {
      device.plugged = std::chrono::steady_clock::now();
      device.is_due = true;
      device.socket->plug();
    }
  }
  void unplug() {
    for (Device& device : devices_) device.socket->unplug();
  }

  // Sends the snapshot twice a second until all devices show it. Fails the test if no further device shows it within
  // kPatience.
  void show(DeviceRun& run, const Snapshot& snapshot) {
    using Clock = std::chrono::steady_clock;
    const Snapshot frame = line_frame_of(snapshot);
    Clock::time_point give_up = Clock::now() + kPatience;
    Clock::time_point send_at = Clock::now();
    for (std::size_t left = devices_.size(); left > 0;) {
      if (Clock::now() >= give_up) fail(run);
      if (Clock::now() >= send_at) {
        run.send(snapshot);
        (void)run.program().has_printed("", 0);  // reads the program's output, so that its pipe does not fill up
        send_at = Clock::now() + std::chrono::milliseconds(500);
      }
      for (Device& device : devices_) {
        if (!device.is_due || !device.shows(frame)) continue;
        device.is_due = false;
        device.times_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - device.plugged).count());
        give_up = Clock::now() + kPatience;
        --left;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  void report() {
    for (Device& device : devices_) {
      std::vector<double> times_ms(device.times_ms.begin() + 1, device.times_ms.end());  // the first is not a replug
      std::sort(times_ms.begin(), times_ms.end());
      std::printf("%12s: %zu replugs, plugged to shown: %.0f ms in the middle, %.0f ms at most\n",
                  std::string(device.driver->id).c_str(), times_ms.size(), times_ms[times_ms.size() / 2],
                  times_ms.back());
    }
  }
  void check_left_to_kernel() const {
    for (const Device& device : devices_) {
      CAPTURE(device.driver->id);
      CHECK(kernel_driver(device.port) != "usbfs");
    }
  }

 private:
  struct Device {
    const DriverInfo* driver = nullptr;
    std::unique_ptr<drivers::mock::UsbModel> model;
    std::unique_ptr<VhciSocket> socket;
    std::string port;
    std::chrono::steady_clock::time_point plugged;
    bool is_due = false;  // it has not shown the snapshot since it was plugged in
    std::vector<double> times_ms;

    bool shows(const Snapshot& frame) {
      return socket->wait_for([&] { return model->line(0).frame == frame; }, std::chrono::milliseconds(0));
    }
  };

  [[nodiscard]] std::string endpoint_at(std::size_t i) const {
    return endpoint_of(*devices_[i].driver, device_at(devices_[i].port));
  }

  void fail(DeviceRun& run) {
    std::string late;
    for (const Device& device : devices_)
      if (device.is_due) late += fmt::format(" {}", device.driver->id);
    MESSAGE("do not show the snapshot:" << late);
    run.fail();
  }

  std::vector<Device> devices_;
};

// Devices of one program that are replugged at the same time. More would take longer than one after the other: the
// program searches for each lost one whenever any device arrives, and the emulated processor is slow.
constexpr std::size_t kAtOnce = 2;

void replug(std::span<const DriverInfo* const> its) {
  constexpr std::size_t kReplugs = 50;
  set_up_well();
  Devices devices(its);
  DeviceRun run(devices.endpoint_of_first(), devices.outs_of_others());
  devices.show(run, some_snapshot(0));
  for (std::size_t i = 1; i <= kReplugs; ++i) {
    CAPTURE(i);
    devices.unplug();
    run.send(some_snapshot(i));
    devices.plug();
    devices.show(run, some_snapshot(i));
    if (i % 10 != 0) continue;
    std::printf("                %zu of %zu replugs\n", i, kReplugs);  // shows the host that the guest is alive
    std::fflush(stdout);
  }
  devices.report();
  std::fflush(stdout);
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
  devices.check_left_to_kernel();
}

TEST_CASE("every driver shows the newest snapshot after each of 50 replugs") {
  std::vector<const DriverInfo*> with_model;
  for (const DriverInfo* driver : drivers::drivers())
    if (driver->make_model != nullptr) with_model.push_back(driver);
  for (std::size_t i = 0; i < with_model.size(); i += kAtOnce)
    replug(std::span(with_model).subspan(i, std::min(kAtOnce, with_model.size() - i)));
}

}  // namespace
}  // namespace footlight::testing

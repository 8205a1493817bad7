// Every driver that has a model, on the kernel's own USB stack: found, opened, fed, unplugged and plugged in again.
#include <algorithm>
#include <chrono>
#include <csignal>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "drivers/driver.h"
#include "tests/kernel/device_run.h"
#include "tests/kernel/guest.h"
#include "tests/kernel/vhci_socket.h"

namespace footlight::testing {
namespace {

using drivers::DriverInfo;

// The driver's own name for a device that the user has to name.
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

TEST_CASE("every driver's model is listed by a stock kernel, as ready or as a device to be named") {
  for_every_driver([](const DriverInfo& driver, const auto&, VhciSocket&, const Json& device) {
    CAPTURE(device.dump());
    const bool is_named = device.at("readiness") == "not-dmx";
    if (!is_named) CHECK(device.at("driver") == std::string(driver.id));
    CHECK((is_named || device.at("readiness") == "ready"));
  });
}

TEST_CASE("every driver's look reaches its model with start code 0 and 512 slots through a stock kernel") {
  for_every_driver([](const DriverInfo& driver, const auto& model, VhciSocket& socket, const Json& device) {
    DeviceRun run(endpoint_of(driver, device));
    for (const std::size_t which : {7u, 200u, 13u}) CHECK(run.shows(socket, model, some_look(which)));
    run.program().signal(SIGTERM);
    CHECK(run.program().wait().exit_code == 0);
  });
}

TEST_CASE("every driver shows the newest look after each of 50 replugs") {
  constexpr std::size_t kReplugs = 50;
  for_every_driver([&](const DriverInfo& driver, const auto& model, VhciSocket& socket, const Json& device) {
    DeviceRun run(endpoint_of(driver, device));
    REQUIRE(run.shows(socket, model, some_look(0)));
    std::vector<double> times_ms;
    for (std::size_t i = 1; i <= kReplugs; ++i) {
      socket.unplug();
      run.send(some_look(i));
      const auto plugged = std::chrono::steady_clock::now();
      socket.plug();
      CAPTURE(i);
      REQUIRE(run.shows(socket, model, some_look(i)));
      times_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - plugged).count());
    }
    std::sort(times_ms.begin(), times_ms.end());
    MESSAGE(fmt::format("{}: {} replugs, plugged to shown: {:.0f} ms in the middle, {:.0f} ms at most", driver.id,
                        kReplugs, times_ms[kReplugs / 2], times_ms.back()));
    run.program().signal(SIGTERM);
    CHECK(run.program().wait().exit_code == 0);
  });
}

}  // namespace
}  // namespace footlight::testing

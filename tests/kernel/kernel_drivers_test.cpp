// Drivers of the kernel that sit on a device: what happens to them while the program uses it, and afterwards.
#include <csignal>
#include <filesystem>

#include <doctest/doctest.h>

#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/nodle_model.h"
#include "drivers/mock/velleman_model.h"
#include "tests/kernel/device_run.h"
#include "tests/kernel/guest.h"
#include "tests/kernel/vhci_socket.h"

namespace footlight::testing {
namespace {

bool becomes_driven_by(const std::string& port, const std::string& driver) {
  return eventually([&] { return kernel_driver(port) == driver; });
}

TEST_CASE("ftdi_sio is detached from a widget in use, and bound to it again after SIGTERM") {
  set_up_well();
  drivers::mock::EnttecProModel model;
  VhciSocket socket(model);
  socket.plug();
  const std::string port = socket.port_path();
  REQUIRE(becomes_driven_by(port, "ftdi_sio"));
  DeviceRun run(device_at(port).at("endpoint"));
  REQUIRE(run.shows(socket, model, some_snapshot(1)));
  CHECK(kernel_driver(port) == "usbfs");
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
  CHECK(becomes_driven_by(port, "ftdi_sio"));
  CHECK(eventually([] { return std::filesystem::exists("/dev/ttyUSB0"); }));
  CHECK(doctor_check("ftdi-sio").at("verdict") == "ok");
}

TEST_CASE("after SIGKILL doctor says that ftdi_sio is not bound, and the advised command binds it") {
  set_up_well();
  drivers::mock::EnttecProModel model;
  VhciSocket socket(model);
  socket.plug();
  const std::string port = socket.port_path();
  REQUIRE(becomes_driven_by(port, "ftdi_sio"));
  {
    DeviceRun run(device_at(port).at("endpoint"));
    REQUIRE(run.shows(socket, model, some_snapshot(1)));
    run.program().signal(SIGKILL);
    run.program().wait();
  }
  REQUIRE(becomes_driven_by(port, ""));
  const Json check = doctor_check("ftdi-sio");
  CAPTURE(check.dump());
  CHECK(check.at("verdict") == "warn");
  const Json device = device_at(port);
  CHECK(device.at("readiness") == "ready");
  const std::string rebind = device.value("rebind", "");
  REQUIRE_FALSE(rebind.empty());
  CHECK(check.at("mend").get<std::string>().find(rebind) == 0);
  must_shell(rebind);
  CHECK(becomes_driven_by(port, "ftdi_sio"));
  CHECK(doctor_check("ftdi-sio").at("verdict") == "ok");
}

TEST_CASE("a widget that SIGKILL left without ftdi_sio is driven by the next start, which binds ftdi_sio again") {
  set_up_well();
  drivers::mock::EnttecProModel model;
  VhciSocket socket(model);
  socket.plug();
  const std::string port = socket.port_path();
  const std::string endpoint = device_at(port).at("endpoint");
  {
    DeviceRun run(endpoint);
    REQUIRE(run.shows(socket, model, some_snapshot(1)));
    run.program().signal(SIGKILL);
    run.program().wait();
  }
  DeviceRun run(endpoint);
  CHECK(run.shows(socket, model, some_snapshot(2)));
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
  CHECK(becomes_driven_by(port, "ftdi_sio"));
}

// hid-quirks keeps usbhid away from it. vmk80xx has its ids, and takes it or refuses it depending on the kernel.
TEST_CASE("a stock kernel gives a Velleman K8062 no hidraw node, and the program drives it through libusb") {
  set_up_well();
  drivers::mock::VellemanModel model;
  VhciSocket socket(model);
  socket.plug();
  const std::string port = socket.port_path();
  const Json device = device_at(port);
  CAPTURE(device.dump());
  CHECK(device.at("readiness") == "ready");
  CHECK(device.at("transport") == "libusb");
  const std::string before = kernel_driver(port);
  CHECK(before != "usbhid");
  DeviceRun run(device.at("endpoint"));
  CHECK(run.shows(socket, model, some_snapshot(1)));
  CHECK(kernel_driver(port) == "usbfs");
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
  CHECK(becomes_driven_by(port, before));
}

TEST_CASE("a Nodle is driven through the kernel's hidraw, by a member of plugdev") {
  set_up_well();
  set_groups({"plugdev"});
  drivers::mock::NodleModel model;
  VhciSocket socket(model);
  socket.plug();
  const std::string port = socket.port_path();
  REQUIRE(becomes_driven_by(port, "usbhid"));
  const Json device = device_at(port);
  CAPTURE(device.dump());
  CHECK(device.at("transport") == "hidraw");
  DeviceRun run(device.at("endpoint"));
  CHECK(run.shows(socket, model, some_snapshot(1)));
  CHECK(kernel_driver(port) == "usbhid");
  CHECK(model.broken_count == 0);
}

}  // namespace
}  // namespace footlight::testing

// Kernel drivers of a device: what happens to them while the program uses it, and afterwards.
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/nodle_model.h"
#include "drivers/mock/velleman_model.h"
#include "tests/kernel/device_run.h"
#include "tests/kernel/guest.h"
#include "tests/kernel/vhci_socket.h"

namespace footlight::testing {
namespace {

// A device that is plugged in where everything is set up well; its user is in these groups, none: plugdev and dialout.
template <class Model>
struct PluggedIn {
  explicit PluggedIn(const std::vector<std::string>& groups = {}) {
    set_up_well();
    if (!groups.empty()) set_groups(groups);
    socket.plug();
    port = socket.port_path();
  }
  [[nodiscard]] bool becomes_driven_by(const std::string& driver) const {
    return eventually([&] { return kernel_driver(port) == driver; });
  }
  // The program drives it and is killed.
  void use_and_kill() {
    DeviceRun run(device_at(port).at("endpoint"));
    REQUIRE(run.shows(socket, model, some_snapshot(1)));
    run.program().signal(SIGKILL);
    run.program().wait();
  }

  Model model;
  VhciSocket socket{model};
  std::string port;
};
using Widget = PluggedIn<drivers::mock::EnttecProModel>;

TEST_CASE("ftdi_sio is detached from a widget in use, and bound to it again after SIGTERM") {
  Widget widget;
  REQUIRE(widget.becomes_driven_by("ftdi_sio"));
  DeviceRun run(device_at(widget.port).at("endpoint"));
  REQUIRE(run.shows(widget.socket, widget.model, some_snapshot(1)));
  CHECK(kernel_driver(widget.port) == "usbfs");
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
  CHECK(widget.becomes_driven_by("ftdi_sio"));
  CHECK(eventually([] { return std::filesystem::exists("/dev/ttyUSB0"); }));
  CHECK(doctor_check("ftdi-sio").at("verdict") == "ok");
}

TEST_CASE("after SIGKILL doctor reports that ftdi_sio is not bound, and the advised command binds it") {
  Widget widget;
  REQUIRE(widget.becomes_driven_by("ftdi_sio"));
  widget.use_and_kill();
  REQUIRE(widget.becomes_driven_by(""));
  const Json check = doctor_check("ftdi-sio");
  CAPTURE(check.dump());
  CHECK(check.at("verdict") == "warn");
  const Json device = device_at(widget.port);
  CHECK(device.at("readiness") == "ready");
  const std::string rebind = device.value("rebind", "");
  REQUIRE_FALSE(rebind.empty());
  CHECK(check.at("fix").get<std::string>().find(rebind) == 0);
  must_shell(rebind);
  CHECK(widget.becomes_driven_by("ftdi_sio"));
  CHECK(doctor_check("ftdi-sio").at("verdict") == "ok");
}

TEST_CASE("a widget that SIGKILL left without ftdi_sio is driven by the next start, which binds ftdi_sio again") {
  Widget widget;
  const std::string endpoint = device_at(widget.port).at("endpoint");
  widget.use_and_kill();
  DeviceRun run(endpoint);
  CHECK(run.shows(widget.socket, widget.model, some_snapshot(2)));
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
  CHECK(widget.becomes_driven_by("ftdi_sio"));
}

// hid-quirks keeps usbhid away from it. vmk80xx has its ids, and accepts or refuses it depending on the kernel.
TEST_CASE("a stock kernel gives a Velleman K8062 no hidraw node, and the program drives it through libusb") {
  PluggedIn<drivers::mock::VellemanModel> widget;
  const Json device = device_at(widget.port);
  CAPTURE(device.dump());
  CHECK(device.at("readiness") == "ready");
  CHECK(device.at("transport") == "libusb");
  const std::string before = kernel_driver(widget.port);
  CHECK(before != "usbhid");
  DeviceRun run(device.at("endpoint"));
  CHECK(run.shows(widget.socket, widget.model, some_snapshot(1)));
  CHECK(kernel_driver(widget.port) == "usbfs");
  run.program().signal(SIGTERM);
  CHECK(run.program().wait().exit_code == 0);
  CHECK(widget.becomes_driven_by(before));
}

TEST_CASE("a Nodle is driven through the kernel's hidraw, by a member of plugdev") {
  PluggedIn<drivers::mock::NodleModel> widget({"plugdev"});
  REQUIRE(widget.becomes_driven_by("usbhid"));
  const Json device = device_at(widget.port);
  CAPTURE(device.dump());
  CHECK(device.at("transport") == "hidraw");
  DeviceRun run(device.at("endpoint"));
  CHECK(run.shows(widget.socket, widget.model, some_snapshot(1)));
  CHECK(kernel_driver(widget.port) == "usbhid");
  CHECK(widget.model.broken_count == 0);
}

}  // namespace
}  // namespace footlight::testing

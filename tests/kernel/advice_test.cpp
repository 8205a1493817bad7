// The advice of `footlight devices` and `footlight doctor` for a user who cannot open a device. The tests run the
// advised commands as printed; then the device must be ready.
#include <memory>

#include <doctest/doctest.h>

#include "drivers/driver.h"
#include "tests/kernel/device_run.h"
#include "tests/kernel/guest.h"
#include "tests/kernel/vhci_socket.h"

namespace footlight::testing {
namespace {

// A driver's model, plugged in.
struct Plugged {
  explicit Plugged(std::string_view driver_id) : model(drivers::find_driver(driver_id)->make_model()), socket(*model) {
    socket.plug();
    port = socket.port_path();
  }
  const std::unique_ptr<drivers::mock::UsbModel> model;
  VhciSocket socket;
  std::string port;
};

bool contains(const Json& json, const char* key, const std::string& part) {
  return json.at(key).get<std::string>().find(part) != std::string::npos;
}

// One with a tty as well, one that only libusb opens, one of the HID class.
constexpr const char* kDrivers[] = {"enttec-pro", "eurolite-pro", "nodle"};

TEST_CASE("without udev rules the advice is to install them, and following it makes the device ready") {
  for (const char* const driver : kDrivers) {
    CAPTURE(driver);
    set_up_well();
    set_groups({});
    remove_rules();
    const Plugged plugged(driver);
    const Json device = device_at(plugged.port);
    CAPTURE(device.dump());
    CHECK(device.at("readiness") == "no-permission");
    CHECK(contains(device, "remedy", "udev/70-footlight.rules"));
    const Json rules = doctor_check("udev-rules");
    CHECK(rules.at("verdict") == "warn");
    CHECK(rules.at("fix") == device.at("remedy"));
    CHECK(doctor_check("devices").at("verdict") == "fail");
    follow_advice(plugged.port);
    CHECK(doctor_check("udev-rules").at("verdict") == "ok");
    CHECK(doctor_check("devices").at("verdict") == "ok");
  }
}

TEST_CASE("a user outside plugdev is advised to join the group, not to install current rules again") {
  for (const char* const driver : kDrivers) {
    CAPTURE(driver);
    set_up_well();
    set_groups({});
    const Plugged plugged(driver);
    const Json device = device_at(plugged.port);
    CAPTURE(device.dump());
    CHECK(device.at("readiness") == "no-permission");
    CHECK(contains(device, "remedy", "usermod -aG plugdev"));
    CHECK(doctor_check("udev-rules").at("verdict") == "ok");
    CHECK(contains(doctor_check("devices"), "fix", "usermod -aG plugdev"));
    follow_advice(plugged.port);
  }
}

TEST_CASE("a member of plugdev alone has every known device ready, and no warning about groups") {
  for (const char* const driver : kDrivers) {
    CAPTURE(driver);
    set_up_well();
    set_groups({"plugdev"});
    const Plugged plugged(driver);
    CHECK(device_at(plugged.port).at("readiness") == "ready");
    const Json groups = doctor_check("groups");
    CAPTURE(groups.dump());
    CHECK(groups.at("verdict") == "ok");
    CHECK(doctor_check("gpio").at("verdict") != "warn");  // the chip of ftdi_sio's spare pins
  }
}

TEST_CASE("on a machine without the group plugdev the advised command creates it and makes the device ready") {
  for (const char* const driver : kDrivers) {
    CAPTURE(driver);
    set_up_well();
    must_shell("sed -i /^plugdev:/d /etc/group; systemctl restart systemd-udevd");  // udevd caches groups
    set_groups({});
    const Plugged plugged(driver);
    const Json device = device_at(plugged.port);
    CAPTURE(device.dump());
    CHECK(device.at("readiness") == "no-permission");
    CHECK(contains(device, "remedy", "groupadd"));
    follow_advice(plugged.port);
  }
}

TEST_CASE("the reason of a device without its module names the module, loading it makes the device ready") {
  const std::pair<const char*, const char*> cases[] = {{"dmx4all", "cdc_acm"}, {"nodle", "usbhid"}};
  for (const auto& [driver, module] : cases) {
    CAPTURE(driver);
    set_up_well();
    take_module_away(module);
    const Plugged plugged(driver);
    const Json device = device_at(plugged.port);
    CAPTURE(device.dump());
    CHECK(device.at("readiness") == "no-node");
    CHECK(device.at("remedy") == std::string("sudo modprobe ") + module);
    CHECK(contains(doctor_check("devices"), "fix", module));
    follow_advice(plugged.port);
    give_module_back(module);
  }
}

TEST_CASE("without ftdi_sio a widget is ready and driven, since libusb needs no kernel driver") {
  set_up_well();
  take_module_away("ftdi_sio");
  Plugged plugged("enttec-pro");
  CHECK(kernel_driver(plugged.port).empty());
  const Json device = device_at(plugged.port);
  CHECK(device.at("readiness") == "ready");
  CHECK(device.value("rebind", "") == "");
  DeviceRun run(device.at("endpoint"));
  CHECK(run.shows(plugged.socket, *plugged.model, some_snapshot(1)));
  give_module_back("ftdi_sio");
}

TEST_CASE("the advice for a bare FTDI cable, which the rules exclude, is its own rule, which opens it") {
  set_up_well();
  set_groups({"plugdev"});
  Plugged plugged("open-dmx");
  const Json device = device_at(plugged.port);
  CAPTURE(device.dump());
  CHECK(device.at("readiness") == "not-dmx");
  CHECK_FALSE(contains(device, "remedy", "70-footlight.rules"));
  must_shell(device.at("remedy"));
  CHECK(device_at(plugged.port).at("remedy") == "");
  DeviceRun run("open-dmx:port-" + plugged.port);
  CHECK(run.shows(plugged.socket, *plugged.model, some_snapshot(1)));
}

}  // namespace
}  // namespace footlight::testing

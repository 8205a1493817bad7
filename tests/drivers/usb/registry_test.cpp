// The list of plugged-in devices, read from folders laid out like /sys, /dev and /proc; and the files generated from
// the driver table.
#include "drivers/registry.h"

#include <doctest/doctest.h>

#include <stdlib.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include <fmt/format.h>

#include "drivers/device/chooser.h"
#include "drivers/ports_factory.h"
#include "drivers/udev_rules.h"
#include "drivers/usb_match.h"
#include "sim/system_clock.h"
#include "tests/support/temp_folder.h"

namespace footlight::drivers {
namespace {

namespace fs = std::filesystem;

class Machine {
 public:
  Machine() {
    fs::create_directories(devices());
    fs::create_directories(root_ / "proc");
  }

  struct Device {
    std::string port_path = "1-2.3";
    std::string vendor = "0403", product_id = "6001";
    std::string manufacturer = "ENTTEC", product = "DMX USB PRO", serial = "EN172589";
    int bus = 1, number = 4;
    std::string kernel_driver = "ftdi_sio", tty = {};
    bool has_node = true;
  };
  void plug(const Device& device) {
    const fs::path folder = devices() / device.port_path;
    write(folder / "idVendor", device.vendor);
    write(folder / "idProduct", device.product_id);
    write(folder / "busnum", std::to_string(device.bus));
    write(folder / "devnum", std::to_string(device.number));
    if (!device.manufacturer.empty()) write(folder / "manufacturer", device.manufacturer);
    if (!device.product.empty()) write(folder / "product", device.product);
    if (!device.serial.empty()) write(folder / "serial", device.serial);
    const fs::path interface = folder / (device.port_path + ":1.0");
    fs::create_directories(interface);
    if (!device.kernel_driver.empty())
      fs::create_symlink("../../../../bus/usb/drivers/" + device.kernel_driver, interface / "driver");
    if (!device.tty.empty()) fs::create_directories(interface / device.tty);
    if (device.has_node) write(node(device), "");
  }
  void unplug(const Device& device) { fs::remove_all(devices() / device.port_path); }
  // A process that has a file open.
  void run(int process, const std::string& name, const std::string& open_file) {
    const fs::path folder = root_ / "proc" / std::to_string(process);
    fs::create_directories(folder / "fd");
    write(folder / "comm", name);
    fs::create_symlink(open_file, folder / "fd" / "7");
  }
  fs::path node(const Device& device) const {
    return root_ / "dev" / fmt::format("bus/usb/{:03}/{:03}", device.bus, device.number);
  }
  std::string dev(const std::string& name) const { return (root_ / "dev" / name).string(); }
  DeviceList find() const { return find_devices(options()); }
  FindOptions options() const {
    return {.sys_root = (root_ / "sys").string(),
            .dev_root = (root_ / "dev").string(),
            .proc_root = (root_ / "proc").string(),
            .etc_root = (root_ / "etc").string(),
            .lib_roots = {(root_ / "lib").string()},
            .groups = std::vector<std::string>{"anna"},
            .user_name = "anna"};
  }
  void install_rules() const { write(root_ / "etc/udev/rules.d/70-footlight.rules", udev_rules_text(), ""); }
  void load_ftdi_sio() const { fs::create_directories(root_ / "sys/bus/usb/drivers/ftdi_sio"); }

 private:
  fs::path devices() const { return root_ / "sys/bus/usb/devices"; }
  static void write(const fs::path& path, const std::string& text, const char* end = "\n") {
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text << end;
  }
  testing::TempFolder folder_;
  const fs::path root_ = folder_.path();
};

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_SUITE_BEGIN("registry");

TEST_CASE("a widget is ready if its node may be written, and its endpoint has its serial number") {
  Machine machine;
  machine.plug({});
  const DeviceList list = machine.find();
  REQUIRE(list.devices.size() == 1);
  const FoundDevice& device = list.devices[0];
  CHECK(device.driver_id == "enttec-pro");
  CHECK(device.endpoint == "enttec-pro:EN172589");
  CHECK(device.port_path == "1-2.3");
  CHECK(device.usb_vendor == 0x0403);
  CHECK(device.kernel_driver == "ftdi_sio");
  CHECK((device.capabilities & kCanInput) != 0);
  if (!built_with_usb()) return;
  CHECK(device.readiness == Readiness::kReady);  // ftdi_sio is detached on opening
  CHECK(device.reason.empty());
  CHECK(list.notes.empty() == built_with_hid());
}

TEST_CASE("a device without a serial number, or with another's, is named by its port") {
  Machine machine;
  machine.plug({.port_path = "1-1", .serial = "", .number = 2});
  machine.plug({.port_path = "1-3", .serial = "CLONE", .number = 3});
  machine.plug({.port_path = "1-4", .serial = "CLONE", .number = 5});
  const DeviceList list = machine.find();
  REQUIRE(list.devices.size() == 3);
  CHECK(list.devices[0].endpoint == "enttec-pro:port-1-1");
  CHECK(list.devices[1].endpoint == "enttec-pro:port-1-3");
  CHECK(list.devices[2].endpoint == "enttec-pro:port-1-4");
}

TEST_CASE("models are distinguished by their strings in any case") {
  CHECK(match_usb_device(0x0403, 0x6001, "ENTTEC", "DMX USB PRO Mk2").model->model_name == "ENTTEC DMX USB Pro Mk2");
  CHECK(match_usb_device(0x0403, 0x6001, "enttec", "dmx usb pro").model->model_name == "ENTTEC DMX USB Pro");
  CHECK(match_usb_device(0x0403, 0x6001, "DMXking.com", "ultraDMX Micro").model->model_name == "DMXking ultraDMX");
  CHECK(match_usb_device(0x0403, 0x6001, "FTDI", "FT232R USB UART").driver == nullptr);
  CHECK(match_usb_device(0x0403, 0x6001, "", "").ids_are_known);
  CHECK_FALSE(match_usb_device(0x1D6B, 0x0002, "ENTTEC", "DMX USB PRO").ids_are_known);
}

TEST_CASE("a bare FTDI adapter is listed, is not called a widget, and its entry explains how to use it") {
  Machine machine;
  machine.plug({.manufacturer = "FTDI", .product = "FT232R USB UART", .serial = "A50285BI"});
  const DeviceList list = machine.find();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].model_name == "FTDI serial adapter, not known to be a DMX USB Pro");
  CHECK(list.devices[0].readiness == Readiness::kNotDmx);
  CHECK(list.devices[0].endpoint.empty());
  CHECK_FALSE(list.devices[0].reason.empty());
}

TEST_CASE("cables without identification are used only when they are named") {
  Machine machine;
  machine.plug({.port_path = "1-1", .manufacturer = "FTDI", .product = "FT232R USB UART", .serial = "A50285BI"});
  machine.plug({.port_path = "1-2", .manufacturer = "FTDI", .product = "FT232R USB UART", .serial = ""});
  machine.plug({.port_path = "1-3", .manufacturer = "FTDI", .product = "FT232R USB UART", .serial = ""});
  for (const char* driver : {"open-dmx", "eurolite-mk2", "enttec-pro"}) {
    CAPTURE(driver);
    CHECK(Chooser(driver, "", machine.options()).find().error().code == ErrorCode::kNotFound);
    const auto by_serial = Chooser(driver, "A50285BI", machine.options()).find();
    REQUIRE(by_serial);
    CHECK(by_serial->port_path == "1-1");
    const auto by_port = Chooser(driver, "port-1-3", machine.options()).find();
    REQUIRE(by_port);
    CHECK(by_port->port_path == "1-3");
  }
}

TEST_CASE("identical devices do not swap: without serial numbers, and with the same one, the socket identifies them") {
  for (const char* serial : {"", "CLONE"}) {
    CAPTURE(serial);
    Machine machine;
    const Machine::Device left{.port_path = "1-1", .serial = serial, .number = 2};
    const Machine::Device right{.port_path = "1-2", .serial = serial, .number = 3};
    machine.plug(left);
    machine.plug(right);
    Chooser to_left("enttec-pro", "port-1-1", machine.options()), to_right("enttec-pro", "port-1-2", machine.options());
    to_left.pin(*to_left.find());
    to_right.pin(*to_right.find());
    machine.unplug(left);
    CHECK_FALSE(to_left.find());  // the other is not used instead
    CHECK(to_right.find()->port_path == "1-2");
    machine.plug(left);
    CHECK(to_left.find()->port_path == "1-1");
    CHECK(to_left.identity() != to_right.identity());
  }
}

TEST_CASE("a device with a unique serial number is found again in another socket") {
  Machine machine;
  const Machine::Device here{.port_path = "1-1", .number = 2};
  Machine::Device there = here;
  there.port_path = "1-4.2";
  machine.plug(here);
  Chooser chooser("enttec-pro", "", machine.options());
  chooser.pin(*chooser.find());
  machine.unplug(here);
  machine.plug(there);
  machine.plug({.port_path = "1-1", .serial = "EN999999", .number = 4});
  REQUIRE(chooser.find());
  CHECK(chooser.find()->port_path == "1-4.2");
}

TEST_CASE("the readiness of a serial device is that of its tty, and without a tty it names what is missing") {
  Machine machine;
  machine.plug({.port_path = "1-1",
                .vendor = "1fc9",
                .product_id = "0094",
                .manufacturer = "DMXking",
                .product = "ultraDMX MAX",
                .serial = "6",
                .kernel_driver = "cdc_acm",
                .tty = "tty/ttyACM3"});
  machine.plug({.port_path = "1-2",
                .vendor = "1fc9",
                .product_id = "0094",
                .manufacturer = "DMXking",
                .product = "ultraDMX MAX",
                .serial = "7",
                .kernel_driver = ""});
  FindOptions options = machine.options();
  std::vector<std::string> queried;
  options.node_access = [&](const std::string& node) {
    queried.push_back(node);
    return 0;
  };
  const DeviceList list = find_devices(options);
  REQUIRE(list.devices.size() == 2);
  CHECK(list.devices[0].tty == machine.dev("ttyACM3"));
  CHECK(list.devices[0].transport == TransportKind::kTty);
  CHECK(list.devices[0].readiness == Readiness::kReady);
  CHECK(std::find(queried.begin(), queried.end(), machine.dev("ttyACM3")) != queried.end());
  CHECK(list.devices[1].readiness == Readiness::kNoNode);
  CHECK(list.devices[1].reason.find("tty") != std::string::npos);
}

TEST_CASE("each device lists how it would be opened now") {
  Machine machine;
  machine.plug({.port_path = "1-1", .serial = "A", .number = 2, .tty = "ttyUSB0"});
  machine.plug({.port_path = "1-2", .vendor = "10cf", .product_id = "8062", .serial = "", .number = 3});
  machine.plug({.port_path = "1-3", .vendor = "1fc9", .product_id = "0094", .serial = "6", .number = 5});
  machine.plug({.port_path = "1-4", .vendor = "16d0", .product_id = "0830", .serial = "7", .number = 6});
  machine.plug({.port_path = "1-5", .manufacturer = "FTDI", .product = "FT232R", .serial = "8", .number = 7});
  const auto ways = [&](const FindOptions& options) {
    std::vector<std::string> all;
    for (const FoundDevice& device : find_devices(options).devices)
      all.push_back(fmt::format("{} {}", device.driver_id.empty() ? "-" : kind_of(device.transport), device.way));
    return all;
  };
  if (!built_with_usb()) return;
  FindOptions options = machine.options();
  options.node_access = [](const std::string&) { return 0; };
  CHECK(ways(options) == std::vector<std::string>{"serial libusb", "usb libusb", "serial tty", "hid hidraw", "- "});
  // If this user may not open the node of the bus, a serial chip is opened by its tty; other devices have no
  // alternative.
  options.node_access = [&](const std::string& node) {
    return node.find("/bus/usb/") == std::string::npos ? 0 : EACCES;
  };
  CHECK(ways(options) == std::vector<std::string>{"serial tty", "usb libusb", "serial tty", "hid hidraw", "- "});
}

TEST_CASE("devices without a driver are not listed") {
  Machine machine;
  machine.plug({.vendor = "046d", .product_id = "c077"});
  machine.plug({.port_path = "usb1"});
  CHECK(machine.find().devices.empty());
}

TEST_CASE("a device whose attributes are missing or garbled is skipped") {
  Machine machine;
  machine.plug({.port_path = "1-1", .vendor = "04g3"});
  machine.plug({.port_path = "1-2", .vendor = ""});
  machine.plug({.port_path = "1-3"});
  CHECK(machine.find().devices.size() == 1);
}

TEST_CASE("a node that may not be written comes with the command that fixes it") {
  if (!built_with_usb()) return;
  Machine machine;
  machine.plug({});
  FindOptions options = machine.options();
  options.node_access = [](const std::string&) { return EACCES; };
  const DeviceList list = find_devices(options);
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].readiness == Readiness::kNoPermission);
  CHECK(list.devices[0].reason.find("Permission denied") != std::string::npos);
  CHECK(list.devices[0].remedy ==
        "sudo cp udev/70-footlight.rules /etc/udev/rules.d/ && sudo udevadm control --reload && sudo udevadm trigger");
  CHECK(name_of(list.devices[0].readiness) == "no-permission");
}

TEST_CASE("a user outside plugdev with current rules is advised to join it, by the list and by the port") {
  if (!built_with_usb()) return;
  Machine machine;
  machine.plug({});
  machine.install_rules();
  FindOptions options = machine.options();
  options.node_access = [](const std::string&) { return EACCES; };
  options.node_owner = [](const std::string&) { return NodeOwner{"plugdev", 0660}; };
  const DeviceList list = find_devices(options);
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].readiness == Readiness::kNoPermission);
  CHECK(list.devices[0].remedy == "sudo usermod -aG plugdev $USER");
  const auto chosen = Chooser("enttec-pro", "", options).choose();
  REQUIRE_FALSE(chosen);
  CHECK(chosen.error().message.find("run: sudo usermod -aG plugdev $USER") != std::string::npos);
}

TEST_CASE(
    "a bare cable that this user may not open is listed with its own rule, whether or not the rules are installed") {
  for (const bool installed : {false, true}) {
    Machine machine;
    machine.plug({.manufacturer = "FTDI", .product = "FT232R USB UART", .serial = "A50285BI"});
    if (installed) machine.install_rules();
    FindOptions options = machine.options();
    options.node_access = [](const std::string&) { return EACCES; };
    options.node_owner = [](const std::string&) { return NodeOwner{"root", 0664}; };
    const DeviceList list = find_devices(options);
    REQUIRE(list.devices.size() == 1);
    CHECK(list.devices[0].readiness == Readiness::kNotDmx);
    CHECK(list.devices[0].reason.find("exclude it") != std::string::npos);
    CHECK(list.devices[0].remedy.find(R"(ATTR{serial}=="A50285BI")") != std::string::npos);
    CHECK(list.devices[0].remedy.find("udev/70-footlight.rules") == std::string::npos);
    options.node_access = [](const std::string&) { return 0; };
    CHECK(find_devices(options).devices[0].remedy.empty());
  }
}

TEST_CASE("an FTDI chip that lost its kernel driver is ready, and names the command that binds it again") {
  if (!built_with_usb()) return;
  Machine machine;
  machine.plug({.kernel_driver = ""});
  CHECK(machine.find().devices[0].rebind.empty());  // no driver to bind
  machine.load_ftdi_sio();
  const FoundDevice device = machine.find().devices[0];
  CHECK(device.readiness == Readiness::kReady);
  CHECK(device.rebind == "echo 1-2.3:1.0 | sudo tee /sys/bus/usb/drivers/ftdi_sio/bind");
  Machine bound;
  bound.load_ftdi_sio();
  bound.plug({});
  CHECK(bound.find().devices[0].rebind.empty());
}

TEST_CASE("a build without hidapi lists HID devices, and names the package that opens them") {
  Machine machine;
  machine.plug({.vendor = "16d0", .product_id = "0830"});
  const DeviceList list = machine.find();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].endpoint == "nodle:EN172589");
  if (built_with_hid()) return;
  CHECK(list.devices[0].readiness == Readiness::kUnsupported);
  CHECK(list.devices[0].remedy.find("libhidapi-dev") != std::string::npos);
  CHECK(list.notes.back().find("-DFOOTLIGHT_HID=ON") != std::string::npos);
  SystemClock clock;
  const auto sink = open_sink({.scheme = "nodle", .target = "", .universes = {1}}, clock);
  REQUIRE_FALSE(sink);
  CHECK(sink.error().code == ErrorCode::kUnsupported);
  CHECK(sink.error().message.find("libhidapi-dev") != std::string::npos);
}

TEST_CASE("a module is advised only if no kernel driver is bound") {
  if (!built_with_hid()) return;
  for (const char* kernel_driver : {"", "usbhid"}) {
    Machine machine;
    machine.plug({.vendor = "16d0", .product_id = "0830", .kernel_driver = kernel_driver});
    const FoundDevice device = machine.find().devices[0];
    CHECK(device.readiness == Readiness::kNoNode);
    CHECK(device.remedy == (*kernel_driver == 0 ? "sudo modprobe usbhid" : ""));
  }
}

TEST_CASE("a device without its node is distinguished from one without permission") {
  if (!built_with_usb()) return;
  Machine machine;
  machine.plug({.has_node = false});
  const DeviceList list = machine.find();
  REQUIRE(list.devices.size() == 1);
  CHECK(list.devices[0].readiness == Readiness::kNoNode);
  CHECK(list.devices[0].reason.find("container") != std::string::npos);
}

TEST_CASE("a busy device names the program that holds it, through usbfs or through its tty") {
  if (!built_with_usb()) return;
  Machine machine;
  const Machine::Device by_usbfs{.port_path = "1-1", .serial = "A", .number = 2, .kernel_driver = "usbfs"};
  const Machine::Device by_tty{.port_path = "1-2", .serial = "B", .number = 3, .tty = "ttyUSB0"};
  const Machine::Device by_nobody{.port_path = "1-3", .serial = "C", .number = 5, .tty = "ttyUSB1"};
  const Machine::Device by_another_user{.port_path = "1-4", .serial = "D", .number = 6, .kernel_driver = "usbfs"};
  for (const auto& device : {by_usbfs, by_tty, by_nobody, by_another_user}) machine.plug(device);
  machine.run(812, "olad", machine.node(by_usbfs).string());
  machine.run(813, "qlcplus", machine.dev("ttyUSB0"));
  const DeviceList list = machine.find();
  REQUIRE(list.devices.size() == 4);
  CHECK(list.devices[0].readiness == Readiness::kBusy);
  CHECK(list.devices[0].reason == "in use by olad (process 812)");
  CHECK(list.devices[1].readiness == Readiness::kBusy);
  CHECK(list.devices[1].reason == "in use by qlcplus (process 813)");
  CHECK(list.devices[2].readiness == Readiness::kReady);
  CHECK(list.devices[3].readiness == Readiness::kBusy);
  CHECK(list.devices[3].remedy.find("fuser -v") != std::string::npos);
}

TEST_CASE("a machine without a USB bus gets a note, not an error") {
  const DeviceList list = find_devices({.sys_root = "/nonexistent"});
  CHECK(list.devices.empty());
  REQUIRE_FALSE(list.notes.empty());
  CHECK(list.notes.back().find("/nonexistent/bus/usb/devices") != std::string::npos);
}

TEST_CASE("every driver has a unique name that is valid in an endpoint") {
  std::vector<std::string_view> ids;
  for (const DriverInfo* driver : drivers()) {
    CHECK(std::all_of(driver->id.begin(), driver->id.end(),
                      [](unsigned char c) { return std::islower(c) || std::isdigit(c) || c == '-'; }));
    CHECK(std::find(ids.begin(), ids.end(), driver->id) == ids.end());
    CHECK(find_driver(driver->id) == driver);
    CHECK((driver->make_widget != nullptr) == (driver->make_model != nullptr));  // mock:<id> works for every driver
    CHECK((driver->make_widget != nullptr) == !driver->usb_ids.empty());
    ids.push_back(driver->id);
  }
  CHECK(find_driver("nonesuch") == nullptr);
}

TEST_CASE("the committed udev rules are those of the driver table") {
  CHECK_MESSAGE(text_of(fs::path(FOOTLIGHT_SOURCE_DIR) / "udev/70-footlight.rules") == udev_rules_text(),
                "run: ninja -C build/dev list_udev_rules && build/dev/tools/list_udev_rules > udev/70-footlight.rules");
}

TEST_CASE("the committed hardware table is that of the driver table") {
  CHECK_MESSAGE(
      text_of(fs::path(FOOTLIGHT_SOURCE_DIR) / "docs/hardware.md").find(hardware_table_text()) != std::string::npos,
      "put the output of this between its markers in docs/hardware.md: build/dev/tools/list_udev_rules --hardware");
}

TEST_CASE("udev rules never open a bare serial chip, and never to all users") {
  std::istringstream rules(udev_rules_text());
  std::string line;
  int rule_count = 0;
  while (std::getline(rules, line)) {
    if (line.empty() || line[0] == '#' || line.find("IMPORT{builtin}") != std::string::npos) continue;  // opens nothing
    ++rule_count;
    CAPTURE(line);
    CHECK(line.find("TAG+=\"uaccess\"") != std::string::npos);
    CHECK(line.find("GROUP=\"plugdev\"") != std::string::npos);
    CHECK(line.find("0666") == std::string::npos);
    if (line.find("0403") != std::string::npos)
      CHECK((line.find("{manufacturer}") != std::string::npos || line.find("{product}") != std::string::npos ||
             line.find("c850") != std::string::npos));  // an id that FTDI assigned to one maker
    const std::size_t id = line.find("{idVendor}==\"");
    REQUIRE(id != std::string::npos);
    CHECK(std::none_of(line.begin() + static_cast<std::ptrdiff_t>(id),
                       line.begin() + static_cast<std::ptrdiff_t>(id + 17),
                       [](unsigned char c) { return std::isupper(c) && c != 'V'; }));
    const bool is_node =
        line.find("SUBSYSTEM==\"tty\"") != std::string::npos || line.find("SUBSYSTEM==\"hidraw\"") != std::string::npos;
    CHECK(is_node == (line.find("ATTRS{idVendor}") != std::string::npos));  // the ids are those of a parent
  }
  CHECK(rule_count >= 3);
}

TEST_CASE("udev rules open a HID interface by its hidraw node, and no other hidraw node") {
  const std::string rules = udev_rules_text();
  CHECK(rules.find(R"(SUBSYSTEM=="hidraw", ATTRS{idVendor}=="16d0", ATTRS{idProduct}=="0830")") != std::string::npos);
  std::istringstream lines(rules);
  for (std::string line; std::getline(lines, line);)
    if (line.find("hidraw\"") != std::string::npos) CHECK(line.find("ATTRS{idProduct}") != std::string::npos);
}

TEST_CASE("udev rules open a Velleman by its USB node, because no stock kernel makes a hidraw node for it") {
  const std::string rules = udev_rules_text();
  CHECK(
      rules.find(R"(SUBSYSTEM=="usb", ENV{DEVTYPE}=="usb_device", ATTR{idVendor}=="10cf", ATTR{idProduct}=="8062")") !=
      std::string::npos);
  CHECK(rules.find(R"(ATTRS{idVendor}=="10cf")") == std::string::npos);
}

TEST_CASE("a Velleman that vmk80xx holds is ready, and no module is advised") {
  if (!built_with_usb()) return;
  for (const char* kernel_driver : {"vmk80xx", "usbhid", ""}) {
    CAPTURE(kernel_driver);
    Machine machine;
    machine.plug({.vendor = "10cf", .product_id = "8062", .serial = "", .kernel_driver = kernel_driver});
    const DeviceList list = machine.find();
    REQUIRE(list.devices.size() == 1);
    CHECK(list.devices[0].readiness == Readiness::kReady);
    CHECK(list.devices[0].remedy.empty());
  }
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers

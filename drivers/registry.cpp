#include "drivers/registry.h"

#include <dirent.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <optional>

#include "drivers/open_files.h"
#include "drivers/permission.h"
#include "drivers/usb_match.h"

namespace footlight::drivers {
namespace {

// opendir() instead of std::filesystem: the emulated /sys of the tests redirects this call.
std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  DIR* dir = ::opendir(folder.c_str());
  if (dir == nullptr) return names;
  while (const dirent* entry = ::readdir(dir)) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") names.emplace_back(name);
  }
  ::closedir(dir);
  std::sort(names.begin(), names.end());
  return names;
}

bool folder_exists(const std::string& folder) {
  DIR* dir = ::opendir(folder.c_str());
  if (dir != nullptr) ::closedir(dir);
  return dir != nullptr;
}

// One attribute: the first line, without white space at its ends. Empty if there is none.
std::string attribute(const std::string& path) {
  std::string line;
  std::ifstream file(path);
  std::getline(file, line);
  constexpr const char* kSpace = " \t\r\n";
  const std::size_t first = line.find_first_not_of(kSpace);
  if (first == std::string::npos) return {};
  return line.substr(first, line.find_last_not_of(kSpace) - first + 1);
}

std::optional<int> number_of(const std::string& text, int base) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string link_target(const std::string& path) {
  char buffer[4096];
  const ssize_t size = ::readlink(path.c_str(), buffer, sizeof buffer);
  return size < 0 ? std::string{} : std::string(buffer, static_cast<std::size_t>(size));
}

std::string last_part(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

// "olad (process 812)", of the first process that has one of the nodes open; empty if none is visible to this user.
std::string holder_of(const std::string& proc_root, const std::vector<std::string>& nodes) {
  const std::string own = std::to_string(::getpid());
  for (const std::string& process : processes(proc_root)) {
    if (process == own) continue;
    for (const std::string& target : open_files(proc_root, process)) {
      if (std::find(nodes.begin(), nodes.end(), target) != nodes.end())
        return fmt::format("{} (process {})", process_name(proc_root, process), process);
    }
  }
  return {};
}

// For a device that the user must name: why this user cannot open it; empty if nothing prevents it.
Advice advice_for_nameless(const FoundDevice& device, const FindOptions& options) {
  const int error = node_access(options, device.node);
  if (error != EACCES && error != EPERM) return {};
  if (!device.tty.empty() && node_access(options, device.tty) == 0) return {};
  return advise_on_permission(device, device.node, error, options);
}

void judge(FoundDevice& device, const FindOptions& options) {
  const auto verdict = [&](Readiness readiness, std::string reason, std::string remedy = {}) {
    device.readiness = readiness;
    device.reason = std::move(reason);
    device.remedy = std::move(remedy);
  };
  std::vector<std::string> nodes{device.node};
  if (!device.tty.empty()) nodes.push_back(device.tty);
  if (!device.hidraw.empty()) nodes.push_back(device.hidraw);
  if (device.kernel_driver == "usbfs" || nodes.size() > 1) device.holder = holder_of(options.proc_root, nodes);
  if (device.driver_id.empty()) {
    const Advice advice = advice_for_nameless(device, options);
    return verdict(
        Readiness::kNotDmx,
        "its USB ids are shared by many products and its name is not that of a DMX interface; if it is one, name it by "
        "its serial number or port" +
            (advice.reason.empty() ? "" : ". " + advice.reason),
        advice.remedy);
  }
  const bool over_tty = device.transport == TransportKind::kTty;
  const bool tty_opens = !device.tty.empty() && node_access(options, device.tty) == 0;
  const bool has_other_way = device.transport == TransportKind::kFtdi && tty_opens;
  const bool libusb_opens = built_with_usb() && node_access(options, device.node) == 0;
  device.way = device.transport == TransportKind::kHid        ? "hidraw"
               : over_tty || (has_other_way && !libusb_opens) ? "tty"
                                                              : "libusb";
  if (!built_with_usb() && device.transport != TransportKind::kHid && !over_tty && !has_other_way)
    return verdict(Readiness::kUnsupported, "this build has no USB",
                   "sudo apt install libusb-1.0-0-dev && cmake -B build -DFOOTLIGHT_USB=ON && cmake --build build");
  if (!built_with_hid() && device.transport == TransportKind::kHid)
    return verdict(Readiness::kUnsupported, "this build has no HID",
                   "sudo apt install libhidapi-dev && cmake -B build -DFOOTLIGHT_HID=ON && cmake --build build");
  const std::string& node = over_tty                                  ? device.tty
                            : device.transport == TransportKind::kHid ? device.hidraw
                                                                      : device.node;
  const std::string_view kind_of_node = over_tty ? "tty" : "hidraw node";
  if (node.empty() && device.kernel_driver.empty())
    return verdict(Readiness::kNoNode, fmt::format("no kernel driver is bound to it, so it has no {}", kind_of_node),
                   fmt::format("sudo modprobe {}", over_tty ? "cdc_acm" : "usbhid"));
  if (node.empty() && device.kernel_driver != "usbfs")
    return verdict(Readiness::kNoNode, fmt::format("the kernel's driver {} makes no {} for it; see: sudo dmesg",
                                                   device.kernel_driver, kind_of_node));
  const int access_error = has_other_way || node.empty() ? 0 : node_access(options, node);
  if (access_error == ENOENT)
    return verdict(Readiness::kNoNode, fmt::format("{} does not exist; start the container with access to it", node));
  if (access_error != 0) {
    Advice advice = advise_on_permission(device, node, access_error, options);
    return verdict(Readiness::kNoPermission, std::move(advice.reason), std::move(advice.remedy));
  }
  const std::string see = fmt::format("sudo fuser -v {}", fmt::join(nodes, " "));
  if (!device.holder.empty()) return verdict(Readiness::kBusy, fmt::format("in use by {}", device.holder), see);
  if (device.kernel_driver == "usbfs") return verdict(Readiness::kBusy, "in use by another program", see);
}

constexpr std::uint16_t kFtdiVendor = 0x0403;

std::optional<FoundDevice> read_device(const std::string& name, const FindOptions& options) {
  if (name.find(':') != std::string::npos || name.starts_with("usb")) return std::nullopt;  // interfaces and root hubs
  const std::string folder = fmt::format("{}/bus/usb/devices/{}", options.sys_root, name);
  const auto vendor = number_of(attribute(folder + "/idVendor"), 16);
  const auto product = number_of(attribute(folder + "/idProduct"), 16);
  const auto bus = number_of(attribute(folder + "/busnum"), 10);
  const auto number = number_of(attribute(folder + "/devnum"), 10);
  if (!vendor || !product || !bus || !number) return std::nullopt;  // unplugged meanwhile

  FoundDevice device;
  device.usb_vendor = static_cast<std::uint16_t>(*vendor);
  device.usb_product = static_cast<std::uint16_t>(*product);
  device.usb_release = static_cast<std::uint16_t>(number_of(attribute(folder + "/bcdDevice"), 16).value_or(0));
  device.manufacturer = attribute(folder + "/manufacturer");
  device.product = attribute(folder + "/product");
  const UsbMatch match = match_usb_device(device.usb_vendor, device.usb_product, device.manufacturer, device.product);
  if (match.driver == nullptr && !match.ids_are_known) return std::nullopt;

  device.serial = attribute(folder + "/serial");
  device.port_path = name;
  device.node = fmt::format("{}/bus/usb/{:03}/{:03}", options.dev_root, *bus, *number);
  const std::string interface = fmt::format("{}/{}:1.0", folder, name);
  device.kernel_driver = last_part(link_target(interface + "/driver"));
  if (match.driver != nullptr) {
    device.driver_id = match.driver->id;
    device.model_name = match.model->model_name;
    device.capabilities = match.driver->capabilities;
    device.quirks = match.model->quirks;
    device.transport = match.model->transport;
  } else {
    device.model_name = device.usb_vendor == kFtdiVendor
                            ? "FTDI serial adapter, not known to be a DMX USB Pro"
                            : "a device whose USB ids are shared by many, not known to be a DMX interface";
  }
  // The tty of a serial converter is under its interface, the one of the communication class in its own subfolder. A
  // HID device has one more level, named after its ids.
  for (const std::string& entry : names_in(interface)) {
    if (entry.starts_with("ttyUSB")) device.tty = fmt::format("{}/{}", options.dev_root, entry);
    for (const std::string& node : names_in(fmt::format("{}/{}/hidraw", interface, entry)))
      device.hidraw = fmt::format("{}/{}", options.dev_root, node);
  }
  for (const std::string& node : names_in(interface + "/tty"))
    device.tty = fmt::format("{}/{}", options.dev_root, node);
  if (device.usb_vendor == kFtdiVendor && device.kernel_driver.empty() &&
      folder_exists(options.sys_root + "/bus/usb/drivers/ftdi_sio"))
    device.rebind = fmt::format("echo {}:1.0 | sudo tee /sys/bus/usb/drivers/ftdi_sio/bind", name);
  judge(device, options);
  return device;
}

}  // namespace

std::string_view name_of(Readiness readiness) {
  switch (readiness) {
    case Readiness::kReady: return "ready";
    case Readiness::kNoPermission: return "no-permission";
    case Readiness::kBusy: return "busy";
    case Readiness::kNoNode: return "no-node";
    case Readiness::kUnsupported: return "unsupported";
    case Readiness::kNotDmx: return "not-dmx";
  }
  return "";
}

std::string_view kind_of(TransportKind transport) {
  switch (transport) {
    case TransportKind::kFtdi:
    case TransportKind::kTty: return "serial";
    case TransportKind::kUsb: return "usb";
    case TransportKind::kHid: return "hid";
  }
  return "";
}

std::string udev_install_command() {
  return "sudo cp udev/70-footlight.rules /etc/udev/rules.d/ && sudo udevadm control --reload && sudo udevadm trigger";
}

DeviceList find_devices(const FindOptions& options) {
  DeviceList list;
  if (!built_with_usb())
    list.notes.emplace_back(
        "built without USB: devices are listed but cannot be opened; install libusb-1.0-0-dev and configure with "
        "-DFOOTLIGHT_USB=ON");
  if (!built_with_hid())
    list.notes.emplace_back(
        "built without HID: HID devices are listed and cannot be opened; install libhidapi-dev and configure with "
        "-DFOOTLIGHT_HID=ON");
  const std::string folder = options.sys_root + "/bus/usb/devices";
  if (!folder_exists(folder))
    list.notes.push_back(
        fmt::format("{} does not exist: no USB here, as in many containers and virtual machines", folder));
  for (const std::string& name : names_in(folder))
    if (auto device = read_device(name, options)) list.devices.push_back(std::move(*device));
  for (FoundDevice& device : list.devices) {
    if (device.driver_id.empty()) continue;
    const auto same_serial = [&](const FoundDevice& other) { return other.serial == device.serial; };
    const bool serial_tells =
        !device.serial.empty() && std::count_if(list.devices.begin(), list.devices.end(), same_serial) == 1;
    device.endpoint = serial_tells ? fmt::format("{}:{}", device.driver_id, device.serial)
                                   : fmt::format("{}:port-{}", device.driver_id, device.port_path);
  }
  return list;
}

}  // namespace footlight::drivers

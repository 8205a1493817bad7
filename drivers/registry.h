// What is plugged in, whether it can be used, and the command that mends it where it cannot.
//
// Reads /sys only: nothing is opened, no kernel driver is disturbed, no permission is needed. Works in builds without
// libusb and hidapi too. Takes well under the time of one video frame, so a window may call it on a timer.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/driver.h"

namespace footlight::drivers {

enum class Readiness {
  kReady,         // open_sink() or open_source() should succeed
  kNoPermission,  // this user may not write the device node
  kBusy,          // another program holds it
  kNoNode,        // the kernel knows it, but /dev/bus/usb has no node: a container without device access
  kUnsupported,   // this build cannot open it
  kNotDmx,        // listed because it has an id of the table, but nothing says that it speaks DMX
};
// "ready", "no-permission", "busy", "no-node", "unsupported", "not-dmx": stable words for JSON.
[[nodiscard]] std::string_view name_of(Readiness readiness);

struct FoundDevice {
  std::string driver_id;     // DriverInfo::id; empty for kNotDmx
  std::string model_name;    // "ENTTEC DMX USB Pro"; for kNotDmx "FTDI serial adapter, not known to be a DMX USB Pro"
  std::string manufacturer;  // as the device says it; may be empty
  std::string product;
  std::string serial;  // of the USB descriptor; may be empty or shared by clones
  std::uint16_t usb_vendor = 0;
  std::uint16_t usb_product = 0;
  std::uint16_t usb_release = 0;  // bcdDevice
  std::string port_path;          // where it is plugged in: "1-2.3"; stays the same when it is replugged there
  std::string node;               // "/dev/bus/usb/001/004"; changes when it is replugged
  std::string kernel_driver;      // bound to its first interface: "ftdi_sio", "usbfs" (a program holds it), or empty
  TransportKind transport = TransportKind::kFtdi;  // of its row; means nothing for kNotDmx
  std::string_view way;       // how it would be opened at the moment: "libusb", "tty", "hidraw"; empty for kNotDmx
  std::string tty;            // "/dev/ttyUSB0" of its first interface; empty where there is none at the moment
  std::string hidraw;         // "/dev/hidraw3", likewise
  std::string holder;         // "olad (process 812)": another program that has one of its nodes open, where visible
  std::string endpoint;       // what to write in a show file: "enttec-pro:EN172589"; empty for kNotDmx
  unsigned capabilities = 0;  // Capability
  unsigned quirks = 0;        // Quirk
  Readiness readiness = Readiness::kReady;
  std::string reason;  // for people, one sentence; empty where ready
  std::string remedy;  // a command to copy; empty where there is none
  // An FTDI chip that no driver of the kernel is bound to although ftdi_sio is loaded: a program that had taken it over
  // was killed. It opens all the same; its tty is missing. The command that binds it again; empty otherwise.
  std::string rebind;
};

// "usb", "serial", "hid": stable words for JSON.
[[nodiscard]] std::string_view kind_of(TransportKind transport);

struct DeviceList {
  std::vector<FoundDevice> devices;  // in the order of their port paths
  std::vector<std::string> notes;    // about the whole: "built without USB: ..."
};

// Who owns a node. An empty group: the node could not be examined.
struct NodeOwner {
  std::string group;
  unsigned mode = 0;  // permission bits
};

// Where to look. The defaults are the system's; tests lay out folders of their own.
struct FindOptions {
  std::string sys_root = "/sys";
  std::string dev_root = "/dev";
  std::string proc_root = "/proc";
  // 0 where the node may be read and written, else an errno value. Empty: ask the system.
  std::function<int(const std::string& node)> node_access;
  // For the advice where a node may not be opened (drivers/permission.h).
  std::string etc_root = "/etc";
  std::vector<std::string> lib_roots = {"/usr/local/lib", "/usr/lib"};  // of packages; the first with a file counts
  std::optional<std::vector<std::string>> groups = {};                  // by name; nullopt: those of this process
  std::string user_name = {};                                           // empty: the one that runs this process
  std::function<NodeOwner(const std::string& node)> node_owner = {};    // empty: ask the system
};

// As options.node_access, or as the system says: 0, or an errno value.
[[nodiscard]] inline int node_access(const FindOptions& options, const std::string& node) {
  if (options.node_access) return options.node_access(node);
  return ::access(node.c_str(), R_OK | W_OK) == 0 ? 0 : errno;
}

[[nodiscard]] DeviceList find_devices(const FindOptions& options = {});

// True where libusb was there at build time.
[[nodiscard]] bool built_with_usb();
// True where hidapi was there at build time.
[[nodiscard]] bool built_with_hid();
// Installs the udev rules. What else may mend kNoPermission: drivers/permission.h.
[[nodiscard]] std::string udev_install_command();

}  // namespace footlight::drivers

// Lists the plugged-in devices, whether they can be used, and the command that fixes it if not.
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
  kNoNode,        // known to the kernel, but /dev/bus/usb has no node: a container without device access
  kUnsupported,   // this build cannot open it
  kNotDmx,        // listed because the table has its id, but no string identifies it as a DMX interface
};
// "ready", "no-permission", "busy", "no-node", "unsupported", "not-dmx": stable identifiers for JSON.
[[nodiscard]] std::string_view name_of(Readiness readiness);

struct FoundDevice {
  std::string driver_id;     // DriverInfo::id; empty for kNotDmx
  std::string model_name;    // "ENTTEC DMX USB Pro"; for kNotDmx "FTDI serial adapter, not known to be a DMX USB Pro"
  std::string manufacturer;  // from the device; may be empty
  std::string product;
  std::string serial;  // of the USB descriptor; may be empty or shared by clones
  std::uint16_t usb_vendor = 0;
  std::uint16_t usb_product = 0;
  std::uint16_t usb_release = 0;  // bcdDevice
  std::string port_path;          // its USB socket: "1-2.3"; the same after a replug there
  std::string node;               // "/dev/bus/usb/001/004"; changes when it is replugged
  std::string kernel_driver;      // bound to its first interface: "ftdi_sio", "usbfs" (a program holds it), or empty
  TransportKind transport = TransportKind::kFtdi;  // of its row; undefined for kNotDmx
  std::string_view way;       // how it would be opened now: "libusb", "tty", "hidraw"; empty for kNotDmx
  std::string tty;            // "/dev/ttyUSB0" of its first interface; empty if there is none now
  std::string hidraw;         // "/dev/hidraw3", likewise
  std::string holder;         // "olad (process 812)": another program that has one of its nodes open, if visible
  std::string endpoint;       // for a show file: "enttec-pro:EN172589"; empty for kNotDmx
  unsigned capabilities = 0;  // Capability
  unsigned quirks = 0;        // Quirk
  Readiness readiness = Readiness::kReady;
  std::string reason;  // one sentence; empty if ready
  std::string remedy;  // a command to copy; empty if there is none
  // The command that binds ftdi_sio again to an FTDI chip that has no kernel driver although ftdi_sio is loaded: a
  // program that had detached the driver was killed. The chip can be opened anyway, but its tty is missing. Empty
  // otherwise.
  std::string rebind;
};

// "usb", "serial", "hid": stable identifiers for JSON.
[[nodiscard]] std::string_view kind_of(TransportKind transport);

struct DeviceList {
  std::vector<FoundDevice> devices;  // in the order of their port paths
  std::vector<std::string> notes;    // about the whole list: "built without USB: ..."
};

// The owner of a node. An empty group: the node could not be examined.
struct NodeOwner {
  std::string group;
  unsigned mode = 0;  // permission bits
};

// Where to search. The defaults are the system's; tests use their own folders.
struct FindOptions {
  std::string sys_root = "/sys";
  std::string dev_root = "/dev";
  std::string proc_root = "/proc";
  // 0 if the node may be read and written, else an errno value. Empty: the system is queried.
  std::function<int(const std::string& node)> node_access;
  // For the advice if a node may not be opened (drivers/permission.h).
  std::string etc_root = "/etc";
  std::vector<std::string> lib_roots = {"/usr/local/lib", "/usr/lib"};  // of packages; the first with a file is used
  std::optional<std::vector<std::string>> groups = {};                  // by name; nullopt: those of this process
  std::string user_name = {};                                           // empty: the user of this process
  std::function<NodeOwner(const std::string& node)> node_owner = {};    // empty: the system is queried
};

// options.node_access, if set, else the system's answer: 0, or an errno value.
[[nodiscard]] inline int node_access(const FindOptions& options, const std::string& node) {
  if (options.node_access) return options.node_access(node);
  return ::access(node.c_str(), R_OK | W_OK) == 0 ? 0 : errno;
}

[[nodiscard]] DeviceList find_devices(const FindOptions& options = {});

// True if libusb was available at build time.
[[nodiscard]] bool built_with_usb();
// True if the program was built with hidapi.
[[nodiscard]] bool built_with_hid();
// Installs the udev rules. Other fixes for kNoPermission: drivers/permission.h.
[[nodiscard]] std::string udev_install_command();

}  // namespace footlight::drivers

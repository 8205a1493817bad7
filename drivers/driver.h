// The static description of a family of devices.
//
// A driver is one constinit DriverInfo at the bottom of its .cpp file and one word in FOOTLIGHT_DRIVERS of
// drivers/CMakeLists.txt, from which the build generates the list that drivers() returns. The udev rules
// (udev/70-footlight.rules) and the table in docs/hardware.md are generated from the same rows.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/device/widget.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight::drivers {

namespace mock {
class UsbModel;
}

// Capabilities of a driver's devices; or-ed together.
enum Capability : unsigned {
  kCanOutput = 1u << 0,           // a Sink
  kCanInput = 1u << 1,            // a Source; the widget's lines decide whether both work at once
  kKeepsSnapshotAlive = 1u << 2,  // the device repeats the last frame itself, also after this program has ended
};

// Differences of a model from its family; or-ed together.
enum Quirk : unsigned {
  // The USB ids are those of the bare interface chip, which many other products use. The product or manufacturer string
  // must decide, and udev rules must not match the ids alone. If a row has no strings either, its devices are used only
  // if the user names them by serial number or port.
  kQuirkGenericUsbIds = 1u << 0,
  // Has a second DMX port that needs a key from the maker: see SecondPort.
  kQuirkSecondPortNeedsKey = 1u << 1,
  // The maker states two DMX connectors.
  kQuirkTwoPorts = 1u << 2,
};

// How a model is connected.
enum class TransportKind : std::uint8_t {
  kFtdi,  // an FTDI chip, over libusb or its tty
  kUsb,   // endpoints of its own, over libusb
  kTty,   // a serial device of the USB communication class, over its tty
  kHid,   // reports, over hidraw
};

// One row of a driver's table: a model that uses its protocol.
struct UsbModelId {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  // Text that the device's string must start with, case ignored; empty: any. The first matching row is used.
  std::string_view manufacturer_text;
  std::string_view product_text;
  std::string_view model_name;  // shown to users
  unsigned quirks = 0;          // Quirk
  TransportKind transport = TransportKind::kFtdi;
};

// Labels of a DMX USB Pro Mk2's second port, which the maker gives to users together with a key. 0: unknown.
struct SecondPort {
  std::array<std::uint8_t, 4> key{};  // for label 13, in wire order
  std::uint8_t assign = 0;            // assigns the ports' roles; payload 01 01: both DMX
  std::uint8_t send = 0;              // as label 6
  std::uint8_t receive = 0;           // as label 5
  std::uint8_t receive_mode = 0;      // as label 8
  std::uint8_t change_of_state = 0;   // as label 9
  friend bool operator==(const SecondPort&, const SecondPort&) = default;
};

// The parameters for opening a port: the part of an endpoint ("enttec-pro:EN172589") that drivers need.
struct PortRequest {
  std::string scheme;  // DriverInfo::id
  // The device: a serial number, "port-1-2.3" for its USB socket, or empty if only one is plugged in. For mock: see
  // drivers/mock/mock_usb.h.
  std::string target;
  std::vector<Universe> universes;  // counted from 1, one for each connector
  // The connectors of `universes`, from 1. Empty: the first connectors that support the use.
  std::vector<int> connectors = {};
  // Output only: send zeros when the port is closed. Otherwise the device keeps the last levels.
  bool blackout_on_exit = false;
  // Start even if the device is not plugged in; the port is kGone until then.
  bool wait_for_device = false;
  // Port::name(): the endpoint as the user wrote it. Empty: built from scheme and target.
  std::string name = {};
  // Input, if the device supports it: report changes only.
  bool receive_on_change = false;
  // If the host times the line: frames per second; 0: the driver's default.
  double rate_hz = 0.0;
  std::optional<SecondPort> second_port = {};
};

// The name of the port that this request opens.
[[nodiscard]] std::string name_of(const PortRequest& request);

struct DriverInfo {
  std::string_view id;         // the scheme of its endpoints, lower case: "enttec-pro"
  std::string_view full_name;  // shown to users
  std::span<const UsbModelId> usb_ids;
  unsigned capabilities = 0;  // Capability
  std::string_view notes;     // for docs/hardware.md; one or two sentences
  // Makes the protocol implementation. model: the row of the plugged-in device, else the first. nullptr: this driver is
  // a front end for others (mock).
  Result<std::unique_ptr<Widget>> (*make_widget)(const PortRequest& request, const UsbModelId& model) = nullptr;
  // Makes a model of the device, for `mock:<id>` and tests.
  std::unique_ptr<mock::UsbModel> (*make_model)() = nullptr;
};

// Every driver of this build, in the order of drivers/CMakeLists.txt.
[[nodiscard]] std::span<const DriverInfo* const> drivers();
// nullptr if there is no driver with that id.
[[nodiscard]] const DriverInfo* find_driver(std::string_view id);

}  // namespace footlight::drivers

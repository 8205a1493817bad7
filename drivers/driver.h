// What the program knows about a family of devices before any is plugged in.
//
// A driver is one constinit DriverInfo at the bottom of its .cpp file and one word in FOOTLIGHT_DRIVERS of
// drivers/CMakeLists.txt, from which the build writes the list that drivers() returns. The udev rules
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

// What a driver's devices can do; or-ed together.
enum Capability : unsigned {
  kCanOutput = 1u << 0,           // a Sink
  kCanInput = 1u << 1,            // a Source; whether both at once is up to the widget's lines
  kKeepsSnapshotAlive = 1u << 2,  // the device repeats the last frame by itself, also after this program has ended
};

// How one model differs from its family; or-ed together.
enum Quirk : unsigned {
  // The USB ids are those of the bare interface chip, used by countless other products: the product or manufacturer
  // string has to tell, and udev rules must not name the ids alone. Where a row has no strings either, its devices are
  // taken only when the user names them by serial number or port.
  kQuirkGenericUsbIds = 1u << 0,
  // Has a second DMX port that needs a key from the maker: see SecondPort.
  kQuirkSecondPortNeedsKey = 1u << 1,
  // The maker says two DMX connectors.
  kQuirkTwoPorts = 1u << 2,
};

// How a model is reached.
enum class TransportKind : std::uint8_t {
  kFtdi,  // an FTDI chip, over libusb or its tty
  kUsb,   // endpoints of its own, over libusb
  kTty,   // a serial device of the USB communication class, over its tty
  kHid,   // reports, over hidraw
};

// One row of a driver's table: a model that speaks its protocol.
struct UsbModelId {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  // Text that the device's string has to start with, case ignored; empty: any. Where several rows fit, the first
  // counts.
  std::string_view manufacturer_text;
  std::string_view product_text;
  std::string_view model_name;  // for people
  unsigned quirks = 0;          // Quirk
  TransportKind transport = TransportKind::kFtdi;
};

// Labels of a DMX USB Pro Mk2's second port, as the maker gave them to the user together with a key. 0: not known.
struct SecondPort {
  std::array<std::uint8_t, 4> key{};  // for label 13, in the order in which the bytes go over the wire
  std::uint8_t assign = 0;            // gives the ports their roles; payload 01 01: both DMX
  std::uint8_t send = 0;              // as label 6
  std::uint8_t receive = 0;           // as label 5
  std::uint8_t receive_mode = 0;      // as label 8
  std::uint8_t change_of_state = 0;   // as label 9
  friend bool operator==(const SecondPort&, const SecondPort&) = default;
};

// What a port is opened with. The part of an endpoint ("enttec-pro:EN172589") that drivers need.
struct PortRequest {
  std::string scheme;  // DriverInfo::id
  // Which device: a serial number, "port-1-2.3" for the socket it sits in, or empty where only one is plugged in.
  // For mock: see drivers/mock/mock_usb.h.
  std::string target;
  std::vector<Universe> universes;  // as people count, one for each connector
  // Beside `universes`, from 1. Empty: the first connectors that can do what is asked.
  std::vector<int> connectors = {};
  // Output only: send all slots 0 when the port is closed. Otherwise the device goes on showing the last look.
  bool blackout_on_exit = false;
  // Start although the device is not plugged in; the port is kGone until it comes.
  bool wait_for_device = false;
  // Port::name(): the endpoint as the user wrote it. Empty: built from scheme and target.
  std::string name = {};
  // Input, where the device can: report changes only.
  bool receive_on_change = false;
  // Where the host times the line: frames a second; 0: the driver's own.
  double rate_hz = 0.0;
  std::optional<SecondPort> second_port = {};
};

// What a port opened by this request is called.
[[nodiscard]] std::string name_of(const PortRequest& request);

struct DriverInfo {
  std::string_view id;         // the scheme of its endpoints, lower case: "enttec-pro"
  std::string_view full_name;  // for people
  std::span<const UsbModelId> usb_ids;
  unsigned capabilities = 0;  // Capability
  std::string_view notes;     // for docs/hardware.md; one or two sentences
  // What speaks the protocol. model: the row of the device that is plugged in, else the first. nullptr: this driver is
  // a front end for others (mock).
  Result<std::unique_ptr<Widget>> (*make_widget)(const PortRequest& request, const UsbModelId& model) = nullptr;
  // A model of the device, for `mock:<id>` and tests.
  std::unique_ptr<mock::UsbModel> (*make_model)() = nullptr;
};

// Every driver of this build, in the order of drivers/CMakeLists.txt.
[[nodiscard]] std::span<const DriverInfo* const> drivers();
// nullptr where there is none of that id.
[[nodiscard]] const DriverInfo* find_driver(std::string_view id);

}  // namespace footlight::drivers

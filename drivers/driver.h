// What the program knows about a family of devices before any is plugged in.
//
// A driver is one constinit DriverInfo at the bottom of its .cpp file and one word in FOOTLIGHT_DRIVERS of
// drivers/CMakeLists.txt, from which the build writes the list that drivers() returns. The udev rules
// (udev/70-footlight.rules) and the table in docs/hardware.md are generated from the same rows.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// What a driver's devices can do; or-ed together.
enum Capability : unsigned {
  kCanOutput = 1u << 0,       // a Sink
  kCanInput = 1u << 1,        // a Source; on one device only one of the two at a time
  kKeepsLookAlive = 1u << 2,  // the device repeats the last frame by itself, also after this program has ended
};

// How one model differs from its family; or-ed together.
enum Quirk : unsigned {
  // The USB ids are those of the bare interface chip, used by countless other products: the product or manufacturer
  // string has to tell, and udev rules must not name the ids alone.
  kQuirkGenericUsbIds = 1u << 0,
  // Has a second DMX port that needs a key from the maker; only the first is used.
  kQuirkFirstPortOnly = 1u << 1,
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
};

// What a port is opened with. The part of an endpoint ("enttec-pro:EN172589") that drivers need.
struct PortRequest {
  std::string scheme;  // DriverInfo::id
  // Which device: a serial number, "port-1-2.3" for the socket it sits in, or empty where only one is plugged in.
  // For mock: see drivers/mock/mock_usb.h.
  std::string target;
  std::vector<Universe> universes;  // as people count; enttec-pro carries exactly one
  // Output only: send all slots 0 when the port is closed. Otherwise the device goes on showing the last look.
  bool blackout_on_exit = false;
  // Start although the device is not plugged in; the port is kGone until it comes.
  bool wait_for_device = false;
  // Port::name(): the endpoint as the user wrote it. Empty: built from scheme and target.
  std::string name = {};
};

// What a port opened by this request is called.
[[nodiscard]] std::string name_of(const PortRequest& request);

struct DriverInfo {
  std::string_view id;         // the scheme of its endpoints, lower case: "enttec-pro"
  std::string_view full_name;  // for people
  std::span<const UsbModelId> usb_ids;
  unsigned capabilities = 0;  // Capability
  std::string_view notes;     // for docs/hardware.md; one or two sentences
  // nullptr where the driver has none. Both may block for about a second while the device answers.
  // Clock: outlives the port; its now_ns() is called from the port's device thread.
  Result<std::unique_ptr<Sink>> (*open_sink)(const PortRequest& request, Clock& clock) = nullptr;
  Result<std::unique_ptr<Source>> (*open_source)(const PortRequest& request, Clock& clock) = nullptr;
};

// Every driver of this build, in the order of drivers/CMakeLists.txt.
[[nodiscard]] std::span<const DriverInfo* const> drivers();
// nullptr where there is none of that id.
[[nodiscard]] const DriverInfo* find_driver(std::string_view id);

}  // namespace footlight::drivers

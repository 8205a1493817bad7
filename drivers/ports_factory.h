// Opens a port for a device endpoint: the only call that a main needs to use an interface.
//
//   auto sink = drivers::open_sink({.scheme = "enttec-pro", .target = "EN172589", .universes = {1}}, clock);
//
// Network schemes (sacn, artnet) have factories of their own in drivers/net/.
#pragma once

#include <memory>
#include <string_view>

#include "drivers/driver.h"
#include "drivers/rdm/rdm_line.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

// True if open_sink() or open_source() supports the scheme.
[[nodiscard]] bool has_driver(std::string_view scheme);

// Errors: kBadInput (unknown scheme, wrong number of universes), kNotFound (no such device; lists those present),
// kPermission (names the command that fixes it), kTimeout (a device that does not answer), kUnsupported (this build has
// no USB, or the device does not support that direction). Threads: call from any; the port then belongs to one thread.
[[nodiscard]] Result<std::unique_ptr<Sink>> open_sink(const PortRequest& request, Clock& clock);
[[nodiscard]] Result<std::unique_ptr<Source>> open_source(const PortRequest& request, Clock& clock);

// The RDM line of a device's first connector, which is opened as an output without frames. Errors as above; its calls
// return kUnsupported if the device has no RDM.
[[nodiscard]] Result<std::unique_ptr<RdmLine>> open_rdm_line(const PortRequest& request, const RdmUid& own,
                                                             Clock& clock);

}  // namespace footlight::drivers

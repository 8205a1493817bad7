// What a Widget can beside levels where its device carries Remote Device Management.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/device/widget.h"
#include "drivers/rdm/rdm_packet.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// A Widget that is one of these as well puts requests on its lines between two frames.
class RdmWidget {
 public:
  virtual ~RdmWidget() = default;
  // On the device's thread. Sends a request on an output line and returns what came back, as it was on the line from
  // the start code on, or nothing; the look that the line showed is sent again before this returns. Errors:
  // kUnsupported: this line, or this firmware, cannot; says the next step. Those of the transport.
  virtual Result<Octets> exchange_rdm(WidgetContext& context, int line, std::span<const std::uint8_t> request) = 0;
};

}  // namespace footlight::drivers

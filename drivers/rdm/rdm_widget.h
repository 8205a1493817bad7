// The interface of a Widget whose device supports Remote Device Management.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/device/widget.h"
#include "drivers/rdm/rdm_packet.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// A Widget that also derives from this class sends requests on its lines between two frames.
class RdmWidget {
 public:
  virtual ~RdmWidget() = default;
  // On the device's thread. Sends a request on an output line and returns what was received, from the start code on, or
  // nothing. The line's current snapshot is sent again before this returns. Errors: kUnsupported: not this line, or not
  // this firmware; names the next step. Those of the transport.
  virtual Result<Octets> exchange_rdm(WidgetContext& context, int line, std::span<const std::uint8_t> request) = 0;
};

}  // namespace footlight::drivers

// Two ways to one device: the second is tried where the first may not or cannot be used. An FTDI chip is reached over
// libusb, or over its tty where this build has no libusb or the rules for it are not installed.
#pragma once

#include <memory>

#include "drivers/device/transport.h"

namespace footlight::drivers {

// `first` says when a device may have been plugged in. Both should choose with the same Chooser.
[[nodiscard]] std::unique_ptr<Connector> make_either_connector(std::unique_ptr<Connector> first,
                                                               std::unique_ptr<Connector> second);

}  // namespace footlight::drivers

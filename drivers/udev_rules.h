// Generates texts from the driver table, so that no list of devices is maintained twice.
#pragma once

#include <string>

namespace footlight::drivers {

// udev/70-footlight.rules.
[[nodiscard]] std::string udev_rules_text();
// The table between the markers of docs/hardware.md, markers included.
[[nodiscard]] std::string hardware_table_text();

}  // namespace footlight::drivers

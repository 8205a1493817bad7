// Lists the GPIO chips of this machine, who may open them, and the command that gives this user access.
//
// Searches /sys. A chip that may be opened is queried for its label and line count; no line is requested. Works in
// builds without libgpiod too.
#pragma once

#include <string>
#include <vector>

#include "drivers/registry.h"

namespace footlight::drivers {

struct FoundGpioChip {
  std::string name;    // "gpiochip0", as in gpio:gpiochip0/17=1.25; the kernel may assign another number at the next
                       // start
  std::string label;   // "pinctrl-bcm2711", constant; empty if the chip could not be opened
  int line_count = 0;  // 0: likewise
  std::string node;    // "/dev/gpiochip0"
  // The driver of the device that it is part of: "pinctrl-bcm2835"; "ftdi_sio" for the spare pins of an FTDI serial
  // chip, whose GPIO chip disappears while the chip is used for DMX. Empty if unknown.
  std::string kernel_driver;
  std::string owner, group;  // of the node; a number if it has no name, empty if there is no node
  unsigned mode = 0;         // permission bits of the node
  std::string open_to;       // who may use it: "root", "root and the group gpio", "everybody"; empty: no node
  Readiness readiness = Readiness::kReady;  // kReady, kNoPermission, kNoNode, kUnsupported
  std::string reason;                       // one sentence; empty if ready
  std::string remedy;                       // a command to copy; empty if there is none
};

// True if the chip is part of a serial adapter. Then it does not matter if it may not be opened.
[[nodiscard]] inline bool is_part_of_serial_chip(const FoundGpioChip& chip) { return chip.kernel_driver == "ftdi_sio"; }

// A line of the chip, for an example: 17, or 0 if it has fewer.
[[nodiscard]] inline int example_line(const FoundGpioChip& chip) { return chip.line_count > 17 ? 17 : 0; }

// In the order of their numbers.
[[nodiscard]] std::vector<FoundGpioChip> find_gpio_chips(const FindOptions& options = {});

// Installs the rule that lets the group plugdev use every chip.
[[nodiscard]] std::string gpio_install_command();

}  // namespace footlight::drivers

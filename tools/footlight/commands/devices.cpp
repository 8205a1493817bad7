// footlight devices: lists DMX devices and GPIO chips, and the command that fixes each one that cannot be opened.
#include <cstdio>
#include <memory>

#include "drivers/gpio/gpio_list.h"
#include "drivers/registry.h"
#include "tools/footlight/command.h"
#include "tools/footlight/status/json_lines.h"

namespace footlight::tools {
namespace {

std::string capabilities_of(const drivers::FoundDevice& device) {
  std::string text;
  if ((device.capabilities & drivers::kCanOutput) != 0) text += "output";
  if ((device.capabilities & drivers::kCanInput) != 0) text += text.empty() ? "input" : " or input";
  if ((device.capabilities & drivers::kKeepsSnapshotAlive) != 0)
    text += ", holds the last levels when the program ends";
  if ((device.quirks & drivers::kQuirkSecondPortNeedsKey) != 0)
    text += ", second port with a key from the manufacturer";
  return text;
}

void print(const drivers::FoundDevice& device) {
  fmt::print("{}\n",
             device.endpoint.empty() ? device.model_name : fmt::format("{}  {}", device.endpoint, device.model_name));
  const std::string capabilities = capabilities_of(device);
  if (!capabilities.empty()) fmt::print("  can:   {}\n", capabilities);
  fmt::print("  where: USB socket {}, {}{}\n", device.port_path, device.node,
             device.kernel_driver.empty() ? "" : fmt::format(", kernel driver {}", device.kernel_driver));
  if (device.readiness == drivers::Readiness::kReady) {
    fmt::print("  ready: footlight run --in sacn:1 --out {}\n", device.endpoint);
  } else {
    fmt::print("  state: {}: {}\n", drivers::name_of(device.readiness), device.reason);
    if (!device.remedy.empty()) fmt::print("  fix:   {}\n", device.remedy);
  }
  if (!device.rebind.empty())
    fmt::print("  note:  ftdi_sio is not bound to it, so it has no tty; this binds it: {}\n", device.rebind);
}

void print(const drivers::FoundGpioChip& chip) {
  std::string what = "GPIO chip";
  if (chip.line_count > 0) what = fmt::format("GPIO chip {}, {} lines", chip.label, chip.line_count);
  fmt::print("gpio:{}  {}\n", chip.name, what);
  fmt::print("  where: {}{}\n", chip.node,
             chip.open_to.empty() ? "" : fmt::format(", open to {} (mode {:04o})", chip.open_to, chip.mode));
  if (chip.readiness == drivers::Readiness::kReady) {
    fmt::print(
        "  ready: footlight run --in gpio:{}/{}=1.25 --out sacn:1, with the number of your line; see docs/gpio.md\n",
        chip.name, drivers::example_line(chip));
  } else if (drivers::is_part_of_serial_chip(chip)) {
    fmt::print("  state: spare pins of a serial adapter, which DMX does not need\n");
  } else {
    fmt::print("  state: {}: {}\n", drivers::name_of(chip.readiness), chip.reason);
    if (!chip.remedy.empty()) fmt::print("  fix:   {}\n", chip.remedy);
  }
}

int list_devices(bool json) {
  const drivers::DeviceList list = drivers::find_devices();
  for (const drivers::FoundDevice& device : list.devices) {
    if (json) {
      fmt::print("{}\n", json_of_device(device));
    } else {
      print(device);
    }
  }
  for (const drivers::FoundGpioChip& chip : drivers::find_gpio_chips()) {
    if (json) {
      fmt::print("{}\n", json_of_gpio_chip(chip));
    } else {
      print(chip);
    }
  }
  for (const std::string& note : list.notes) fmt::print(stderr, "footlight: {}\n", note);
  if (!list.devices.empty()) return kExitOk;
  fmt::print(
      stderr,
      "footlight: no DMX device is plugged in; without one, try 'footlight run --in sacn:1 --out mock:enttec-pro'\n");
  return kExitNotFound;
}

void add(Arguments& arguments) {
  auto json = std::make_shared<bool>(false);
  arguments.flag("--json", *json, "one JSON object a line for each device");
  arguments.job([json]() -> Result<int> { return list_devices(*json); });
}

}  // namespace

extern const CommandInfo devices_command{
    .name = "devices",
    .help = "List DMX devices and GPIO chips, and how to get access to them",
    .examples =
        "  footlight devices\n"
        "  footlight devices --json | jq -r 'select(.endpoint) | .endpoint'\n"
        "For each device: its endpoint, what it supports, and if it cannot be opened, the command that fixes this. No\n"
        "permission is needed and no DMX device is opened. GPIO chips are opened to read their labels, if allowed.\n"
        "Exit code 3 if there is no DMX device.",
    .add = add,
};

}  // namespace footlight::tools

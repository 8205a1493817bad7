// The JSON objects and lines of `footlight devices`.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/status/json_lines.h"

namespace footlight::tools {
namespace {

using Json = nlohmann::json;

TEST_SUITE_BEGIN("devices");

TEST_CASE("the JSON of a device has its kind, its transport and its driver") {
  drivers::FoundDevice device;
  device.driver_id = "nodle";
  device.transport = drivers::TransportKind::kHid;
  device.way = "hidraw";
  device.endpoint = "nodle:port-1-2";
  const Json json = Json::parse(json_of_device(device));
  CHECK(json["kind"] == "hid");
  CHECK(json["transport"] == "hidraw");
  CHECK(json["driver"] == "nodle");
  CHECK(json["endpoint"] == "nodle:port-1-2");

  const Json unknown = Json::parse(json_of_device({}));
  CHECK(unknown["kind"] == "unknown");  // although its transport has a value
  CHECK(unknown["transport"] == "");
  CHECK(unknown["driver"] == "");
}

TEST_CASE("the JSON of a GPIO chip has its label, its lines, who may open it and the fix") {
  drivers::FoundGpioChip chip;
  chip.name = "gpiochip0";
  chip.label = "pinctrl-bcm2711";
  chip.line_count = 58;
  chip.node = "/dev/gpiochip0";
  chip.owner = "root";
  chip.group = "gpio";
  chip.mode = 0660;
  chip.open_to = "root and the group gpio";
  chip.readiness = drivers::Readiness::kNoPermission;
  chip.remedy = "sudo usermod -aG gpio $USER";
  const Json json = Json::parse(json_of_gpio_chip(chip));
  CHECK(json["kind"] == "gpio");
  CHECK(json["name"] == "gpiochip0");
  CHECK(json["label"] == "pinctrl-bcm2711");
  CHECK(json["lines"] == 58);
  CHECK(json["group"] == "gpio");
  CHECK(json["mode"] == "0660");
  CHECK(json["open_to"] == "root and the group gpio");
  CHECK(json["readiness"] == "no-permission");
  CHECK(json["remedy"] == "sudo usermod -aG gpio $USER");
}

TEST_CASE("the command lists the devices of this machine, and its exit code is 3 without a DMX device") {
  const testing::Outcome outcome = testing::footlight({"devices", "--json"});
  std::size_t devices = 0, chips = 0;
  for (std::size_t at = 0; at < outcome.out.size();) {
    const std::size_t end = outcome.out.find('\n', at);
    REQUIRE(end != std::string::npos);
    const Json json = Json::parse(outcome.out.substr(at, end - at));
    (json["kind"] == "gpio" ? chips : devices) += 1;
    at = end + 1;
  }
  CHECK(chips == drivers::find_gpio_chips().size());
  CHECK(devices == drivers::find_devices().devices.size());
  CHECK(outcome.exit_code == (devices == 0 ? 3 : 0));
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::tools

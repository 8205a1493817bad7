// Chips found in folders laid out like /sys and /dev. Labels and line counts are in libgpiod_test.cpp.
#include "drivers/gpio/gpio_list.h"

#include <doctest/doctest.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "drivers/gpio/gpio_chip.h"
#include "tests/support/temp_folder.h"

namespace footlight::drivers {
namespace {

namespace fs = std::filesystem;

class Machine {
 public:
  Machine() { fs::create_directories(root_ / "dev"); }

  void add(const std::string& name, unsigned mode, bool has_node = true) {
    fs::create_directories(root_ / "sys/bus/gpio/devices" / name);
    if (!has_node) return;
    std::ofstream(root_ / "dev" / name) << "";
    fs::permissions(root_ / "dev" / name, static_cast<fs::perms>(mode));
  }
  // A chip in the folder of its parent device, as in the kernel.
  void add_part_of(const std::string& device, const std::string& driver, const std::string& name) {
    const fs::path parent = root_ / "sys/devices" / device;
    fs::create_directories(parent / name);
    fs::create_symlink("../../bus/x/drivers/" + driver, parent / "driver");
    fs::create_directories(root_ / "sys/bus/gpio/devices");
    fs::create_symlink("../../../devices/" + device + "/" + name, root_ / "sys/bus/gpio/devices" / name);
    std::ofstream(root_ / "dev" / name) << "";
  }
  // False if this user may not change a file's group.
  bool give_to_group(const std::string& name, gid_t group) {
    return ::chown((root_ / "dev" / name).c_str(), static_cast<uid_t>(-1), group) == 0;
  }
  std::vector<FoundGpioChip> find(int access_error = 0) const {
    return find_gpio_chips({.sys_root = (root_ / "sys").string(),
                            .dev_root = (root_ / "dev").string(),
                            .proc_root = (root_ / "proc").string(),
                            .node_access = [access_error](const std::string&) { return access_error; }});
  }
  std::string node(const std::string& name) const { return (root_ / "dev" / name).string(); }

 private:
  testing::TempFolder folder_;
  const fs::path root_ = folder_.path();
};

TEST_SUITE_BEGIN("gpio list");

TEST_CASE("only chips are listed, in the order of their numbers") {
  Machine machine;
  for (const char* name : {"gpiochip10", "gpiochip2", "gpiochip0", "gpiochip", "gpiochip1x", "gpio17"})
    machine.add(name, 0600);
  const auto chips = machine.find();
  REQUIRE(chips.size() == 3);
  CHECK(chips[0].name == "gpiochip0");
  CHECK(chips[1].name == "gpiochip2");
  CHECK(chips[2].name == "gpiochip10");
  CHECK(chips[2].node == machine.node("gpiochip10"));
  CHECK(chips[0].readiness == (built_with_gpio() ? Readiness::kReady : Readiness::kUnsupported));
  CHECK(chips[0].reason.empty() == built_with_gpio());
}

TEST_CASE("the mode of its node decides who may open a chip") {
  Machine machine;
  machine.add("gpiochip0", 0600);
  machine.add("gpiochip1", 0660);
  machine.add("gpiochip2", 0666);
  machine.add("gpiochip3", 0640);  // reading alone is not enough
  const auto chips = machine.find();
  REQUIRE(chips.size() == 4);
  for (const auto& chip : chips) CHECK_FALSE(chip.group.empty());
  CHECK(chips[0].mode == 0600);
  CHECK(chips[0].open_to.find("group") == std::string::npos);
  CHECK(chips[1].open_to.find(fmt::format("the group {}", chips[1].group)) != std::string::npos);
  CHECK(chips[2].open_to == "everybody");
  CHECK(chips[3].open_to == chips[0].open_to);
}

TEST_CASE("without permission the remedy is the rule, or joining the group that has permission") {
  Machine machine;
  machine.add("gpiochip0", 0600);
  auto chips = machine.find(EACCES);
  REQUIRE(chips.size() == 1);
  CHECK(chips[0].readiness == Readiness::kNoPermission);
  CHECK(chips[0].reason.find("Permission denied") != std::string::npos);
  CHECK(chips[0].remedy == gpio_install_command());
  CHECK(chips[0].remedy.find("udev/71-footlight-gpio.rules") != std::string::npos);
  CHECK(chips[0].label.empty());
  CHECK(chips[0].line_count == 0);
  if (!machine.give_to_group("gpiochip0", 46)) {
    MESSAGE("this user cannot give a file to another group: half of this is not tested");
    return;
  }
  CHECK(machine.find(EACCES)[0].remedy == gpio_install_command());  // the group has no permission
  machine.add("gpiochip0", 0660);
  chips = machine.find(EACCES);
  CHECK(chips[0].remedy == fmt::format("sudo usermod -aG {} $USER", chips[0].group));
  CHECK(chips[0].reason.find("login") != std::string::npos);
}

TEST_CASE("the spare pins of a serial adapter are recognised by the kernel driver") {
  Machine machine;
  machine.add("gpiochip0", 0600);
  machine.add_part_of("1-2:1.0", "ftdi_sio", "gpiochip1");
  machine.add_part_of("fe200000.gpio", "pinctrl-bcm2835", "gpiochip2");
  const auto chips = machine.find(EACCES);
  REQUIRE(chips.size() == 3);
  CHECK(chips[0].kernel_driver.empty());
  CHECK_FALSE(is_part_of_serial_chip(chips[0]));
  CHECK(chips[1].kernel_driver == "ftdi_sio");
  CHECK(is_part_of_serial_chip(chips[1]));
  CHECK(chips[2].kernel_driver == "pinctrl-bcm2835");
  CHECK_FALSE(is_part_of_serial_chip(chips[2]));
}

TEST_CASE("the line of an example exists on the chip") {
  for (const int count : {1, 4, 8, 17, 18, 58}) {
    FoundGpioChip chip;
    chip.line_count = count;
    CHECK(example_line(chip) < count);
    CHECK(example_line(chip) == (count > 17 ? 17 : 0));
  }
  CHECK(example_line({}) == 0);  // unknown size
}

TEST_CASE("a chip without a node is reported as such, and a machine without chips has an empty list") {
  Machine machine;
  CHECK(machine.find().empty());
  machine.add("gpiochip0", 0, false);
  const auto chips = machine.find();
  REQUIRE(chips.size() == 1);
  CHECK(chips[0].readiness == Readiness::kNoNode);
  CHECK(chips[0].reason.find("container") != std::string::npos);
  CHECK(chips[0].open_to.empty());
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers

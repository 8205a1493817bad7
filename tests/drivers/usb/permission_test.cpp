// The advice if a node may not be opened, for every state of the machine that it distinguishes.
#include "drivers/permission.h"

#include <doctest/doctest.h>

#include <cerrno>
#include <filesystem>
#include <fstream>

#include "drivers/udev_rules.h"
#include "tests/support/temp_folder.h"

namespace footlight::drivers {
namespace {

// A known device with current rules: root:plugdev, mode 0660.
PermissionFacts known_device() {
  return {.node = "/dev/bus/usb/001/004",
          .error = EACCES,
          .group = "plugdev",
          .group_opens = true,
          .rules = RulesState::kCurrent};
}
// The kernel's default for a node: root:root, mode 0664.
PermissionFacts untouched(PermissionFacts facts) {
  facts.group = "root";
  return facts;
}
bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_SUITE_BEGIN("permission");

TEST_CASE("a user without the udev rules is advised to install them") {
  PermissionFacts facts = untouched(known_device());
  facts.rules = RulesState::kMissing;
  const Advice advice = advise(facts);
  CHECK(advice.reason == "/dev/bus/usb/001/004: Permission denied; the udev rules are not installed");
  CHECK(advice.remedy == udev_install_command());
}

TEST_CASE("a user with the udev rules of another version is advised to install the current ones") {
  PermissionFacts facts = untouched(known_device());
  facts.rules = RulesState::kOutdated;
  const Advice advice = advise(facts);
  CHECK(contains(advice.reason, "another version"));
  CHECK(advice.remedy == udev_install_command());
}

TEST_CASE("a user outside plugdev is advised to join it, and not to install current rules again") {
  const Advice advice = advise(known_device());
  CHECK(contains(advice.reason, "plugdev"));
  CHECK(contains(advice.reason, "next login"));
  CHECK(advice.remedy == "sudo usermod -aG plugdev $USER");
}

TEST_CASE("a user who joined plugdev after the login is advised to log in again, and not to join") {
  PermissionFacts facts = known_device();
  facts.listed_in_group = true;
  const Advice advice = advise(facts);
  CHECK(contains(advice.reason, "log out and in again"));
  CHECK(advice.remedy == "newgrp plugdev");
}

TEST_CASE("current rules that were not applied to a device are applied, and not installed again") {
  const Advice advice = advise(untouched(known_device()));
  CHECK(contains(advice.reason, "were not applied"));
  CHECK(advice.remedy == "sudo udevadm control --reload && sudo udevadm trigger");
}

TEST_CASE("on a machine without the group plugdev the advice creates it") {
  PermissionFacts facts = untouched(known_device());
  facts.rules_group_is_there = false;
  CHECK(advise(facts).remedy.starts_with("sudo groupadd --system plugdev && "));
  // udevd reads groups when it reads rules, and `udevadm control --reload` does not reload unchanged ones.
  CHECK(contains(advise(facts).remedy, "sudo systemctl restart systemd-udevd && sudo udevadm trigger"));
}

TEST_CASE("a member of plugdev who is still refused gets no command without effect") {
  PermissionFacts facts = known_device();
  facts.in_group = true;
  const Advice advice = advise(facts);
  CHECK(contains(advice.reason, "sandbox"));
  CHECK(advice.remedy.empty());
  CHECK(message_of(advice) == advice.reason);
}

TEST_CASE("root gets no command, in every state of the rules and groups") {
  for (const RulesState rules : {RulesState::kMissing, RulesState::kOutdated, RulesState::kCurrent}) {
    for (const char* own_rule : {"", "SUBSYSTEM"}) {
      PermissionFacts facts = known_device();
      facts.is_root = true;
      facts.rules = rules;
      facts.own_rule = own_rule;
      for (const PermissionFacts& state : {facts, untouched(facts)}) {
        const Advice advice = advise(state);
        CHECK(contains(advice.reason, "root"));
        CHECK(contains(advice.reason, "a sandbox or an ACL refuses it"));
        CHECK(advice.remedy.empty());
      }
    }
  }
}

TEST_CASE("an error other than permission brings no advice on permission") {
  PermissionFacts facts = known_device();
  facts.error = EIO;
  CHECK(advise(facts).reason == "/dev/bus/usb/001/004: Input/output error");
  CHECK(advise(facts).remedy.empty());
}

TEST_CASE("the advice for a bare cable is its own rule, in every state of the rules that exclude it") {
  for (const RulesState rules : {RulesState::kMissing, RulesState::kOutdated, RulesState::kCurrent}) {
    PermissionFacts facts = untouched(known_device());
    facts.rules = rules;
    facts.own_rule = R"(SUBSYSTEM=="usb", ATTR{serial}=="A50285BI")";
    facts.own_rule_name = "70-footlight-A50285BI.rules";
    const Advice advice = advise(facts);
    CHECK(contains(advice.reason, "exclude it"));
    CHECK(advice.remedy ==
          R"(echo 'SUBSYSTEM=="usb", ATTR{serial}=="A50285BI"' | sudo tee )"
          R"(/etc/udev/rules.d/70-footlight-A50285BI.rules && sudo udevadm control --reload && sudo udevadm trigger)");
  }
}

TEST_CASE("on a machine without the group plugdev the advice for a bare cable creates the group before its rule") {
  PermissionFacts facts = untouched(known_device());
  facts.rules_group_is_there = false;
  facts.own_rule = R"(SUBSYSTEM=="usb", ATTR{serial}=="A50285BI")";
  facts.own_rule_name = "70-footlight-A50285BI.rules";
  const Advice advice = advise(facts);
  CHECK(contains(advice.reason, "does not have the group plugdev"));
  CHECK(
      advice.remedy ==
      "sudo groupadd --system plugdev && sudo usermod -aG plugdev $USER && "
      R"(echo 'SUBSYSTEM=="usb", ATTR{serial}=="A50285BI"' | sudo tee )"
      "/etc/udev/rules.d/70-footlight-A50285BI.rules && sudo systemctl restart systemd-udevd && sudo udevadm trigger");
}

TEST_CASE("the advice for a bare cable with its own rule is to join the group of that rule, not a second rule") {
  for (const char* group : {"plugdev", "lights"}) {
    PermissionFacts facts = known_device();
    facts.own_rule = "SUBSYSTEM";
    facts.group = group;
    CHECK(advise(facts).remedy == fmt::format("sudo usermod -aG {} $USER", group));
  }
}

TEST_CASE("a tty of group dialout is opened by the rules if they match the device") {
  PermissionFacts facts = known_device();
  facts.node = "/dev/ttyACM0";
  facts.group = "dialout";
  facts.rules = RulesState::kMissing;
  CHECK(advise(facts).remedy == udev_install_command());
}

// --- Reading the facts

struct System {
  testing::TempFolder folder;
  FindOptions options{.etc_root = (folder.path() / "etc").string(),
                      .lib_roots = {(folder.path() / "local").string(), (folder.path() / "lib").string()},
                      .groups = std::vector<std::string>{"anna"},
                      .user_name = "anna",
                      .node_owner = [](const std::string&) {
                        return NodeOwner{"plugdev", 0660};
                      }};
  void write(const std::string& file, const std::string& text) const {
    const auto path = folder.path() / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
  }
  [[nodiscard]] PermissionFacts facts(const FoundDevice& device = {}) const {
    return permission_facts(device, "/dev/bus/usb/001/004", EACCES, options);
  }
};

TEST_CASE("the rules in /etc take precedence over those of packages") {
  const System system;
  CHECK(rules_state(system.options) == RulesState::kMissing);
  system.write("lib/udev/rules.d/70-footlight.rules", udev_rules_text());
  CHECK(rules_state(system.options) == RulesState::kCurrent);
  system.write("etc/udev/rules.d/70-footlight.rules", "# old\n");
  CHECK(rules_state(system.options) == RulesState::kOutdated);
}

TEST_CASE("membership is that of the session, and the group database shows whether a new login is needed") {
  System system;
  system.write("etc/group", "root:x:0:\nplugdev:x:46:bert,anna\nplugdev2:x:47:\n");
  CHECK_FALSE(system.facts().in_group);
  CHECK(system.facts().listed_in_group);
  CHECK(system.facts().rules_group_is_there);
  system.options.groups = std::vector<std::string>{"anna", "plugdev"};
  CHECK(system.facts().in_group);
  system.write("etc/group", "plugdev:x:46:annabel\n");
  CHECK_FALSE(system.facts().listed_in_group);
  system.write("etc/group", "plugdevice:x:46:anna\n");
  CHECK_FALSE(system.facts().rules_group_is_there);
}

TEST_CASE("only the user named root is root") {
  System system;
  CHECK_FALSE(system.facts().is_root);
  system.options.user_name = "root";
  CHECK(system.facts().is_root);
}

TEST_CASE("a node is open to its group only if the group may read and write") {
  System system;
  for (const auto& [mode, opens] : {std::pair{0660u, true}, std::pair{0640u, false}, std::pair{0600u, false}}) {
    const unsigned node_mode = mode;
    system.options.node_owner = [node_mode](const std::string&) { return NodeOwner{"plugdev", node_mode}; };
    CHECK(system.facts().group_opens == opens);
  }
}

TEST_CASE("the rule for a cable matches its serial number, or its socket if that is missing or not plain") {
  const System system;
  FoundDevice device;
  device.usb_vendor = 0x0403;
  device.usb_product = 0x6001;
  device.port_path = "1-2.3";
  device.serial = "A50285BI";
  CHECK(system.facts(device).own_rule ==
        R"(SUBSYSTEM=="usb", ATTR{idVendor}=="0403", ATTR{idProduct}=="6001", ATTR{serial}=="A50285BI", )"
        R"(GROUP="plugdev", MODE="0660", TAG+="uaccess")");
  CHECK(system.facts(device).own_rule_name == "70-footlight-A50285BI.rules");
  for (const char* serial : {"", "A'; rm -rf /", "../../x y"}) {
    device.serial = serial;
    CHECK(contains(system.facts(device).own_rule, R"(KERNEL=="1-2.3")"));
    CHECK(system.facts(device).own_rule_name == "70-footlight-port-1-2.3.rules");
  }
  device.tty = "/dev/bus/usb/001/004";  // the node that was refused is its tty
  CHECK(contains(system.facts(device).own_rule, R"(SUBSYSTEM=="tty", ATTRS{idVendor}=="0403")"));
  CHECK(contains(system.facts(device).own_rule, R"(KERNELS=="1-2.3")"));
  device.driver_id = "enttec-pro";  // the rules match it
  CHECK(system.facts(device).own_rule.empty());
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers

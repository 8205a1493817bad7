// Why this user may not open the node of a device, and the command that changes it.
//
// advise() decides from facts alone, so each state of a machine is a test. permission_facts() reads them: the installed
// udev rules, the owner of the node, the groups of this process and /etc/group. Nothing is opened or changed.
#pragma once

#include <string>

#include "drivers/registry.h"

namespace footlight::drivers {

// The group that the udev rules give devices to.
inline constexpr const char* kRulesGroup = "plugdev";

enum class RulesState {
  kMissing,
  kOutdated,  // 70-footlight.rules is there, but is not the one of this version
  kCurrent,
};

// 70-footlight.rules as installed: of /etc, else of the first folder of packages. Empty: not installed.
[[nodiscard]] std::string installed_udev_rules(const FindOptions& options);
[[nodiscard]] RulesState rules_state(const FindOptions& options);

// As options.node_owner, or as the system says.
[[nodiscard]] NodeOwner owner_of(const FindOptions& options, const std::string& node);

// Whether /etc/group lists the user in the group; a session that began before does not have it yet.
[[nodiscard]] bool is_listed_in(const FindOptions& options, const std::string& group);

struct PermissionFacts {
  // The node and what opening it gave.
  std::string node;          // "/dev/bus/usb/001/004"
  int error = 0;             // an errno value
  std::string group;         // of the node
  bool group_opens = false;  // the node's mode lets its group read and write
  // The rules.
  RulesState rules = RulesState::kMissing;
  std::string own_rule;       // where 70-footlight.rules excludes the device by design: the rule that opens it alone
  std::string own_rule_name;  // of the file for own_rule: "70-footlight-A50285BI.rules"
  // The user.
  bool is_root = false;              // the mode of a node does not bind it
  bool in_group = false;             // this process has the node's group
  bool listed_in_group = false;      // the group database has the user in it
  bool rules_group_is_there = true;  // the group database has kRulesGroup
};

struct Advice {
  std::string reason;  // for people, one sentence
  std::string remedy;  // a command to copy; empty where there is none
};

[[nodiscard]] Advice advise(const PermissionFacts& facts);

[[nodiscard]] PermissionFacts permission_facts(const FoundDevice& device, const std::string& node, int error,
                                               const FindOptions& options);
// Both steps. node: that of the device which could not be opened.
[[nodiscard]] Advice advise_on_permission(const FoundDevice& device, const std::string& node, int error,
                                          const FindOptions& options);
// As a message: "reason; run: remedy".
[[nodiscard]] std::string message_of(const Advice& advice);

}  // namespace footlight::drivers

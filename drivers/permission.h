// Explains why this user may not open a device node, and gives the command that fixes it.
//
// advise() decides from facts alone, so each state of a machine can be tested. permission_facts() reads them: the
// installed udev rules, the owner of the node, the groups of this process and /etc/group. Nothing is opened or changed.
#pragma once

#include <string>

#include "drivers/registry.h"

namespace footlight::drivers {

// The group that the udev rules assign to devices.
inline constexpr const char* kRulesGroup = "plugdev";

enum class RulesState {
  kMissing,
  kOutdated,  // 70-footlight.rules exists, but is not the one of this version
  kCurrent,
};

// The installed 70-footlight.rules: of /etc, else of the first package folder. Empty: not installed.
[[nodiscard]] std::string installed_udev_rules(const FindOptions& options);
[[nodiscard]] RulesState rules_state(const FindOptions& options);

// options.node_owner, if set, else the system's answer.
[[nodiscard]] NodeOwner owner_of(const FindOptions& options, const std::string& node);

// True if /etc/group lists the user in the group; a session started before that does not have it yet.
[[nodiscard]] bool is_listed_in(const FindOptions& options, const std::string& group);

struct PermissionFacts {
  // The node and the result of opening it.
  std::string node;          // "/dev/bus/usb/001/004"
  int error = 0;             // an errno value
  std::string group;         // of the node
  bool group_opens = false;  // the node's mode allows its group to read and write
  // The rules.
  RulesState rules = RulesState::kMissing;
  std::string own_rule;       // if 70-footlight.rules excludes the device by design: the rule for this device alone
  std::string own_rule_name;  // file name for own_rule: "70-footlight-A50285BI.rules"
  // The user.
  bool is_root = false;              // not restricted by the mode of a node
  bool in_group = false;             // this process is in the node's group
  bool listed_in_group = false;      // the group database lists the user in it
  bool rules_group_is_there = true;  // the group database has kRulesGroup
};

struct Advice {
  std::string reason;  // one sentence
  std::string remedy;  // a command to copy; empty if there is none
};

[[nodiscard]] Advice advise(const PermissionFacts& facts);

[[nodiscard]] PermissionFacts permission_facts(const FoundDevice& device, const std::string& node, int error,
                                               const FindOptions& options);
// Both steps. node: the one that could not be opened.
[[nodiscard]] Advice advise_on_permission(const FoundDevice& device, const std::string& node, int error,
                                          const FindOptions& options);
// As a message: "reason; run: remedy".
[[nodiscard]] std::string message_of(const Advice& advice);

}  // namespace footlight::drivers

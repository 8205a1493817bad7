#include "drivers/permission.h"

#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <vector>

#include "drivers/udev_rules.h"

namespace footlight::drivers {
namespace {

constexpr const char* kApplyRules = "sudo udevadm control --reload && sudo udevadm trigger";
constexpr const char* kMakeGroup = "sudo groupadd --system plugdev && sudo usermod -aG plugdev $USER";
// udevd reads groups when it reads rules, and `udevadm control --reload` does not reload unchanged ones.
constexpr const char* kRestartUdev = "sudo systemctl restart systemd-udevd && sudo udevadm trigger";

std::optional<std::string> text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return std::string{std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> groups_of_process() {
  std::vector<gid_t> ids(static_cast<std::size_t>(std::max(::getgroups(0, nullptr), 0)));
  ids.resize(static_cast<std::size_t>(std::max(::getgroups(static_cast<int>(ids.size()), ids.data()), 0)));
  ids.push_back(::getegid());
  std::vector<std::string> names;
  for (const gid_t id : ids)
    if (const group* const found = ::getgrgid(id)) names.emplace_back(found->gr_name);
  return names;
}

std::string name_of_user() {
  const passwd* const user = ::getpwuid(::geteuid());
  return user != nullptr ? user->pw_name : "";
}

// The members of a group as /etc/group lists them, "anna,bert"; nullopt: no such group.
std::optional<std::string> members_of(const FindOptions& options, const std::string& group) {
  std::istringstream lines(text_of(options.etc_root + "/group").value_or(""));
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(group + ":")) return line.substr(line.find_last_of(':') + 1);
  return std::nullopt;
}

// Serial numbers come from the device: only plain ones may appear in a rule and a file name.
bool is_plain(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
  });
}

// A rule for this device alone: by its serial number, else by its USB socket.
void add_own_rule(PermissionFacts& facts, const FoundDevice& device) {
  const bool by_serial = is_plain(device.serial);
  const bool is_tty = !device.tty.empty() && facts.node == device.tty;
  const std::string_view attribute = is_tty ? "ATTRS" : "ATTR";
  const std::string which = by_serial ? fmt::format(R"({}{{serial}}=="{}")", attribute, device.serial)
                                      : fmt::format(R"({}=="{}")", is_tty ? "KERNELS" : "KERNEL", device.port_path);
  facts.own_rule = fmt::format(R"(SUBSYSTEM=="{}", {}{{idVendor}}=="{:04x}", {}{{idProduct}}=="{:04x}", {}, )"
                               R"(GROUP="{}", MODE="0660", TAG+="uaccess")",
                               is_tty ? "tty" : "usb", attribute, device.usb_vendor, attribute, device.usb_product,
                               which, kRulesGroup);
  facts.own_rule_name = fmt::format("70-footlight-{}.rules", by_serial ? device.serial : "port-" + device.port_path);
}

std::string write_own_rule(const PermissionFacts& facts) {
  return fmt::format("echo '{}' | sudo tee /etc/udev/rules.d/{}", facts.own_rule, facts.own_rule_name);
}

}  // namespace

NodeOwner owner_of(const FindOptions& options, const std::string& node) {
  if (options.node_owner) return options.node_owner(node);
  struct stat found {};
  if (::stat(node.c_str(), &found) != 0) return {};
  const group* const named = ::getgrgid(found.st_gid);
  return {named != nullptr ? named->gr_name : std::to_string(found.st_gid), found.st_mode & 07777u};
}

std::string installed_udev_rules(const FindOptions& options) {
  std::vector<std::string> roots = {options.etc_root};
  roots.insert(roots.end(), options.lib_roots.begin(), options.lib_roots.end());
  for (const std::string& root : roots)
    if (auto text = text_of(root + "/udev/rules.d/70-footlight.rules")) return std::move(*text);
  return {};
}

bool is_listed_in(const FindOptions& options, const std::string& group) {
  const std::string user = options.user_name.empty() ? name_of_user() : options.user_name;
  const std::string members = members_of(options, group).value_or("");
  return !user.empty() && fmt::format(",{},", members).find(fmt::format(",{},", user)) != std::string::npos;
}

RulesState rules_state(const FindOptions& options) {
  const std::string rules = installed_udev_rules(options);
  if (rules.empty()) return RulesState::kMissing;
  return rules == udev_rules_text() ? RulesState::kCurrent : RulesState::kOutdated;
}

Advice advise(const PermissionFacts& facts) {
  const std::string refused = fmt::format("{}: {}", facts.node, std::strerror(facts.error));
  if (facts.error != EACCES && facts.error != EPERM) return {refused, {}};
  if (facts.is_root)
    return {fmt::format("{}, although this user is root; a sandbox or an ACL refuses it", refused), {}};
  const bool is_excluded = !facts.own_rule.empty();
  const bool joining_helps = facts.group_opens && facts.group != "root" && (facts.group == kRulesGroup || is_excluded);
  if (joining_helps && facts.in_group)
    return {fmt::format("{}, although its group {} may open it and this user is in that group; a sandbox or an ACL "
                        "refuses it",
                        refused, facts.group),
            {}};
  if (joining_helps && facts.listed_in_group)
    return {fmt::format("{}; this session began before the user joined the group {}: log out and in again", refused,
                        facts.group),
            fmt::format("newgrp {}", facts.group)};
  if (joining_helps)
    return {fmt::format("{}; members of the group {} may open it, and this user is not one of them. It takes effect "
                        "with the next login",
                        refused, facts.group),
            fmt::format("sudo usermod -aG {} $USER", facts.group)};
  if (is_excluded && !facts.rules_group_is_there)
    return {
        fmt::format("{}; the udev rules exclude it, because many products share its ids. It needs a rule of its own, "
                    "and this machine does not have the group {} that the rule names",
                    refused, kRulesGroup),
        fmt::format("{} && {} && {}", kMakeGroup, write_own_rule(facts), kRestartUdev)};
  if (is_excluded)
    return {fmt::format("{}; the udev rules exclude it, because many products share its ids. It needs a rule of its "
                        "own",
                        refused),
            fmt::format("{} && {}", write_own_rule(facts), kApplyRules)};
  switch (facts.rules) {
    case RulesState::kMissing:
      return {fmt::format("{}; the udev rules are not installed", refused), udev_install_command()};
    case RulesState::kOutdated:
      return {fmt::format("{}; the installed udev rules are those of another version", refused),
              udev_install_command()};
    case RulesState::kCurrent: break;
  }
  if (!facts.rules_group_is_there)
    return {fmt::format("{}; the udev rules give it to the group {}, which this machine does not have", refused,
                        kRulesGroup),
            fmt::format("{} && {}", kMakeGroup, kRestartUdev)};
  return {
      fmt::format("{}; the udev rules are installed, but were not applied to it. Plugging it in again applies them too",
                  refused),
      kApplyRules};
}

PermissionFacts permission_facts(const FoundDevice& device, const std::string& node, int error,
                                 const FindOptions& options) {
  constexpr unsigned kGroupReadsAndWrites = 0060;
  PermissionFacts facts;
  facts.node = node;
  facts.error = error;
  const NodeOwner owner = owner_of(options, node);
  facts.group = owner.group;
  facts.group_opens = (owner.mode & kGroupReadsAndWrites) == kGroupReadsAndWrites;
  facts.rules = rules_state(options);
  if (device.driver_id.empty()) add_own_rule(facts, device);
  facts.is_root = options.user_name.empty() ? ::geteuid() == 0 : options.user_name == "root";
  const std::vector<std::string> groups = options.groups ? *options.groups : groups_of_process();
  facts.in_group = std::find(groups.begin(), groups.end(), facts.group) != groups.end();
  facts.listed_in_group = is_listed_in(options, facts.group);
  facts.rules_group_is_there = members_of(options, kRulesGroup).has_value();
  return facts;
}

Advice advise_on_permission(const FoundDevice& device, const std::string& node, int error, const FindOptions& options) {
  return advise(permission_facts(device, node, error, options));
}

std::string message_of(const Advice& advice) {
  return advice.remedy.empty() ? advice.reason : fmt::format("{}; run: {}", advice.reason, advice.remedy);
}

}  // namespace footlight::drivers

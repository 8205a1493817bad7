#include "tests/kernel/guest.h"

#include <cstdio>
#include <fstream>
#include <sstream>
#include <thread>

#include <sys/wait.h>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace footlight::testing {

bool eventually(const std::function<bool()>& f) {
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (!f()) {
    if (std::chrono::steady_clock::now() > give_up) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

ShellOutcome shell(const std::string& command) {
  std::ofstream("/run/footlight-command") << "cd /root\nexport USER=lighting\n" << command << "\n";
  FILE* const pipe = ::popen("sh /run/footlight-command 2>&1", "r");
  REQUIRE(pipe != nullptr);
  ShellOutcome outcome;
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) outcome.text += buffer;
  outcome.exit_code = WEXITSTATUS(::pclose(pipe));
  return outcome;
}

std::string must_shell(const std::string& command) {
  const ShellOutcome outcome = shell(command);
  REQUIRE_MESSAGE(outcome.exit_code == 0, command << ": " << outcome.text);
  return outcome.text;
}

void set_groups(const std::vector<std::string>& groups) {
  must_shell(R"(sed -i -E 's/(:|,)lighting(,|$)/\1\2/g; s/:,/:/; s/,$//' /etc/group)");
  for (const std::string& group : groups) must_shell(fmt::format("usermod -aG {} lighting", group));
}

namespace {

void reload_udev() { must_shell("udevadm control --reload && udevadm trigger && udevadm settle"); }

}  // namespace

void install_rules() {
  must_shell("cp udev/70-footlight.rules /etc/udev/rules.d/");
  reload_udev();
}

void remove_rules() {
  must_shell("rm -f /etc/udev/rules.d/7*-footlight*");
  reload_udev();
}

void take_module_away(const std::string& module) {
  must_shell(fmt::format("echo 'blacklist {0}' > /etc/modprobe.d/no-{0}.conf; modprobe -r {0}", module));
}

void give_module_back(const std::string& module) {
  must_shell(fmt::format("rm -f /etc/modprobe.d/no-{0}.conf", module));
}

void set_up_well() {
  must_shell("rm -f /etc/modprobe.d/no-*.conf /etc/udev/rules.d/7*-footlight*");
  must_shell("grep -q ^plugdev: /etc/group || groupadd --system plugdev");
  set_groups({"plugdev", "dialout"});
  install_rules();
}

std::vector<std::string> as_user(std::vector<std::string> arguments) {
  std::vector<std::string> words{"--reuid=lighting", "--regid=lighting", "--init-groups", "/usr/bin/footlight"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

std::vector<Json> json_lines(const std::string& text) {
  std::vector<Json> objects;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) objects.push_back(Json::parse(line));
  return objects;
}

std::vector<Json> devices_with(const std::string& key, const std::string& value) {
  std::vector<Json> found;
  for (Json& device : json_lines(footlight(as_user({"devices", "--json"})).out))
    if (device.value(key, "") == value) found.push_back(std::move(device));
  return found;
}

Json wait_for_device(const std::string& key, const std::string& value) {
  std::vector<Json> found;
  const bool there = eventually([&] {
    found = devices_with(key, value);
    return found.size() == 1;
  });
  REQUIRE_MESSAGE(there, "devices whose " << key << " is " << value << ": " << found.size());
  must_shell("udevadm settle");
  return devices_with(key, value).at(0);
}

Json doctor_check(const std::string& id) {
  for (Json& check : json_lines(footlight(as_user({"doctor", "--json"})).out))
    if (check.at("check") == id) return std::move(check);
  FAIL("doctor has no check " << id);
  return {};
}

}  // namespace footlight::testing

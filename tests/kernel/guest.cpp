#include "tests/kernel/guest.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
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
  std::ofstream("/run/footlight-command") << "cd /srv\nexport USER=lighting\n" << command << "\n";
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
  std::ifstream old("/etc/group");
  std::string all;
  for (std::string line; std::getline(old, line);) {
    const std::size_t members = line.rfind(':') + 1;
    std::vector<std::string> kept;
    std::istringstream names(line.substr(members));
    for (std::string name; std::getline(names, name, ',');)
      if (name != "lighting") kept.push_back(name);
    if (std::find(groups.begin(), groups.end(), line.substr(0, line.find(':'))) != groups.end())
      kept.emplace_back("lighting");
    all += fmt::format("{}{}\n", line.substr(0, members), fmt::join(kept, ","));
  }
  old.close();
  std::ofstream("/etc/group") << all;
}

void install_rules() { must_shell("cp udev/70-footlight.rules /etc/udev/rules.d/ && udevadm control --reload"); }

void remove_rules() { must_shell("rm -f /etc/udev/rules.d/7*-footlight* && udevadm control --reload"); }

// udevd caches which modules it may load until it reloads its configuration.
void take_module_away(const std::string& module) {
  must_shell(fmt::format("echo 'blacklist {0}' > /etc/modprobe.d/no-{0}.conf", module));
  must_shell(fmt::format("[ ! -d /sys/module/{0} ] || rmmod {0}; udevadm control --reload", module));
}

void give_module_back(const std::string& module) {
  must_shell(fmt::format("rm -f /etc/modprobe.d/no-{0}.conf; udevadm control --reload", module));
}

void set_up_well() {
  must_shell(
      "rm -f /etc/modprobe.d/no-*.conf /etc/udev/rules.d/7*-footlight*\n"
      "grep -q ^plugdev: /etc/group || { echo plugdev:x:46: >> /etc/group && systemctl restart systemd-udevd; }");
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

namespace {

std::vector<Json> listed_with(const std::string& key, const std::string& value) {
  must_shell("udevadm settle");
  std::vector<Json> found;
  for (Json& entry : json_lines(footlight(as_user({"devices", "--json"})).out))
    if (entry.value(key, "") == value) found.push_back(std::move(entry));
  return found;
}

}  // namespace

Json device_at(const std::string& port) {
  const std::vector<Json> found = listed_with("port", port);
  REQUIRE_MESSAGE(found.size() == 1, "devices at " << port << ": " << found.size());
  return found[0];
}

Json gpio_chip() {
  const std::vector<Json> found = listed_with("kind", "gpio");
  REQUIRE(found.size() <= 1);
  return found.empty() ? Json() : found[0];
}

void follow_advice(const std::string& port) {
  Json device = device_at(port);
  for (int step = 0; step < 3 && device.at("readiness") != "ready"; ++step) {
    must_shell(device.at("remedy"));
    device = device_at(port);
  }
  REQUIRE_MESSAGE(device.at("readiness") == "ready", device.dump());
}

std::string kernel_driver(const std::string& port) {
  std::error_code none;
  return std::filesystem::read_symlink(fmt::format("/sys/bus/usb/devices/{0}/{0}:1.0/driver", port), none).filename();
}

Json doctor_check(const std::string& id) {
  for (Json& check : json_lines(footlight(as_user({"doctor", "--json"})).out))
    if (check.at("check") == id) return std::move(check);
  FAIL("doctor has no check " << id);
  return {};
}

}  // namespace footlight::testing

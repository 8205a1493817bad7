// The guest that the tests run in: its users, groups, udev rules and modules, and the program as its users run it.
//
// The tests are root and change the machine as its administrator would; the program runs as the user `lighting`, with
// the groups that /etc/group gives that user at the moment, as after a new login.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {

using Json = nlohmann::json;

// How long anything may take that the kernel, udev or the program does by itself. Emulated processors on a busy machine
// are slow; a test that passes never waits for this.
inline constexpr std::chrono::minutes kPatience{2};

// Tries f() every 20 ms until it is true. False if it is not within kPatience.
bool eventually(const std::function<bool()>& f);

struct ShellOutcome {
  int exit_code = -1;
  std::string text;  // both of its outputs
};
// Runs a command line as root in /srv, where the project's udev/ lies, with USER=lighting.
ShellOutcome shell(const std::string& command);
// The same, for one that has to succeed.
std::string must_shell(const std::string& command);

// What the next start of the program as the user `lighting` will be a member of, beside its own group.
void set_groups(const std::vector<std::string>& groups);
// For devices that are plugged in afterwards.
void install_rules();
void remove_rules();
// Unloads a module and keeps it from being loaded by itself. `modprobe` by hand still loads it.
void take_module_away(const std::string& module);
void give_module_back(const std::string& module);
// Rules installed, the user in plugdev and dialout, modules loaded by themselves: how every test begins.
void set_up_well();

// Arguments that make Footlight (run_footlight.h) start the program as the user `lighting`.
std::vector<std::string> as_user(std::vector<std::string> arguments);

std::vector<Json> json_lines(const std::string& text);
// What `footlight devices --json` says of the device at a port ("1-1"), after udev has done its part.
Json device_at(const std::string& port);
// The same of the only GPIO chip; null where there is none, and fails the test where there are several.
Json gpio_chip();
// Runs the command that the program advises for the device until it is ready, three times at most. Fails the test where
// a command fails or the device is not ready by then.
void follow_advice(const std::string& port);
// The driver of the kernel that is bound to the device's first interface; empty: none.
std::string kernel_driver(const std::string& port);
// The outcome of one check of `footlight doctor --json`.
Json doctor_check(const std::string& id);

}  // namespace footlight::testing

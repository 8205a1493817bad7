// The guest system of the tests: its users, groups, udev rules and modules, and the program as its users run it.
//
// The tests run as root and change the machine like an administrator. The program runs as the user `lighting`, with the
// groups that /etc/group lists for that user at that time, as after a new login.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {

using Json = nlohmann::json;

// The timeout for anything that the kernel, udev or the program does by itself. Emulated processors on a busy machine
// are slow; a test that passes never waits this long.
inline constexpr std::chrono::minutes kPatience{2};

// Tries f() every 20 ms until it is true. False if it is not within kPatience.
bool eventually(const std::function<bool()>& f);

struct ShellOutcome {
  int exit_code = -1;
  std::string text;  // both of its output streams
};
// Runs a command line as root in /srv, which contains the project's udev/, with USER=lighting.
ShellOutcome shell(const std::string& command);
// As shell(), for a command that must succeed.
std::string must_shell(const std::string& command);

// The groups of the next run of the program as the user `lighting`, in addition to its own group.
void set_groups(const std::vector<std::string>& groups);
// For devices that are plugged in afterwards.
void install_rules();
void remove_rules();
// Unloads a module and prevents loading it automatically. `modprobe` by hand still loads it.
void take_module_away(const std::string& module);
void give_module_back(const std::string& module);
// Rules installed, the user in plugdev and dialout, modules loaded automatically: the start of every test.
void set_up_well();

// Arguments that make Footlight (run_footlight.h) start the program as the user `lighting`.
std::vector<std::string> as_user(std::vector<std::string> arguments);

std::vector<Json> json_lines(const std::string& text);
// The entry of `footlight devices --json` for the device at a port ("1-1"), after udev has finished.
Json device_at(const std::string& port);
// The same for the only GPIO chip; null if there is none; fails the test if there are several.
Json gpio_chip();
// Runs the command that the program advises for the device until it is ready, at most three times. Fails the test if a
// command fails or the device is not ready after that.
void follow_advice(const std::string& port);
// The kernel driver that is bound to the device's first interface; empty: none.
std::string kernel_driver(const std::string& port);
// The outcome of one check of `footlight doctor --json`.
Json doctor_check(const std::string& id);

}  // namespace footlight::testing

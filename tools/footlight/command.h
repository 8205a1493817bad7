// The structure of a subcommand of `footlight`: one file with one CommandInfo at its bottom, and one word in
// FOOTLIGHT_COMMANDS of CMakeLists.txt, from which the build generates the list that commands() returns.
//
//   void add(Arguments& arguments) {
//     auto options = std::make_shared<Options>();
//     arguments.flag("--json", options->json, "one JSON object a line");
//     arguments.job([options]() -> Result<int> { return blink(*options); });
//   }
//   extern const CommandInfo blink_command{
//       .name = "blink", .help = "...", .examples = "  footlight blink\n", .add = add};
//
// Only arguments.cpp includes the library that parses the command line, because it compiles slowly.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace CLI {
class App;
}

namespace footlight::tools {

// Exit codes of the program. A stop by SIGINT or SIGTERM is a success.
enum ExitCode : int {
  kExitOk = 0,
  kExitFailed = 1,    // the job started and did not finish, or found an error
  kExitUsage = 2,     // a wrong argument, or an error in the text of a file or endpoint
  kExitNotFound = 3,  // a named thing does not exist, or nothing was found
};
[[nodiscard]] ExitCode exit_code_of(ErrorCode code);

// Flushes standard output. False: the reader has closed the pipe, as `| head` does. Fails if it cannot be written, for
// example on a full disk.
[[nodiscard]] Result<bool> flush_output();

// Runs after the whole command line was parsed; returns an ExitCode. An error is printed and turned into an exit code.
using Job = std::function<Result<int>()>;

// The options of one subcommand. Names are as typed: "--out,-o" for an option, "FILE" for a positional argument. Values
// are written when the line is parsed and must live until then: keep them in a shared_ptr that the job holds.
class Arguments {
 public:
  Arguments(CLI::App& app, Job& chosen) : app_(app), chosen_(chosen) {}

  void flag(const std::string& names, bool& value, const std::string& help);
  // `unit` is the placeholder for the value in the help: "FILE". The initial value is the default.
  void option(const std::string& names, std::string& value, const std::string& unit, const std::string& help);
  void option(const std::string& names, int& value, int from, int to, const std::string& help);
  void option(const std::string& names, double& value, double from, double to, const std::string& help);
  void option(const std::string& names, std::optional<int>& value, int from, int to, const std::string& help);
  void option(const std::string& names, std::optional<double>& value, double from, double to, const std::string& help);
  // May be given several times, with one value each time.
  void list(const std::string& names, std::vector<std::string>& values, const std::string& unit,
            const std::string& help);
  // In the syntax of parse_duration() (duration.h); not negative.
  void duration(const std::string& names, DurationNs& value, const std::string& help);
  // A positional argument; empty if not given.
  void word(const std::string& name, std::string& value, const std::string& help);
  // Any number of positional arguments.
  void words(const std::string& name, std::vector<std::string>& values, const std::string& help);

  [[nodiscard]] Arguments subcommand(const std::string& name, const std::string& help, const std::string& examples);
  void job(Job job);

 private:
  CLI::App& app_;
  Job& chosen_;
};

struct CommandInfo {
  const char* name;      // as typed: "devices"
  const char* help;      // one line
  const char* examples;  // lines of two spaces and a command
  void (*add)(Arguments& arguments);
};

// Every command of this build, in the order of CMakeLists.txt.
[[nodiscard]] std::span<const CommandInfo* const> commands();

// Parses, runs the job, prints errors; returns what main() returns.
[[nodiscard]] int run_command_line(int argc, const char* const* argv, std::span<const CommandInfo* const> commands);

}  // namespace footlight::tools

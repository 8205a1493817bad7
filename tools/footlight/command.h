// How a subcommand of `footlight` is made: one file with one CommandInfo at its bottom, one word in FOOTLIGHT_COMMANDS
// of CMakeLists.txt, from which the build writes the list that commands() returns.
//
//   void add(Arguments& arguments) {
//     auto options = std::make_shared<Options>();
//     arguments.flag("--json", options->json, "one JSON object a line");
//     arguments.job([options]() -> Result<int> { return blink(*options); });
//   }
//   extern const CommandInfo blink_command{
//       .name = "blink", .help = "...", .examples = "  footlight blink\n", .add = add};
//
// The library that parses the command line is seen by arguments.cpp alone: it is slow to compile.
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

// What the program answers to the shell. Being told to stop by SIGINT or SIGTERM is a success.
enum ExitCode : int {
  kExitOk = 0,
  kExitFailed = 1,    // the job began and did not get to its end, or found something wrong
  kExitUsage = 2,     // a wrong argument, or a file or endpoint whose text is wrong
  kExitNotFound = 3,  // something that was named is not there, or nothing was found
};
[[nodiscard]] ExitCode exit_code_of(ErrorCode code);

// Writes out what was printed so far. False: nobody reads on, as behind `| head`. Fails where it cannot be written, as
// on a full disk.
[[nodiscard]] Result<bool> flush_output();

// Runs after the whole command line was read; returns an ExitCode. An error is printed and turned into one.
using Job = std::function<Result<int>()>;

// The options of one subcommand. Names are as typed: "--out,-o" for an option, "FILE" for a place on the line. Values
// are written when the line is parsed and have to live until then: keep them in a shared_ptr that the job holds.
class Arguments {
 public:
  Arguments(CLI::App& app, Job& chosen) : app_(app), chosen_(chosen) {}

  void flag(const std::string& names, bool& value, const std::string& help);
  // `unit` stands for the value in the help: "FILE". The value that is there already is the default.
  void option(const std::string& names, std::string& value, const std::string& unit, const std::string& help);
  void option(const std::string& names, int& value, int from, int to, const std::string& help);
  void option(const std::string& names, double& value, double from, double to, const std::string& help);
  void option(const std::string& names, std::optional<double>& value, double from, double to, const std::string& help);
  // May be given many times; one value each time.
  void list(const std::string& names, std::vector<std::string>& values, const std::string& unit,
            const std::string& help);
  // As parse_duration() reads it (duration.h); not negative.
  void duration(const std::string& names, DurationNs& value, const std::string& help);
  // A word without dashes; empty where it is not given.
  void word(const std::string& name, std::string& value, const std::string& help);
  // As many as are there.
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

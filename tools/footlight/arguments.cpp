#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>

#include <CLI/CLI.hpp>

#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

// A value below the range means "no default".
template <typename Number>
std::string with_default(const std::string& help, Number value, Number from) {
  return value < from ? help : fmt::format("{} [{}]", help, value);
}

// CLI::Range takes NaN, which is neither below nor above a range.
CLI::Validator range(double from, double to) {
  return CLI::Validator(
      [from, to](std::string& text) {
        double value = 0;
        const bool number = CLI::detail::lexical_cast(text, value);
        if (number && value >= from && value <= to) return std::string();
        return fmt::format("expected a number from {} to {}, got {}", from, to, printable_utf8(text));
      },
      "");
}

}  // namespace

ExitCode exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kBadInput: return kExitUsage;
    case ErrorCode::kNotFound: return kExitNotFound;
    case ErrorCode::kPermission:
    case ErrorCode::kDisconnected:
    case ErrorCode::kTimeout:
    case ErrorCode::kProtocol:
    case ErrorCode::kUnsupported:
    case ErrorCode::kIo: break;
  }
  return kExitFailed;
}

Result<bool> flush_output() {
  static int trouble = 0;  // errno of the first failed write; the stream itself does not keep it
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return true;
  if (trouble == 0) trouble = errno != 0 ? errno : EPIPE;
  if (trouble == EPIPE) return false;
  return fail(ErrorCode::kIo, "standard output: {}", std::strerror(trouble));
}

void Arguments::flag(const std::string& names, bool& value, const std::string& help) {
  app_.add_flag(names, value, help);
}

void Arguments::option(const std::string& names, std::string& value, const std::string& unit, const std::string& help) {
  app_.add_option(names, value, help)->type_name(unit);
}

void Arguments::option(const std::string& names, int& value, int from, int to, const std::string& help) {
  app_.add_option(names, value, with_default(help, value, from))
      ->check(CLI::Range(from, to).description(""))
      ->type_name(fmt::format("{}..{}", from, to));
}

void Arguments::option(const std::string& names, double& value, double from, double to, const std::string& help) {
  app_.add_option(names, value, with_default(help, value, from))
      ->check(range(from, to))
      ->type_name(fmt::format("{}..{}", from, to));
}

void Arguments::option(const std::string& names, std::optional<int>& value, int from, int to, const std::string& help) {
  app_.add_option(names, value, help)
      ->check(CLI::Range(from, to).description(""))
      ->type_name(fmt::format("{}..{}", from, to));
}

void Arguments::option(const std::string& names, std::optional<double>& value, double from, double to,
                       const std::string& help) {
  app_.add_option(names, value, help)
      ->check(range(from, to))
      ->type_name(fmt::format("{}..{}", from, to));
}

void Arguments::list(const std::string& names, std::vector<std::string>& values, const std::string& unit,
                     const std::string& help) {
  // One value each time, so that FILE in "--in a FILE" is a separate argument.
  app_.add_option(names, values, help)->type_name(unit)->expected(1)->take_all();
}

void Arguments::duration(const std::string& names, DurationNs& value, const std::string& help) {
  app_.add_option_function<std::string>(
          names,
          [&value, names](const std::string& text) {
            const auto duration_ns = parse_duration(text);
            if (!duration_ns) throw CLI::ValidationError(names, duration_ns.error().message);
            value = *duration_ns;
          },
          help)
      ->type_name("TIME");
}

void Arguments::word(const std::string& name, std::string& value, const std::string& help) {
  app_.add_option(name, value, help)->type_name("");
}

void Arguments::words(const std::string& name, std::vector<std::string>& values, const std::string& help) {
  app_.add_option(name, values, help)->type_name("");
}

Arguments Arguments::subcommand(const std::string& name, const std::string& help, const std::string& examples) {
  CLI::App* const sub = app_.add_subcommand(name, help);
  sub->footer("Examples:\n" + examples);
  app_.require_subcommand(1);
  return {*sub, chosen_};
}

void Arguments::job(Job job) {
  app_.callback([this_job = std::move(job), &chosen = chosen_] { chosen = this_job; });
}

int run_command_line(int argc, const char* const* argv, std::span<const CommandInfo* const> commands) {
  CLI::App app{"Footlight: a DMX bridge and fixture simulator.", "footlight"};
  app.set_version_flag("--version", "footlight " FOOTLIGHT_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Endpoints (inputs and outputs):\n"
      "  sacn:1-9              sACN universes 1 to 9, multicast       sacn:1-9@10.0.0.7     to one address\n"
      "  artnet:1-9            Art-Net, to the nodes of a universe    artnet:1-4%eth1       through one interface\n"
      "  sacn:101-109=1-9      101-109 on the wire, 1-9 in the show   enttec-pro:EN123=3    a dongle as universe 3\n"
      "  vrsl-osc:1-3          OSC of VR Stage Lighting's grid node   vrsl-osc:1-9@10.0.0.7:12001\n"
      "  log:show.dmxlog       a log file                             mock:enttec-pro       a model of a dongle\n"
      "  vrsl:1-9@f_%05d.png   pictures for VR Stage Lighting         gpio:gpiochip0/17=1.25    a line as one slot\n"
      "  osc:8000              phones, which set levels by hand       midi:NAME=1.1         faders\n"
      "\n"
      "Exit codes: 0 done, also when stopped by Ctrl-C; 1 the job failed; 2 wrong argument or file; 3 nothing found.\n"
      "'footlight COMMAND --help' shows the options and examples of a command.");
  Job chosen;
  for (const CommandInfo* command : commands) {
    CLI::App* const sub = app.add_subcommand(command->name, command->help);
    if (*command->examples != '\0') sub->footer(std::string("Examples:\n") + command->examples);
    Arguments arguments{*sub, chosen};
    command->add(arguments);
  }

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    const int code = app.exit(success);
    const auto written = flush_output();
    if (written) return code;
    std::fputs(fmt::format("footlight: {}\n", written.error().message).c_str(), stderr);
    return exit_code_of(written.error().code);
  } catch (const CLI::ParseError& error) {
    // The help and the commands of the deepest subcommand that was reached.
    const CLI::App* at = &app;
    std::string name = app.get_name();
    while (!at->get_subcommands().empty()) {
      at = at->get_subcommands().front();
      name += " " + at->get_name();
    }
    std::string trouble = error.what();
    const std::vector<std::string> unknown = at->remaining();
    const std::vector<const CLI::App*> known = at->get_subcommands([](const CLI::App*) { return true; });
    if (!unknown.empty() && !known.empty()) {
      trouble = fmt::format("there is no command \"{}\"; expected", unknown.front());
      for (const CLI::App* sub : known)
        trouble += fmt::format("{} {}", sub == known.front() ? "" : ",", sub->get_name());
    } else if (!unknown.empty() && dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
      trouble = unknown.size() == 1 ? "this argument was not expected:" : "these arguments were not expected:";
      for (const std::string& one : unknown) trouble += " '" + one + "'";
    }
    std::fputs(fmt::format("footlight: {}\nSee '{} --help'.\n", printable_line(trouble), name).c_str(), stderr);
    return kExitUsage;
  }

  try {
    Result<int> code = chosen ? chosen() : Result<int>(kExitOk);
    if (const auto written = flush_output(); code && !written) code = tl::unexpected<Error>(written.error());
    if (code) return *code;
    std::fputs(fmt::format("footlight: {}\n", printable_lines(code.error().message)).c_str(), stderr);
    return exit_code_of(code.error().code);
  } catch (const std::exception& error) {  // out of memory; nothing of ours throws
    std::fputs(fmt::format("footlight: {}\n", error.what()).c_str(), stderr);
    return kExitFailed;
  }
}

}  // namespace footlight::tools

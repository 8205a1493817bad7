// footlight doctor: finds causes of missing DMX on this machine and prints the command that fixes each.
#include <unistd.h>

#include <array>
#include <cstdio>
#include <memory>

#include "tools/footlight/command.h"
#include "tools/footlight/doctor/doctor_checks.h"
#include "tools/footlight/status/json_lines.h"

namespace footlight::tools {
namespace {

constexpr int kTitleColumns = 20;

const char* colour_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk: return "\033[32m";
    case Verdict::kWarn: return "\033[33m";
    case Verdict::kFail: return "\033[31m";
    case Verdict::kSkipped: return "\033[2m";
  }
  return "";
}

void print(const Check& check, const Outcome& outcome, bool coloured) {
  fmt::print("{}{:<8}{}{:<{}} {}\n", coloured ? colour_of(outcome.verdict) : "", name_of(outcome.verdict),
             coloured ? "\033[0m" : "", check.title, kTitleColumns, outcome.seen);
  if (!outcome.fix.empty()) fmt::print("        {:<{}} fix: {}\n", "", kTitleColumns, outcome.fix);
}

int examine(bool json) {
  const DoctorView view = this_machine();
  const bool coloured = !json && isatty(STDOUT_FILENO) != 0;
  std::array<int, 4> counts{};
  for (const Check& check : doctor_checks()) {
    const Outcome outcome = check.run(view);
    ++counts[static_cast<std::size_t>(outcome.verdict)];
    if (json) {
      fmt::print("{}\n", json_of_check(check, outcome));
    } else {
      print(check, outcome, coloured);
    }
  }
  const auto count = [&counts](Verdict verdict) { return counts[static_cast<std::size_t>(verdict)]; };
  if (!json)
    fmt::print("{} failed, {} warnings, {} ok, {} that do not apply\n", count(Verdict::kFail), count(Verdict::kWarn),
               count(Verdict::kOk), count(Verdict::kSkipped));
  return count(Verdict::kFail) == 0 ? kExitOk : kExitFailed;
}

void add(Arguments& arguments) {
  auto json = std::make_shared<bool>(false);
  arguments.flag("--json", *json, "one JSON object a line for each check");
  arguments.job([json]() -> Result<int> { return examine(*json); });
}

}  // namespace

extern const CommandInfo doctor_command{
    .name = "doctor",
    .help = "Check devices, permissions, network and timing, and print how to fix problems",
    .examples =
        "  footlight doctor\n"
        "  footlight doctor --json | jq -r 'select(.verdict == \"warn\") | .fix'\n"
        "Changes nothing and opens no device. Run it as the user that runs the bridge. Exit code 1 if a check fails.\n"
        "docs/doctor.md describes the checks.",
    .add = add,
};

}  // namespace footlight::tools

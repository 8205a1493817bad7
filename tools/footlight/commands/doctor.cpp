// footlight doctor: what of this machine stands in the way, and the command that mends it.
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
  if (!outcome.mend.empty()) fmt::print("        {:<{}} mend: {}\n", "", kTitleColumns, outcome.mend);
}

int examine(bool json) {
  const DoctorView view = this_machine();
  const bool coloured = !json && isatty(STDOUT_FILENO) != 0;
  std::array<int, 4> counts{};
  for (const Check& check : doctor_checks()) {
    const Outcome outcome = check.snapshot(view);
    ++counts[static_cast<std::size_t>(outcome.verdict)];
    if (json) {
      fmt::print("{}\n", json_of_check(check, outcome));
    } else {
      print(check, outcome, coloured);
    }
  }
  const auto count = [&counts](Verdict verdict) { return counts[static_cast<std::size_t>(verdict)]; };
  if (!json)
    fmt::print("{} failed, {} to look at, {} ok, {} that do not apply\n", count(Verdict::kFail), count(Verdict::kWarn),
               count(Verdict::kOk), count(Verdict::kSkipped));
  return count(Verdict::kFail) == 0 ? kExitOk : kExitFailed;
}

void add(Arguments& arguments) {
  auto json = std::make_shared<bool>(false);
  arguments.flag("--json", *json, "one JSON object a check and line");
  arguments.job([json]() -> Result<int> { return examine(*json); });
}

}  // namespace

extern const CommandInfo doctor_command{
    .name = "doctor",
    .help = "Check devices, permissions, network and timing, and say how to mend what is wrong",
    .examples =
        "  footlight doctor\n"
        "  footlight doctor --json | jq -r 'select(.verdict == \"warn\") | .mend'\n"
        "Changes nothing and opens no device. Run it as the user that runs the bridge. Exit code 1 where a check "
        "fails.",
    .add = add,
};

}  // namespace footlight::tools

// footlight log compare: the slots that differ between two times of a log, or between two logs.
#include <memory>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "tools/footlight/commands/log_command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/monitor/level_moment.h"
#include "tools/footlight/monitor/slot_meanings.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

struct CompareArguments {
  std::string a;
  std::string b;  // empty: the same file
  DurationNs at_ns = -1;
  DurationNs with_ns = -1;
  std::string rig;
  int tolerance = 0;
  ReadArguments read;
  bool json = false;
};

void print_text(const CompareArguments& arguments, const MomentDifference& difference, const SlotMeanings& names) {
  fmt::print("A: {} at {}\nB: {} at {}\n", printable_utf8(arguments.a), show_duration(arguments.at_ns),
             printable_utf8(arguments.b), show_duration(arguments.with_ns));
  auto slot = difference.slots.begin();
  for (const MomentDifference::Count& one : difference.universes) {
    const char* only = one.in_a && one.in_b ? "" : one.in_a ? ", no frame in B" : ", no frame in A";
    fmt::print("universe {}: {}{}\n", one.universe,
               one.slots == 0   ? std::string("no slot differs")
               : one.slots == 1 ? std::string("1 slot differs")
                                : fmt::format("{} slots differ", one.slots),
               only);
    for (int i = 0; i < one.slots; ++i, ++slot) {
      const std::string name = text_of(names.of_slot(slot->universe, slot->address));
      fmt::print("  {:>9}  {:3} -> {:3}{}{}\n", fmt::format("{}.{}", slot->universe, slot->address), slot->a, slot->b,
                 name.empty() ? "" : "  ", printable_utf8(name));
    }
  }
  fmt::print("{}\n", difference.equal() ? "equal" : "different");
}

void print_json(const CompareArguments& arguments, const MomentDifference& difference, const SlotMeanings& names) {
  using Json = nlohmann::ordered_json;
  Json universes = Json::array();
  for (const MomentDifference::Count& one : difference.universes) {
    universes.push_back({{"universe", one.universe}, {"slots", one.slots}, {"in_a", one.in_a}, {"in_b", one.in_b}});
  }
  Json slots = Json::array();
  for (const SlotDifference& one : difference.slots) {
    Json slot = {{"universe", one.universe}, {"address", one.address}, {"a", one.a}, {"b", one.b}};
    if (const auto uses = names.of_slot(one.universe, one.address); !uses.empty()) {
      Json list = Json::array();
      for (const SlotName& use : uses) list.push_back({{"fixture", use.fixture}, {"parameter", use.parameter}});
      slot["uses"] = std::move(list);
    }
    slots.push_back(std::move(slot));
  }
  const Json line = {{"a", arguments.a},
                     {"b", arguments.b},
                     {"at_ns", arguments.at_ns},
                     {"with_ns", arguments.with_ns},
                     {"equal", difference.equal()},
                     {"universes", std::move(universes)},
                     {"slots", std::move(slots)}};
  fmt::print("{}\n", line.dump(-1, ' ', false, Json::error_handler_t::replace));
}

Result<int> compare(CompareArguments arguments) {
  if (arguments.a.empty() || arguments.at_ns < 0) {
    return fail(ErrorCode::kBadInput,
                "log compare: expected a file and --at, for example 'footlight log compare show.dmxlog --at 10s "
                "--with 25s'");
  }
  if (arguments.b.empty() && arguments.with_ns < 0) {
    return fail(ErrorCode::kBadInput, "log compare: expected --with TIME for a second moment of {}, or a second file",
                printable_utf8(arguments.a));
  }
  if (arguments.b.empty()) arguments.b = arguments.a;
  if (arguments.with_ns < 0) arguments.with_ns = arguments.at_ns;
  FL_ASSIGN(const drivers::CaptureOptions read, arguments.read.read());
  FL_ASSIGN(const SlotMeanings names, SlotMeanings::of(arguments.rig));
  FL_ASSIGN(LogReader reader, read_input(arguments.a, read, arguments.read));
  FL_ASSIGN(const LevelMoment a, moment_of(reader, arguments.at_ns));
  if (arguments.b != arguments.a) {
    FL_ASSIGN(reader, read_input(arguments.b, read, arguments.read));
  }
  FL_ASSIGN(const LevelMoment b, moment_of(reader, arguments.with_ns));
  const MomentDifference difference = compare_moments(a, b, arguments.tolerance);
  if (arguments.json) {
    print_json(arguments, difference, names);
  } else {
    print_text(arguments, difference, names);
  }
  return difference.equal() ? kExitOk : kExitFailed;
}

}  // namespace

void add_log_compare(Arguments& arguments) {
  Arguments comparer =
      arguments.subcommand("compare", "List the slots that differ between two times of a log, or between two logs",
                           "  footlight log compare show.dmxlog --at 10s --with 25s\n"
                           "  footlight log compare show.dmxlog --at 10s --with 25s --rig rig.toml\n"
                           "  footlight log compare monday.dmxlog tuesday.dmxlog --at 1m30s --values 1 --json\n"
                           "Levels are those of the newest frame of each universe at the time; a universe without a\n"
                           "frame has level 0. Exit code 0 if no slot differs, else 1.");
  auto options = std::make_shared<CompareArguments>();
  comparer.word("A", options->a, kLogFileHelp);
  comparer.word("B", options->b, "the same; default: A");
  comparer.duration("--at", options->at_ns, "time in A");
  comparer.duration("--with", options->with_ns, "time in B; default with two files: that of --at");
  comparer.option("--rig", options->rig, "FILE", "a rig that names the fixture and the parameter of each slot");
  comparer.option("--values", options->tolerance, 0, 255, "tolerance of levels");
  options->read.add(comparer);
  comparer.flag("--json", options->json, "one JSON object");
  comparer.job([options]() -> Result<int> { return compare(*options); });
}

}  // namespace footlight::tools

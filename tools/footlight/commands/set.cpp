// footlight set: sets levels in the running bridge.
#include <cstdio>
#include <memory>

#include "tools/footlight/command.h"
#include "tools/footlight/hand/hand_client.h"
#include "tools/footlight/hand/hand_text.h"

namespace footlight::tools {
namespace {

struct Options {
  HandClientOptions bridge;
  std::vector<std::string> assignments;
  int priority = kHandPriorityDefault;
  bool list = false;
};

Result<int> set(const Options& options) {
  if (options.assignments.empty() && !options.list) {
    return fail(ErrorCode::kBadInput,
                "set: expected at least one assignment, for example 'footlight set 1.17=255'; 'footlight set --list' "
                "prints what is set");
  }
  FL_ASSIGN(HandClient client, HandClient::connect(options.bridge, "set"));
  if (!options.assignments.empty()) {
    HandCommand command;
    FL_ASSIGN(command.levels, client.assignments(options.assignments));
    command.priority = static_cast<std::uint8_t>(options.priority);
    FL_TRY(client.send(command));
    client.report("set by hand: " + counted_slots(command.levels));
  }
  if (options.list) {
    FL_ASSIGN(const std::string page, client.page());
    std::fputs(page.c_str(), stdout);
  }
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.words("ASSIGNMENT", options->assignments, "1.17=255, 1.1-12=50%, 'Mover 3:Tilt=30' and so on");
  arguments.option("--priority", options->priority, 1, kPriorityMax,
                   "priority of these slots; consoles have 100 [150]");
  arguments.flag("--list", options->list, "print what is set, as JSON");
  add_hand_options(arguments, options->bridge);
  arguments.job([options]() -> Result<int> { return set(*options); });
}

}  // namespace

extern const CommandInfo set_command{
    .name = "set",
    .help = "Set levels in the running bridge by hand",
    .examples =
        "  footlight set 1.17=255                     address 17 of universe 1\n"
        "  footlight set 1.1-12=50% 2.*=0             a range; a universe\n"
        "  footlight set 1.1=255,128,0                addresses 1, 2 and 3\n"
        "  footlight set 1.17+18=30000                16 bits\n"
        "  footlight set 'Mover 3:Tilt=30' 'Par *:Dimmer=80%' --rig rig.toml\n"
        "  footlight set --list                       what is set\n"
        "The slots keep these levels until 'footlight release', or until the bridge ends. Attributes are in the units "
        "of\n"
        "the fixture's definition: degrees, 0 to 1, the place on a wheel from 1. See docs/control.md.",
    .add = add,
};

}  // namespace footlight::tools

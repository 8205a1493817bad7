// footlight release: gives slots back to the other inputs of the running bridge.
#include <memory>

#include "tools/footlight/command.h"
#include "tools/footlight/hand/hand_client.h"
#include "tools/footlight/hand/hand_text.h"

namespace footlight::tools {
namespace {

struct Options {
  HandClientOptions bridge;
  std::vector<std::string> targets;
  bool all = false;
};

Result<int> release(const Options& options) {
  if (options.targets.empty() != options.all) {
    return fail(ErrorCode::kBadInput,
                "release: expected slots or fixtures, for example 'footlight release 1.17 1.1-12', or --all alone");
  }
  FL_ASSIGN(HandClient client, HandClient::connect(options.bridge, "release"));
  HandCommand command;
  command.action = options.all ? HandAction::kReleaseAll : HandAction::kRelease;
  FL_ASSIGN(command.levels, client.targets(options.targets));
  FL_TRY(client.send(command));
  client.report("given back: " + (options.all ? "all slots that were set by hand" : counted_slots(command.levels)));
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.words("TARGET", options->targets, "1.17, 1.1-12, 1.*, 'Mover 3', 'Mover *:Tilt'");
  arguments.flag("--all", options->all, "everything that was set by hand");
  add_hand_options(arguments, options->bridge);
  arguments.job([options]() -> Result<int> { return release(*options); });
}

}  // namespace

extern const CommandInfo release_command{
    .name = "release",
    .help = "Give slots that were set by hand back to the other inputs",
    .examples =
        "  footlight release 1.17 1.1-12\n"
        "  footlight release 'Mover 3' --rig rig.toml\n"
        "  footlight release --all\n"
        "The other senders have the slots again. Without another sender a slot keeps its level: set it to 0 first, if "
        "it\n"
        "is to go out. A blackout stays; see 'footlight blackout off'.",
    .add = add,
};

}  // namespace footlight::tools

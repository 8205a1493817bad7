// footlight fade: changes levels in the running bridge over a time.
#include <memory>

#include <fmt/format.h>

#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/hand/hand_client.h"
#include "tools/footlight/hand/hand_text.h"

namespace footlight::tools {
namespace {

struct Options {
  HandClientOptions bridge;
  std::vector<std::string> assignments;
  int priority = kHandPriorityDefault;
  DurationNs over_ns = 3 * kNsPerS;
};

Result<int> fade(const Options& options) {
  if (options.assignments.empty()) {
    return fail(ErrorCode::kBadInput,
                "fade: expected at least one assignment, for example 'footlight fade 1.17=255 --over 3s'");
  }
  if (options.over_ns > kHandFadeMaxNs) return fail(ErrorCode::kBadInput, "--over: expected at most 24h");
  FL_ASSIGN(HandClient client, HandClient::connect(options.bridge, "fade"));
  HandCommand command;
  FL_ASSIGN(command.levels, client.assignments(options.assignments));
  command.priority = static_cast<std::uint8_t>(options.priority);
  command.over_ns = options.over_ns;
  FL_TRY(client.send(command));
  client.report(fmt::format("fading over {}: {}", show_duration(command.over_ns), counted_slots(command.levels)));
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.words("ASSIGNMENT", options->assignments, "1.17=255, 1.1-12=50%, 'Mover 3:Tilt=30' and so on");
  arguments.duration("--over", options->over_ns, "duration of the fade, at most 24h [3s]");
  arguments.option("--priority", options->priority, 1, kPriorityMax,
                   "priority of these slots; consoles have 100 [150]");
  add_hand_options(arguments, options->bridge);
  arguments.job([options]() -> Result<int> { return fade(*options); });
}

}  // namespace

extern const CommandInfo fade_command{
    .name = "fade",
    .help = "Fade levels in the running bridge by hand",
    .examples =
        "  footlight fade 1.17=255 --over 3s\n"
        "  footlight fade 'Mover *:Tilt=30' 'Mover *:Dimmer=100%' --over 10s --rig rig.toml\n"
        "A fade starts from the level of that moment. A later 'set' or 'fade' of the same slots replaces it. The "
        "command\n"
        "returns at once; the bridge fades. Places on wheels are set at once.",
    .add = add,
};

}  // namespace footlight::tools

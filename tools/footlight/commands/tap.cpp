// footlight tap: sets the tempo of the made-up inputs of the running bridge or window.
#include <memory>

#include "sim/tempo.h"
#include "tools/footlight/command.h"
#include "tools/footlight/hand/hand_client.h"

namespace footlight::tools {
namespace {

struct Options {
  HandClientOptions bridge;
  std::optional<double> beats_a_minute;
};

Result<int> tap(const Options& options) {
  FL_ASSIGN(const HandClient client, HandClient::connect(options.bridge, "tap"));
  FL_TRY(
      client.send({.action = HandAction::kTempo, .levels = {}, .beats_a_minute = options.beats_a_minute.value_or(0)}));
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.option("--beats", options->beats_a_minute, kTempoMin, kTempoMax, "this many beats a minute, no tap");
  arguments.option("--socket", options->bridge.socket, "FILE", "the socket of the bridge or window, if several run");
  arguments.job([options]() -> Result<int> { return tap(*options); });
}

}  // namespace

extern const CommandInfo tap_command{
    .name = "tap",
    .help = "Tap the tempo of made-up inputs (mock:chase, mock:sine), or set it",
    .examples =
        "  footlight tap                  one tap: the mean of the last ones is the tempo\n"
        "  footlight tap --beats 128      128 beats a minute\n"
        "A pause of more than 2 s begins anew. Faders and buttons tap with 'to = \"tempo\"' in a control map.",
    .add = add,
};

}  // namespace footlight::tools

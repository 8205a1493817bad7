// footlight blackout: makes everything dark in the running bridge, and ends that.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "fixtures/simulate/hand_fixtures.h"
#include "sim/system_clock.h"
#include "tools/footlight/command.h"
#include "tools/footlight/hand/hand_client.h"
#include "tools/footlight/hand/hand_text.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kHoldDefaultNs = 2 * kNsPerS;
constexpr int kRenewalsPerHold = 4;
constexpr DurationNs kStepMaxNs = 100 * kNsPerMs;
constexpr const char* kIsOn = "blackout is on; 'footlight blackout off' ends it";

struct Options {
  HandClientOptions bridge;
  std::string word;
  DurationNs within_ns = kHoldDefaultNs;
};

// Renews the hold until this program is stopped, in whatever way. Blackout follows.
Result<int> hold(const Options& options, const HandClient& client) {
  if (options.within_ns < kHandHoldMinNs || options.within_ns > kHandHoldMaxNs) {
    return fail(ErrorCode::kBadInput, "--within: expected 200ms to 1h");
  }
  StopSignal signal;
  SystemClock clock;
  FL_TRY(client.send({.action = HandAction::kHold, .over_ns = options.within_ns, .levels = {}}));
  std::fputs(
      "The show goes on while this command runs. When it ends, everything is dark. 'footlight blackout off' ends "
      "the hold.\n",
      stderr);
  const HandCommand renew{.action = HandAction::kRenew, .over_ns = options.within_ns, .levels = {}};
  TimeNs next_ns = clock.now_ns();
  while (!signal.came()) {
    next_ns += options.within_ns / kRenewalsPerHold;
    // The sleep goes on after a signal, so it is short.
    while (!signal.came() && clock.now_ns() < next_ns) {
      clock.sleep_until_ns(std::min(next_ns, clock.now_ns() + kStepMaxNs));
    }
    if (signal.came()) break;
    const Status renewed = client.send(renew);
    if (signal.came()) break;  // it interrupts the call
    if (!renewed && renewed.error().code == ErrorCode::kBadInput) {
      std::fprintf(stderr, "footlight: %s\n", renewed.error().message.c_str());
      return kExitOk;
    }
    // A timeout may pass; a bridge that is gone does not come back dark by itself if it was stopped.
    if (!renewed && renewed.error().code != ErrorCode::kTimeout) return tl::unexpected(renewed.error());
  }
  FL_TRY(client.send({.action = HandAction::kBlackout, .levels = {}}));
  fmt::print(stderr, "{}\n", kIsOn);
  return kExitOk;
}

Result<int> blackout(const Options& options) {
  const std::string& word = options.word;
  if (!word.empty() && word != "on" && word != "off" && word != "hold") {
    return fail(ErrorCode::kBadInput, "blackout {}: expected on, off or hold", word);
  }
  FL_ASSIGN(HandClient client, HandClient::connect(options.bridge, word.empty() ? "blackout" : "blackout " + word));
  if (word == "hold") return hold(options, client);
  HandCommand command;
  command.action = word == "off" ? HandAction::kLift : HandAction::kBlackout;
  if (word != "off") {
    FL_ASSIGN(const fixtures::Rig* rig, client.named_rig());
    if (rig != nullptr) command.levels = fixtures::dark_levels(*rig);
    if (rig != nullptr && command.levels.empty()) {
      return fail(ErrorCode::kBadInput,
                  "{}: no fixture and no display has an address; without --rig every slot is set to 0",
                  options.bridge.rig);
    }
  }
  // A part adds to the blackout of those before.
  for (const HandCommand& part : hand_parts(std::move(command))) FL_TRY(client.send(part));
  HandClient::print_done(word == "off" ? "blackout is off" : kIsOn);
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.word("WORD", options->word, "on, off or hold [on]");
  arguments.option("--socket", options->bridge.socket, "FILE", "the socket of the bridge, if several run");
  arguments.option(
      "--rig", options->bridge.rig, "FILE",
      "on: only the dimmers, emitters and pixels of this rig, so that heads do not turn; default: every slot");
  arguments.duration("--within", options->within_ns, "hold: dark this long after the command has died [2s]");
  arguments.job([options]() -> Result<int> { return blackout(*options); });
}

}  // namespace

extern const CommandInfo blackout_command{
    .name = "blackout",
    .help = "Everything dark in the running bridge, above all inputs",
    .examples =
        "  footlight blackout                         every slot of every universe at 0\n"
        "  footlight blackout on --rig rig.toml       only what makes light: dimmers, emitters, pixels\n"
        "  footlight blackout off\n"
        "  footlight blackout hold                    a dead man's switch: dark when this command ends, in any way\n"
        "Blackout stays until 'blackout off', also over a restart of the bridge. Levels that are set meanwhile show "
        "when\n"
        "it ends.",
    .add = add,
};

}  // namespace footlight::tools

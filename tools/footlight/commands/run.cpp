// footlight run: runs the bridge.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "drivers/wait/real_time.h"
#include "fixtures/model/rig.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge/bridge.h"
#include "tools/footlight/bridge/live_show.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/bridge/output_guard.h"
#include "tools/footlight/bridge/show_file.h"
#include "tools/footlight/command.h"
#include "tools/footlight/paths.h"

namespace footlight::tools {
namespace {

struct Options {
  std::string show;
  std::vector<std::string> ins;
  std::vector<std::string> outs;
  std::vector<std::string> backups;
  bool demo = false;
  bool wait_for_device = false;
  bool blackout_on_exit = false;
  bool json = false;
  bool no_realtime = false;
  std::string socket = "auto";
  std::string metrics;
  std::string log_format;
  std::string log_level = "info";
  std::string flashes = "off";
  std::string rig;
  DurationNs run_for_ns = kTimeNever;
};

// The show file, if there is one, and the ports of the command line. `file`: empty for none.
Result<Show> show_of(const Options& options, const std::string& file) {
  Show show;
  if (!file.empty()) {
    FL_ASSIGN(show, load_show(file));
  }
  for (const std::string& text : options.ins) {
    InPlan plan;
    FL_ASSIGN(plan.endpoint, parse_port(text));
    plan.options.wait_for_device = options.wait_for_device;
    show.ins.push_back(std::move(plan));
  }
  if (options.demo) {
    InPlan plan;
    plan.demo = true;
    plan.options.log_loop = true;
    show.ins.push_back(std::move(plan));
  }
  const auto add_out = [&](const std::string& text, const std::string& standby_for) -> Status {
    OutPlan plan;
    FL_ASSIGN(plan.endpoint, parse_port(text));
    plan.options.wait_for_device = options.wait_for_device;
    plan.options.blackout_on_exit = options.blackout_on_exit;
    plan.standby_for = standby_for;
    show.outs.push_back(std::move(plan));
    return {};
  };
  for (const std::string& text : options.outs) FL_TRY(add_out(text, ""));
  if (options.backups.size() > options.outs.size()) {
    return fail(ErrorCode::kBadInput, "--backup {}: expected an --out for each --backup", options.backups.back());
  }
  for (std::size_t i = 0; i < options.backups.size(); ++i) FL_TRY(add_out(options.backups[i], options.outs[i]));
  FL_TRY(order_standbys(show));
  if (show.outs.empty()) {
    return fail(ErrorCode::kBadInput,
                "run: expected a show file, or at least one --out, for example 'footlight run --in sacn:1-9 --out "
                "enttec-pro'; without --in the levels come from 'footlight set'");
  }
  return show;
}

// The flash guard; null without --flashes. Prints the number of fixtures that it cannot hold back.
Result<std::shared_ptr<OutputGuard>> guard_of(const Options& options) {
  FL_ASSIGN(const FlashMode mode, flash_mode_of(options.flashes));
  if (mode == FlashMode::kOff) return std::shared_ptr<OutputGuard>();
  if (options.rig.empty()) {
    return fail(ErrorCode::kBadInput,
                "--flashes {}: expected --rig FILE as well, which defines the channels that make light",
                options.flashes);
  }
  FL_ASSIGN(const fixtures::Rig rig, fixtures::load_rig(options.rig));
  FL_ASSIGN(auto guard, OutputGuard::make(rig, mode));
  const int only = guard->watched_only_count();
  if (mode == FlashMode::kLimit && only != 0) {
    fmt::print(stderr,
               "footlight: {} of {} fixtures have no channel that only dims; they are checked, but not held back\n",
               only, guard->fixture_count());
  }
  return guard;
}

Result<int> run(const Options& options) {
  std::string file = options.show;
  if (file.empty() && options.ins.empty() && options.outs.empty() && options.backups.empty() && !options.demo) {
    FL_ASSIGN(file, find_show_file());
  }
  FL_ASSIGN(const Show show, show_of(options, file));
  Bridge bridge;
  FL_ASSIGN(const EventFormat event_format, event_format_of(options.log_format));
  if (!options.json || !options.log_format.empty()) bridge.event_format = event_format;
  FL_ASSIGN(bridge.event_level, notice_level_of(options.log_level));
  bridge.json = options.json;
  bridge.run_for_ns = options.run_for_ns;
  bridge.socket = options.socket == "none" ? "" : options.socket;
  bridge.metrics = options.metrics;
  if (!options.rig.empty()) {
    std::error_code trouble;
    bridge.rig = std::filesystem::canonical(options.rig, trouble).string();
    if (trouble) return fail(ErrorCode::kNotFound, "--rig {}: {}", options.rig, trouble.message());
  }
  bridge.merge = show.merge;

  StopSignal signal;
  ReloadSignal reload;
  FL_TRY(reload.opened());
  SystemClock clock;
  drivers::want_real_time(options.no_realtime ? 0 : drivers::kRealTimePriority);
  LiveShow live(clock, [&signal] { return signal.came(); });
  FL_ASSIGN(const std::shared_ptr<OutputGuard> guard, guard_of(options));
  live.guard_with(guard);
  bridge.guard = guard;
  if (const Status opened = live.open(show); !opened) {
    if (signal.came()) return kExitOk;
    const bool of_file = opened.error().code == ErrorCode::kBadInput && !file.empty();
    return tl::unexpected(Error{opened.error().code, (of_file ? file + ": " : "") + opened.error().message});
  }
  bridge.live = &live;
  bridge.reload = &reload;
  if (!file.empty()) bridge.load_show = [&] { return show_of(options, file); };
  FL_ASSIGN(const BridgeReport report, run_bridge(bridge, clock, signal));
  FL_TRY(check_recordings(report));
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.word("SHOW", options->show,
                 "a show file (TOML) with the ports; default: ~/.config/footlight/show.toml or "
                 "/etc/footlight/show.toml");
  arguments.list("--in,-i", options->ins, "ENDPOINT", "an input; may be given several times");
  arguments.list("--out,-o", options->outs, "ENDPOINT", "an output; may be given several times");
  arguments.list("--backup", options->backups, "ENDPOINT",
                 "a standby output: the first --backup for the first --out, and so on");
  arguments.flag("--demo", options->demo, "the demo show as an input, repeated");
  arguments.flag("--wait-for-device", options->wait_for_device, "start even if a device is not plugged in yet");
  arguments.flag("--blackout-on-exit", options->blackout_on_exit, "devices: send zeros at the end, do not hold levels");
  arguments.duration("--for", options->run_for_ns, "stop after this time, for example 90s or 1h30m");
  arguments.option("--flashes", options->flashes, "WORD",
                   "harmful flashes: off, warn, or limit, which holds them back; needs --rig [off]");
  arguments.option("--rig", options->rig, "FILE",
                   "the rig that the outputs drive, for --flashes and for names in 'footlight set'");
  arguments.flag("--json", options->json, "status and events as JSON, one object a line");
  arguments.option("--log-level", options->log_level, "WORD", "lowest level of events: info, warning or error [info]");
  arguments.option("--log-format", options->log_format, "WORD",
                   "events as text, json or journal (systemd's fields); default: journal in a service, else text");
  arguments.option("--metrics", options->metrics, "ADDRESS",
                   "serve metrics for Prometheus on 127.0.0.1:9477, or on unix: and a file name");
  arguments.option("--socket", options->socket, "FILE", "socket for 'footlight monitor': a file, auto or none [auto]");
  arguments.flag("--no-realtime", options->no_realtime, "do not request real-time priority");
  arguments.job([options]() -> Result<int> { return run(*options); });
}

}  // namespace

extern const CommandInfo run_command{
    .name = "run",
    .help = "Bridge: pass DMX from inputs to outputs until stopped",
    .examples =
        "  footlight run --in sacn:1 --out enttec-pro            sACN universe 1 to the dongle that is plugged in\n"
        "  footlight run --in enttec-pro --out sacn:1            the dongle's input to sACN\n"
        "  footlight run --in sacn:1-9 --out artnet:1-9@10.9.0.255\n"
        "  footlight run --in sacn:101-109=1-9 --out sacn:1-9    renumbered\n"
        "  footlight run show.toml --json\n"
        "  footlight run show.toml --flashes limit --rig rig.toml    at most three flashes a second\n"
        "  footlight run --in sacn:1 --out enttec-pro:EN1 --backup enttec-pro:EN2    EN2 takes over when EN1 fails\n"
        "Several inputs are merged by priority, then highest level. When no sender is left, the last levels are held.\n"
        "'footlight set', fade, blackout and scene set levels in the running bridge, with or without a console.\n"
        "SIGHUP or 'footlight reload' reads the show file again; ports with unchanged lines are not touched.\n"
        "Ctrl-C or SIGTERM stops cleanly (exit code 0); another one after a second at once.",
    .add = add,
};

}  // namespace footlight::tools

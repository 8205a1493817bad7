// footlight run: the bridge.
#include <algorithm>
#include <memory>

#include "drivers/wait/real_time.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge.h"
#include "tools/footlight/command.h"
#include "tools/footlight/open_ports.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/show_file.h"

namespace footlight::tools {
namespace {

struct Options {
  std::string show;
  std::vector<std::string> ins;
  std::vector<std::string> outs;
  bool demo = false;
  bool wait_for_device = false;
  bool blackout_on_exit = false;
  bool json = false;
  bool no_realtime = false;
  std::string socket = "auto";
  std::string metrics;
  std::string log_format;
  std::string log_level = "info";
  DurationNs run_for_ns = kTimeNever;
};

Result<Show> show_of(const Options& options) {
  Show show;
  if (!options.show.empty()) {
    FL_ASSIGN(show, load_show(options.show));
  }
  for (const std::string& text : options.ins) {
    InPlan plan;
    FL_ASSIGN(plan.endpoint, parse_port(text));
    plan.options.wait_for_device = options.wait_for_device;
    show.ins.push_back(std::move(plan));
  }
  for (const std::string& text : options.outs) {
    OutPlan plan;
    FL_ASSIGN(plan.endpoint, parse_port(text));
    plan.options.wait_for_device = options.wait_for_device;
    plan.options.blackout_on_exit = options.blackout_on_exit;
    show.outs.push_back(std::move(plan));
  }
  if (options.show.empty() && options.ins.empty() && options.outs.empty() && !options.demo) {
    FL_ASSIGN(const std::string found, find_show_file());
    FL_ASSIGN(show, load_show(found));
  }
  if ((show.ins.empty() && !options.demo) || show.outs.empty()) {
    return fail(ErrorCode::kBadInput,
                "run: expected a show file, or at least one --in and one --out, as in "
                "'footlight run --in sacn:1-9 --out enttec-pro'");
  }
  return show;
}

Result<int> run(const Options& options) {
  FL_ASSIGN(const Show show, show_of(options));
  StopSignal signal;
  SystemClock clock;
  PortOpener opener(clock);
  drivers::want_real_time(options.no_realtime ? 0 : drivers::kRealTimePriority);
  Bridge bridge;
  bridge.merge = show.merge;
  bridge.json = options.json;
  bridge.run_for_ns = options.run_for_ns;
  FL_ASSIGN(const EventFormat event_format, event_format_of(options.log_format));
  if (!options.json || !options.log_format.empty()) bridge.event_format = event_format;
  bridge.socket = options.socket == "none" ? "" : options.socket;
  bridge.metrics = options.metrics;
  FL_ASSIGN(bridge.event_level, notice_level_of(options.log_level));
  for (Universe universe = kUniverseMin; universe <= show.universe_count; ++universe) {
    bridge.universes.push_back(universe);
  }
  const auto add_universes = [&bridge](std::span<const Universe> universes) {
    bridge.universes.insert(bridge.universes.end(), universes.begin(), universes.end());
  };
  for (const InPlan& plan : show.ins) {
    FL_ASSIGN(std::unique_ptr<Source> source, opener.open_source(plan.endpoint, plan.options));
    add_universes(source->universes());
    bridge.sources.push_back(std::move(source));
  }
  if (options.demo) {
    InOptions looped;
    looped.log_loop = true;
    FL_ASSIGN(std::unique_ptr<Source> source, open_demo_source(looped));
    add_universes(source->universes());
    bridge.sources.push_back(std::move(source));
  }
  for (const OutPlan& plan : show.outs) add_universes(plan.endpoint.show_universes());
  bridge.universes = sorted_once(std::move(bridge.universes));
  for (const Universe universe : show.ltp) {
    if (!std::binary_search(bridge.universes.begin(), bridge.universes.end(), universe)) {
      return fail(ErrorCode::kBadInput, "{}: [merge]: ltp names universe {}, which no port carries", options.show,
                  universe);
    }
  }
  bridge.ltp = show.ltp;
  for (const OutPlan& plan : show.outs) {
    FL_ASSIGN(std::unique_ptr<Sink> sink, opener.open_sink(plan.endpoint, bridge.universes, plan.options));
    bridge.sinks.push_back(std::move(sink));
  }
  FL_ASSIGN(const BridgeReport report, run_bridge(bridge, clock, signal));
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.word("SHOW", options->show,
                 "a show file (TOML) that names the ports; by default ~/.config/footlight/show.toml or "
                 "/etc/footlight/show.toml");
  arguments.list("--in,-i", options->ins, "ENDPOINT", "where frames come from; may be given many times");
  arguments.list("--out,-o", options->outs, "ENDPOINT", "where they go; may be given many times");
  arguments.flag("--demo", options->demo, "the demo show as an input, over and over");
  arguments.flag("--wait-for-device", options->wait_for_device, "begin although a device is not plugged in yet");
  arguments.flag("--blackout-on-exit", options->blackout_on_exit, "devices: send zeros at the end, not the last look");
  arguments.duration("--for", options->run_for_ns, "stop after this time, as in 90s or 1h30m");
  arguments.flag("--json", options->json, "status and events as JSON, one object a line");
  arguments.flag("--no-realtime", options->no_realtime, "carry frames at normal priority, and do not ask for more");
  arguments.option("--metrics", options->metrics, "PLACE",
                   "for Prometheus: 127.0.0.1:9477, or unix: and a file name; otherwise nowhere");
  arguments.option("--socket", options->socket, "FILE",
                   "where 'footlight monitor' finds this bridge: a socket file, auto or none");
  arguments.option("--log-format", options->log_format, "WORD",
                   "events as text, json or journal (systemd's fields); the journal by itself where it listens");
  arguments.option("--log-level", options->log_level, "WORD", "write events from info, warning or error on");
  arguments.job([options]() -> Result<int> { return run(*options); });
}

}  // namespace

extern const CommandInfo run_command{
    .name = "run",
    .help = "Bridge: pass DMX from inputs to outputs until stopped",
    .examples =
        "  footlight run --in sacn:1 --out enttec-pro            sACN universe 1 to the dongle that is plugged in\n"
        "  footlight run --in enttec-pro --out sacn:1            the other way round\n"
        "  footlight run --in sacn:1-9 --out artnet:1-9@10.9.0.255\n"
        "  footlight run --in sacn:101-109=1-9 --out sacn:1-9    renumbered\n"
        "  footlight run show.toml --json\n"
        "Several inputs are merged by priority, then highest level. When a sender vanishes its last look stays.\n"
        "Ctrl-C or SIGTERM stops cleanly (exit code 0); a second one at once.",
    .add = add,
};

}  // namespace footlight::tools

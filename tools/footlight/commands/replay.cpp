// footlight replay: plays a log with its original timing.
#include <cstdio>
#include <memory>

#include "sim/core/counted.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge/bridge.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/command.h"

namespace footlight::tools {
namespace {

struct Options {
  std::string file;
  bool demo = false;
  std::vector<std::string> outs;
  std::string universes;
  DurationNs start_ns = 0;
  DurationNs stop_ns = kTimeNever;
  DurationNs run_for_ns = kTimeNever;
  double speed = 1.0;
  bool loop = false;
  bool blackout_on_exit = false;
  bool json = false;
};

Result<int> replay(const Options& options) {
  if (options.file.empty() != options.demo || options.outs.empty()) {
    return fail(ErrorCode::kBadInput,
                "replay: expected one log, or --demo, and at least one --out, for example "
                "'footlight replay show.dmxlog --out sacn:1-9'");
  }
  FL_ASSIGN(const std::vector<Endpoint> endpoints, parse_ports(options.outs));
  InOptions in;
  in.log_start_ns = options.start_ns;
  in.log_stop_ns = options.stop_ns;
  in.log_loop = options.loop;
  in.log_speed = options.speed;
  if (!options.universes.empty()) {
    auto renumber = parse_wire_universes(options.universes);
    if (!renumber) return fail(ErrorCode::kBadInput, "--universes: {}", renumber.error().message);
    in.log_renumber = std::move(*renumber);
  }

  StopSignal signal;
  SystemClock clock;
  PortOpener opener(clock);
  Bridge bridge;
  bridge.json = options.json;
  bridge.run_for_ns = options.run_for_ns;
  bridge.stop_at_end = true;
  std::unique_ptr<Source> source;
  if (options.demo) {
    FL_ASSIGN(source, open_demo_source(in));
  } else {
    Endpoint log;
    log.kind = EndpointKind::kFile;
    log.target = options.file;
    FL_ASSIGN(source, opener.open_source(log, in));
  }
  bridge.universes.assign(source->universes().begin(), source->universes().end());
  if (bridge.universes.empty()) {
    return fail(ErrorCode::kBadInput, "{}: has no universes to play; see 'footlight log info {}'", source->name(),
                options.file);
  }
  bridge.sources.push_back(std::move(source));
  for (const Endpoint& endpoint : endpoints) {
    const auto universes = endpoint.show_universes();
    bridge.universes.insert(bridge.universes.end(), universes.begin(), universes.end());
  }
  bridge.universes = sorted_once(std::move(bridge.universes));
  OutOptions out;
  out.blackout_on_exit = options.blackout_on_exit;
  for (const Endpoint& endpoint : endpoints) {
    FL_ASSIGN(std::unique_ptr<Sink> sink, opener.open_sink(endpoint, bridge.universes, out));
    bridge.sinks.push_back(std::move(sink));
  }
  FL_ASSIGN(const BridgeReport report, run_bridge(bridge, clock, signal));
  FL_TRY(check_recordings(report));
  const std::uint64_t damaged = report.status.ports.front().port.rejected;
  if (damaged == 0) return kExitOk;
  fmt::print(stderr, "footlight: {} of the log skipped; see 'footlight log info --check {}'\n",
             counted(damaged, "damaged part"), options.file);
  return kExitFailed;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.word("FILE", options->file,
                 "a DMX log, an OLA show file, a capture (pcap, pcapng, .sr) or a sound map (.toml)");
  arguments.flag("--demo", options->demo, "the demo show instead of a file");
  arguments.list("--out,-o", options->outs, "ENDPOINT", "an output; may be given several times");
  arguments.duration("--at", options->start_ns, "start at this time of the log, with all levels of that moment");
  arguments.duration("--until", options->stop_ns, "end at this time of the log");
  arguments.option("--speed", options->speed, 0.001, 1'000.0, "playback speed; 2 is twice as fast");
  arguments.flag("--loop", options->loop, "repeat until stopped");
  arguments.duration("--for", options->run_for_ns, "stop after this time");
  arguments.option("--universes", options->universes, "LIST", "only these (1-3), or renumbered (1-3=11-13)");
  arguments.flag("--blackout-on-exit", options->blackout_on_exit, "devices: send zeros at the end");
  arguments.flag("--json", options->json, "status and events as JSON, one object a line");
  arguments.job([options]() -> Result<int> { return replay(*options); });
}

}  // namespace

extern const CommandInfo replay_command{
    .name = "replay",
    .help = "Play a log to outputs, with its original timing",
    .examples =
        "  footlight replay show.dmxlog --out sacn:1-9\n"
        "  footlight replay show.dmxlog --at 12.5s --until 1m30s --loop --out enttec-pro\n"
        "  footlight replay foh.show --universes 1-2=11-12 --speed 0.5 --out artnet:11-12@10.0.0.7\n"
        "  footlight replay --demo --out sacn:1\n"
        "Ends with the log, or with Ctrl-C. The last levels are held at the end, unless --blackout-on-exit is given.",
    .add = add,
};

}  // namespace footlight::tools

// footlight record: records the frames of inputs as they arrive.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "sim/dmx_log/log_ports.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge/bridge.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"

namespace footlight::tools {
namespace {

struct Options {
  std::vector<std::string> ins;
  std::string out;
  bool overwrite = false;
  bool changes_only = false;
  bool wait_for_device = false;
  bool json = false;
  DurationNs run_for_ns = kTimeNever;
};

// A tap: takes every frame before the merge, so that the log keeps senders and priorities. As a sink it only gets time.
class Recorder final : public Sink, public FrameReceiver {
 public:
  explicit Recorder(std::unique_ptr<LogSink> log) : log_(std::move(log)) {}

  void receive(const FrameView& frame) override { (void)log_->send(frame.stamp_ns, {&frame, 1}); }  // see state()

  [[nodiscard]] std::string name() const override { return log_->name(); }
  [[nodiscard]] int poll_fd() const override { return log_->poll_fd(); }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return log_->next_deadline_ns(); }
  [[nodiscard]] PortState state() const override { return log_->state(); }
  [[nodiscard]] std::string trouble() const override { return log_->trouble(); }
  [[nodiscard]] PortCounters counters() const override { return log_->counters(); }
  Status send(TimeNs, std::span<const FrameView>) override { return {}; }
  Status poll(TimeNs now_ns) override { return log_->poll(now_ns); }
  [[nodiscard]] std::span<const Universe> universes() const override { return {}; }
  void close(TimeNs now_ns) override { log_->close(now_ns); }
  [[nodiscard]] LogWriterStats stats() const { return log_->stats(); }

 private:
  std::unique_ptr<LogSink> log_;
};

Result<int> record(const Options& options) {
  if (options.ins.empty() || options.out.empty()) {
    return fail(
        ErrorCode::kBadInput,
        "record: expected at least one --in and a file after -o, for example 'footlight record --in sacn:1-9 -o "
        "show.dmxlog'");
  }
  FL_ASSIGN(const std::vector<Endpoint> endpoints, parse_ports(options.ins));
  for (const Endpoint& endpoint : endpoints) {
    std::error_code ignored;
    if (endpoint.kind == EndpointKind::kFile && std::filesystem::equivalent(endpoint.target, options.out, ignored)) {
      return fail(ErrorCode::kBadInput, "{}: is both input and output; name another output", options.out);
    }
  }
  StopSignal signal;
  SystemClock clock;
  PortOpener opener(clock, [&signal] { return signal.came(); });
  Bridge bridge;
  bridge.json = options.json;
  bridge.run_for_ns = options.run_for_ns;
  bridge.stop_at_end = true;  // if every input is a log
  bridge.stop_at_lost_sink = true;  // a log that cannot be written never comes back
  InOptions in_options;
  in_options.wait_for_device = options.wait_for_device;
  in_options.yields = true;  // a bridge keeps its unicast frames
  for (const Endpoint& endpoint : endpoints) {
    auto opened = opener.open_source(endpoint, in_options);
    if (!opened && signal.came()) return kExitOk;
    FL_ASSIGN(std::unique_ptr<Source> source, std::move(opened));
    bridge.universes.insert(bridge.universes.end(), source->universes().begin(), source->universes().end());
    bridge.sources.push_back(std::move(source));
  }
  bridge.universes = sorted_once(std::move(bridge.universes));

  LogSinkOptions log;
  log.universes = bridge.universes;
  log.start_ns = clock.now_ns();
  log.writer.wall_start_unix_ns = wall_clock_unix_ns();
  log.keep_empty = false;
  log.writer.overwrite = options.overwrite;
  log.writer.keep_repeats = !options.changes_only;
  FL_ASSIGN(std::unique_ptr<LogSink> sink, LogSink::create(options.out, log));
  auto recorder = std::make_unique<Recorder>(std::move(sink));
  const Recorder& kept = *recorder;
  bridge.tap = recorder.get();
  bridge.sinks.push_back(std::move(recorder));

  FL_ASSIGN(const BridgeReport report, run_bridge(bridge, clock, signal));
  if (!kept.trouble().empty()) {
    return fail(ErrorCode::kIo, "{}: the recording ended early, after {}: {}", options.out,
                show_duration(report.elapsed_ns), kept.trouble());
  }
  const LogWriterStats stats = kept.stats();
  const std::uint64_t lost = kept.counters().dropped;
  if (!options.json && (stats.frames != 0 || lost != 0 || stats.not_levels != 0)) {
    fmt::print(
        stderr, "{}: {} frames, {} of them with changes, {} bytes{}{}\n", options.out, stats.frames, stats.changes,
        stats.bytes, lost == 0 ? "" : fmt::format("; {} frames lost, the disk was too slow", lost),
        stats.not_levels == 0 ? "" : fmt::format("; {} frames of per-address priorities left out", stats.not_levels));
  }
  if (lost != 0) return kExitFailed;
  if (stats.frames != 0) return kExitOk;
  return fail(
      ErrorCode::kNotFound,
      "{}: nothing was recorded, and no file was written: no frames arrived; 'footlight discover' lists senders, "
      "'footlight monitor' shows what a running bridge receives",
      options.out);
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.list("--in,-i", options->ins, "ENDPOINT", "an input to record; may be given several times");
  arguments.option("--out,-o", options->out, "FILE", "the log to write, for example show.dmxlog");
  arguments.duration("--for", options->run_for_ns, "stop after this time, for example 60s");
  arguments.flag("--overwrite", options->overwrite, "replace an existing log");
  arguments.flag("--changes-only", options->changes_only, "leave out frames that repeat the levels before them");
  arguments.flag("--wait-for-device", options->wait_for_device, "start even if a device is not plugged in yet");
  arguments.flag("--json", options->json, "status and events as JSON, one object a line");
  arguments.job([options]() -> Result<int> { return record(*options); });
}

}  // namespace

extern const CommandInfo record_command{
    .name = "record",
    .help = "Record inputs to a log, with the time of each frame",
    .examples =
        "  footlight record --in sacn:1-9 -o show.dmxlog\n"
        "  footlight record --in enttec-pro --in artnet:2-4 -o both.dmxlog --for 60s\n"
        "Frames are recorded as received, before the merge, with sender and priority. To record the merged levels use\n"
        "'footlight run ... --out log:FILE'.\n"
        "Ctrl-C ends the recording. A killed recorder leaves FILE.part, which every command reads, and loses less than "
        "a\n"
        "second. If the disk is full the recording ends, with FILE.part up to there and exit code 1.",
    .add = add,
};

}  // namespace footlight::tools

// Runs a pump until it is told to stop, and says how it goes: what `run`, `record` and `replay` have in common.
//
// On a terminal one line is rewritten every two seconds; with json a line is printed every two seconds and at each
// event, on standard output; otherwise only events (event_log.h) and a summary are printed. Events, status and summary
// for people go to standard error. A thread of its own prints, so that a terminal that hangs does not hold up the pump;
// lines that it cannot take in time are dropped and counted.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"
#include "sim/merge.h"
#include "sim/pump.h"
#include "tools/footlight/bridge/event_log.h"
#include "tools/footlight/bridge/live_show.h"
#include "tools/footlight/bridge/output_guard.h"
#include "tools/footlight/bridge/show_file.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {

struct Bridge {
  // Required.
  std::vector<std::unique_ptr<Source>> sources;
  std::vector<std::unique_ptr<Sink>> sinks;
  std::vector<Universe> universes;  // of the buffer; any order, repeats allowed, not empty
  // Optional: in place of all three, ports that follow a show file. `load_show` reads it anew, on a thread of its own,
  // when `reload` has a wish; without it there is nothing to read.
  LiveShow* live = nullptr;
  std::function<Result<Show>()> load_show;
  ReloadSignal* reload = nullptr;
  // Optional.
  MergeOptions merge;
  FrameReceiver* tap = nullptr;
  bool stop_at_end = false;
  DurationNs run_for_ns = kTimeNever;
  bool json = false;
  std::optional<EventFormat> event_format;       // not set: text; with json none, since they are on standard output
  NoticeLevel event_level = NoticeLevel::kInfo;  // of those that are written; json has all
  // Where it shows its status (status_pages.h): a socket file; "": nowhere; "auto": in the folder of
  // make_socket_folder(), or nowhere where there is none.
  std::string socket;
  std::shared_ptr<const OutputGuard> guard;  // whose counts /metrics shows; null: none
  std::string metrics;  // where /metrics alone is shown, as HttpServer::listen() takes it; "": nowhere
};

struct BridgeReport {
  PumpStatus status;          // after the sinks were closed
  DurationNs elapsed_ns = 0;  // from start to stop
};

// `signal`: made before the ports were opened, so that a Ctrl-C during that is not lost. Prints the summary.
[[nodiscard]] Result<BridgeReport> run_bridge(Bridge& bridge, Clock& clock, StopSignal& signal);

// Universe numbers in use: ascending, once each.
[[nodiscard]] std::vector<Universe> sorted_once(std::vector<Universe> universes);

}  // namespace footlight::tools

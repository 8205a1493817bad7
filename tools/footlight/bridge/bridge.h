// Runs a pump until a stop request, and reports its status: the common part of `run`, `record` and `replay`.
//
// On a terminal one status line is rewritten every two seconds. With json a line is printed on standard output every
// two seconds and at each event. Otherwise only events (event_log.h) and a summary are printed. Events, the status line
// and the summary go to standard error. A separate thread prints, so that a blocked terminal does not delay the pump;
// lines that cannot be printed in time are dropped and counted.
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
  // Optional: replaces all three with ports that follow a show file. After a request of `reload`, `load_show` reads the
  // file again, on a separate thread. Null or empty: no reload.
  LiveShow* live = nullptr;
  std::function<Result<Show>()> load_show;
  ReloadSignal* reload = nullptr;
  // Optional.
  MergeOptions merge;
  FrameReceiver* tap = nullptr;
  bool stop_at_end = false;
  bool stop_at_lost_sink = false;  // ends when one of `sinks` is lost
  DurationNs run_for_ns = kTimeNever;
  bool json = false;
  std::optional<EventFormat> event_format;       // default: text; with json none (events are on stdout)
  NoticeLevel event_level = NoticeLevel::kInfo;  // lowest level that is written; json has all
  // Socket file for the status pages (status_pages.h). "": none. "auto": in the folder of make_socket_folder(), none if
  // there is no folder.
  std::string socket;
  std::shared_ptr<const OutputGuard> guard;  // its counters are part of /metrics; null: none
  std::string rig;      // the rig that the outputs drive, for commands of the hand with names of fixtures; "": unknown
  std::string metrics;  // address of a server with /metrics alone, as for HttpServer::listen(); "": none
};

struct BridgeReport {
  PumpStatus status;          // after the sinks were closed
  DurationNs elapsed_ns = 0;  // from start to stop
};

// `signal` must be created before the ports are opened, so that a Ctrl-C in between is not lost. Prints the summary.
[[nodiscard]] Result<BridgeReport> run_bridge(Bridge& bridge, Clock& clock, StopSignal& signal);

// kIo, with the reason, if a log, or pictures in files, that the bridge wrote are incomplete.
Status check_recordings(const BridgeReport& report);

// Sorts and removes duplicates.
[[nodiscard]] std::vector<Universe> sorted_once(std::vector<Universe> universes);

}  // namespace footlight::tools

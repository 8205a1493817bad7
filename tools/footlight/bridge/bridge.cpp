#include "tools/footlight/bridge/bridge.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <thread>

#include <unistd.h>

#include "drivers/wait/epoll_waiter.h"
#include "drivers/wait/real_time.h"
#include "sim/core/no_signals.h"
#include "sim/universes.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/bridge/service.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/hand/hand_desk.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/status/json_lines.h"
#include "tools/footlight/status/status_pages.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kStatusPeriodNs = 2 * kNsPerS;
constexpr DurationNs kPumpSilentMaxNs = 5 * kNsPerS;  // latest_status() is at most two status periods of 1 s old
constexpr std::size_t kEventsMax = 64;

void print_json(const std::string& line) {
  std::fputs((line + "\n").c_str(), stdout);
  std::fflush(stdout);  // readers of a pipe need the line at once
}

// Prints events and status, and notifies the service manager, on its own thread.
class Reporter {
 public:
  Reporter(const Bridge& bridge, Clock& clock)
      : clock_(clock),
        json_(bridge.json),
        rewrite_(!bridge.json && isatty(STDERR_FILENO) != 0),
        event_format_(bridge.event_format.value_or(bridge.json ? EventFormat::kNone : EventFormat::kText)),
        event_level_(bridge.event_level),
        run_for_ns_(bridge.run_for_ns) {}
  ~Reporter() { stop(); }
  Reporter(const Reporter&) = delete;
  Reporter& operator=(const Reporter&) = delete;

  // From any thread: takes a copy and returns.
  void report(const Notice& notice) {
    const std::lock_guard lock(mutex_);
    if (events_.size() < kEventsMax) {
      events_.emplace_back(notice, wall_clock_unix_ns());
    } else {
      ++events_lost_;
    }
    wake_.notify_one();
  }

  // Any thread.
  Service& service() { return service_; }

  void start(Pump& pump) {
    pump_ = &pump;
    start_ns_ = clock_.now_ns();
    const NoSignals for_the_thread;
    thread_ = std::thread([this] { run(); });
  }

  void stop() {
    if (!thread_.joinable()) return;
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_one();
    thread_.join();
    if (line_shown_) std::fputs("\r\033[K", stderr);
  }

 private:
  void run() {
    const DurationNs alive_period_ns = service_.alive_period_ns();
    service_.ready();
    if (json_) print_json(json_of_ready());
    TimeNs status_ns = start_ns_ + kStatusPeriodNs;
    TimeNs alive_ns = alive_period_ns == kTimeNever ? kTimeNever : start_ns_;
    TimeNs end_ns = run_for_ns_ == kTimeNever ? kTimeNever : start_ns_ + run_for_ns_;
    bool reported_given_up = false;
    (void)pump_->latest_status();  // requests the first one
    while (true) {
      std::vector<Event> events;
      std::uint64_t events_lost = 0;
      bool last = false;
      {
        std::unique_lock lock(mutex_);
        const TimeNs next_ns = std::min({status_ns, alive_ns, end_ns});
        const auto patience = std::chrono::nanoseconds(std::max<DurationNs>(next_ns - clock_.now_ns(), 0));
        wake_.wait_for(lock, patience, [this] { return stopping_ || !events_.empty(); });
        std::swap(events, events_);
        std::swap(events_lost, events_lost_);
        last = stopping_;
      }
      for (const Event& event : events) print_event(event);
      if (events_lost != 0) {
        const std::string text = fmt::format("{} more events were not printed", events_lost);
        print_event({{.level = NoticeLevel::kWarning, .id = "events-lost", .text = text}, wall_clock_unix_ns()});
      }
      const TimeNs now_ns = clock_.now_ns();
      if (now_ns >= end_ns) {
        pump_->request_stop();
        end_ns = kTimeNever;
      }
      if (now_ns >= status_ns && !last) {
        const PumpStatus status = pump_->latest_status();
        print_status(status);
        report_silent_inputs(status);
        status_ns = now_ns + kStatusPeriodNs;
        if (!reported_given_up && drivers::real_time_given_up() != 0) {
          reported_given_up = true;
          report({.level = NoticeLevel::kWarning,
                  .id = "realtime-given-up",
                  .text = fmt::format("a thread used the CPU for {} without a pause and went back to normal priority",
                                      show_duration(drivers::kRealTimeRunMaxNs))});
        }
      }
      if (now_ns >= alive_ns && !last) {
        // This thread must not report a blocked pump as alive.
        if (now_ns - pump_->latest_status().stamp_ns < kPumpSilentMaxNs) service_.alive();
        alive_ns = now_ns + alive_period_ns;
      }
      if (last) break;
    }
    service_.stopping();
  }

  // An input without frames usually has no sender yet, or uses the wrong network.
  void report_silent_inputs(const PumpStatus& status) {
    if (status.stamp_ns == 0) return;
    for (const PortStatus& port : status.ports) {
      if (port.is_sink || port.universes.empty()) continue;
      const auto known = std::find(silent_.begin(), silent_.end(), port.name);
      const bool waits = (port.state == PortState::kWaiting || port.state == PortState::kWorking) &&
                         port.name.rfind("log:", 0) != 0;  // a log has no sender
      if (port.frames > 0 && known != silent_.end()) {
        silent_.erase(known);
        const std::string text = fmt::format("{}: receives frames now", port.name);
        report({.level = NoticeLevel::kInfo, .id = "first-frames", .text = text, .port = port.name});
      } else if (port.frames == 0 && waits && !checked_silence_) {
        silent_.push_back(port.name);
        const std::string text = fmt::format("{}: no frames yet; waiting for a sender of universe {}", port.name,
                                             show_universes(universes_of(port)));
        report({.level = NoticeLevel::kInfo, .id = "no-frames-yet", .text = text, .port = port.name});
      }
    }
    checked_silence_ = true;
  }

  static std::vector<Universe> universes_of(const PortStatus& port) {
    std::vector<Universe> universes;
    for (const PortUniverseStatus& universe : port.universes) universes.push_back(universe.universe);
    return sorted_once(std::move(universes));
  }

  void print_event(const Event& event) {
    if (json_) print_json(json_of_notice(event));
    if (event.level < event_level_ || event_format_ == EventFormat::kNone) return;
    if (line_shown_) std::fputs("\r\033[K", stderr);
    line_shown_ = false;
    write_event(event, event_format_);
  }

  void print_status(const PumpStatus& status) {
    const std::string line = status_line(status);
    service_.status(line);
    if (json_) {
      print_json(json_of_status(status));
    } else if (rewrite_) {
      std::fputs(fmt::format("\r\033[K{}", line).c_str(), stderr);
      line_shown_ = true;
    }
  }

  Clock& clock_;
  const bool json_;
  const bool rewrite_;
  const EventFormat event_format_;
  const NoticeLevel event_level_;
  const DurationNs run_for_ns_;
  Service service_;
  Pump* pump_ = nullptr;
  TimeNs start_ns_ = 0;
  bool line_shown_ = false;  // of the thread, then of stop()
  bool checked_silence_ = false;
  std::vector<std::string> silent_;  // inputs that have been reported as silent

  std::mutex mutex_;  // guards what follows
  std::condition_variable wake_;
  std::vector<Event> events_;
  std::uint64_t events_lost_ = 0;
  bool stopping_ = false;

  std::thread thread_;
};

// The first line of a log file, so that a waiting bridge does not seem dead.
void report_started(const std::vector<const Source*>& sources, const std::vector<const Sink*>& sinks,
                    Reporter& reporter) {
  std::string from, to;
  for (const Source* source : sources) from += fmt::format("{}{}", from.empty() ? "" : ", ", source->name());
  for (const Sink* sink : sinks) to += fmt::format("{}{}", to.empty() ? "" : ", ", sink->name());
  if (from.empty()) from = "'footlight set'";
  const std::string text = fmt::format("from {} to {}; Ctrl-C or SIGTERM stops", from, to);
  reporter.report({.level = NoticeLevel::kInfo, .id = "started", .text = text});
}

// An output without an input is usually a typing mistake, unless all levels are set by hand.
void report_unfed(const std::vector<const Source*>& sources, const std::vector<const Sink*>& sinks,
                  Reporter& reporter) {
  if (std::all_of(sources.begin(), sources.end(), [](const Source* source) { return source->universes().empty(); })) {
    return;
  }
  const auto fed = [&](Universe universe) {
    return std::any_of(sources.begin(), sources.end(), [&](const Source* source) {
      const auto universes = source->universes();
      return std::find(universes.begin(), universes.end(), universe) != universes.end();
    });
  };
  for (const Sink* sink : sinks) {
    std::vector<Universe> unfed;
    for (const Universe universe : sink->universes())
      if (!fed(universe)) unfed.push_back(universe);
    if (unfed.empty()) continue;
    const std::string name = sink->name();
    const std::string text = fmt::format("{}: no input receives universe {}", name, show_universes(unfed));
    reporter.report({.level = NoticeLevel::kWarning, .id = "universe-unfed", .text = text, .port = name});
  }
}

// Reads the show file again on request, on its own thread, because devices take time to open.
class Reloader {
 public:
  Reloader(const Bridge& bridge, Pump& pump, StatusPages& pages, Reporter& reporter)
      : bridge_(bridge), pump_(pump), pages_(pages), reporter_(reporter) {
    if (bridge_.reload == nullptr) return;
    if (bridge_.load_show) pages_.request_reload = [this] { bridge_.reload->request(); };
    const NoSignals for_the_thread;
    thread_ = std::thread([this] { run(); });
  }
  // After the pump has stopped.
  ~Reloader() {
    if (!thread_.joinable()) return;
    stopping_.store(true);
    bridge_.reload->end();
    thread_.join();
  }
  Reloader(const Reloader&) = delete;
  Reloader& operator=(const Reloader&) = delete;

 private:
  void run() {
    while (true) {
      const ReloadSignal::Request request = bridge_.reload->wait();
      if (request == ReloadSignal::Request::kNothing) return;
      if (request == ReloadSignal::Request::kStop) {
        pump_.request_stop();
        continue;
      }
      reporter_.service().reloading();
      pages_.reloading.store(true);
      reload();
      pages_.reloading.store(false);
      reporter_.service().ready();
    }
  }

  void reload() {
    if (!bridge_.load_show) {
      refuse("this bridge was started without a show file, so it cannot reload one");
      return;
    }
    const Result<Show> show = bridge_.load_show();
    if (!show) {
      refuse(show.error().message);
      return;
    }
    const Result<ShowChange> change = bridge_.live->change_to(*show, pump_, [this] { return stopping_.load(); });
    if (!change) {
      refuse(change.error().message);
      return;
    }
    for (const std::string& trouble : change->troubles) {
      reporter_.report({.level = NoticeLevel::kError, .id = "port-not-opened", .text = trouble});
    }
    const std::string text = fmt::format("show file read again: {} ports opened, {} closed, {} unchanged",
                                         change->opened, change->closed, change->kept);
    pages_.reloads.fetch_add(1);
    pages_.set_reload_trouble("");
    reporter_.report({.level = NoticeLevel::kInfo, .id = "reloaded", .text = text});
    if (change->opened + change->closed != 0) report_unfed(bridge_.live->sources(), bridge_.live->sinks(), reporter_);
  }

  void refuse(const std::string& why) {
    pages_.reload_failures.fetch_add(1);
    pages_.set_reload_trouble(why);
    const std::string text = fmt::format("show file not used, nothing changes: {}", why);
    reporter_.report({.level = NoticeLevel::kError, .id = "reload-refused", .text = text});
  }

  const Bridge& bridge_;
  Pump& pump_;
  StatusPages& pages_;
  Reporter& reporter_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

struct Servers {
  std::vector<std::unique_ptr<HttpServer>> list;
  std::string socket;  // the file; empty: none
};

Result<Servers> serve(const Bridge& bridge, const StatusPages& pages) {
  Servers servers;
  if (!bridge.metrics.empty()) {
    FL_ASSIGN(auto server, HttpServer::listen("--metrics", bridge.metrics, [&pages](const HttpRequest& request) {
                return pages.answer_metrics(request);
              }));
    servers.list.push_back(std::move(server));
  }
  const auto handler = [&pages](const HttpRequest& request) { return pages.answer(request); };
  if (bridge.socket == "auto") {
    const std::string folder = make_socket_folder();
    if (folder.empty()) return servers;
    servers.socket = fmt::format("{}/{}", folder, kSocketName);
    auto server = HttpServer::listen("--socket", "unix:" + servers.socket, handler);
    if (!server) {
      // Several bridges on one machine: the first has the plain name, the others have their process id in it.
      servers.socket = fmt::format("{}/run-{}.sock", folder, getpid());
      server = HttpServer::listen("--socket", "unix:" + servers.socket, handler);
    }
    if (server) servers.list.push_back(std::move(*server));
    if (!server) servers.socket.clear();
  } else if (!bridge.socket.empty()) {
    servers.socket = bridge.socket;
    FL_ASSIGN(auto server, HttpServer::listen("--socket", "unix:" + bridge.socket, handler));
    servers.list.push_back(std::move(server));
  }
  return servers;
}

// Whether a sink writes a log, pictures or a video, which somebody wants to read afterwards.
bool is_written(std::string_view sink) {
  if (sink.starts_with("log:")) return true;
  const std::size_t at = sink.find('@');
  if (!sink.starts_with("vrsl:") || at == std::string_view::npos) return false;
  const std::string_view target = sink.substr(at + 1);
  return !target.starts_with("/dev/") && std::filesystem::path(target.substr(0, target.find('?'))).has_extension();
}

}  // namespace

Status check_recordings(const BridgeReport& report) {
  for (const PortStatus& port : report.status.ports) {
    if (!port.is_sink || !is_written(port.name) || port.state != PortState::kGone) continue;
    return fail(ErrorCode::kIo, "{}: the recording is incomplete: {}", port.name, port.trouble);
  }
  return {};
}

std::vector<Universe> sorted_once(std::vector<Universe> universes) {
  std::sort(universes.begin(), universes.end());
  universes.erase(std::unique(universes.begin(), universes.end()), universes.end());
  return universes;
}

Result<BridgeReport> run_bridge(Bridge& bridge, Clock& clock, StopSignal& signal) {
  std::shared_ptr<Universes> universes;
  if (bridge.live != nullptr) {
    universes = bridge.live->buffer();
  } else {
    FL_ASSIGN(universes, Universes::make(bridge.universes));
  }
  FL_ASSIGN(const std::unique_ptr<drivers::EpollWaiter> waiter, drivers::EpollWaiter::make());
  Reporter reporter(bridge, clock);
  PumpOptions options;
  options.merge = bridge.merge;
  options.stop_at_end = bridge.stop_at_end;
  Pump* running = nullptr;
  options.on_notice = [&](const Notice& notice) {
    reporter.report(notice);
    const bool ends = bridge.stop_at_lost_sink && notice.id == "port-lost" &&
                      std::any_of(bridge.sinks.begin(), bridge.sinks.end(),
                                  [&](const auto& sink) { return sink->name() == notice.port; });
    if (ends && running != nullptr) running->request_stop();
  };
  Pump pump(universes, clock, *waiter, options);
  running = &pump;
  for (const auto& source : bridge.sources) pump.add_source(*source);
  for (const auto& sink : bridge.sinks) pump.add_sink(*sink);
  if (bridge.tap != nullptr) pump.add_tap(*bridge.tap);
  std::vector<const Source*> sources;
  std::vector<const Sink*> sinks;
  for (const auto& source : bridge.sources) sources.push_back(source.get());
  for (const auto& sink : bridge.sinks) sinks.push_back(sink.get());
  if (bridge.live != nullptr) {
    bridge.live->add_to(pump);
    sources = bridge.live->sources();
    sinks = bridge.live->sinks();
  }

  HandDesk desk(pump, clock, options.on_notice);
  if (bridge.live != nullptr) {
    bridge.live->after_move = [&desk] { desk.follow_pump(); };
    bridge.live->hand_link().taker = &desk;
    desk.share_tempo(bridge.live->tempo());
  }
  StatusPages pages(pump, clock);
  pages.guard = bridge.guard;
  pages.hand = &desk;
  pages.rig = bridge.rig;
  FL_ASSIGN(const Servers servers, serve(bridge, pages));
  if (!servers.socket.empty() && desk.remember_in(servers.socket + ".blackout")) {
    reporter.report({.level = NoticeLevel::kWarning,
                     .id = "starts-dark",
                     .text = "a blackout was on when this bridge ended: it starts dark; 'footlight blackout off' ends "
                             "the blackout"});
  }

  if (!bridge.json) report_started(sources, sinks, reporter);  // with json there is the line "ready"
  report_unfed(sources, sinks, reporter);
  const TimeNs start_ns = clock.now_ns();
  reporter.start(pump);
  const Status granted = drivers::enter_real_time();
  pages.real_time.store(drivers::is_real_time());
  if (!granted) {
    reporter.report({.level = NoticeLevel::kWarning, .id = "realtime-refused", .text = granted.error().message});
  }
  {
    const Reloader reloader(bridge, pump, pages, reporter);
    signal.stops(&pump);
    pump.run();
    signal.stops(nullptr);
  }
  if (bridge.live != nullptr) bridge.live->hand_link().taker = nullptr;
  drivers::leave_real_time();
  BridgeReport report;
  report.elapsed_ns = clock.now_ns() - start_ns;
  reporter.stop();
  report.status = pump.status();
  if (bridge.json) {
    print_json(json_of_summary(report.status, report.elapsed_ns));
  } else {
    std::fputs(summary_text(report.status, report.elapsed_ns).c_str(), stderr);
  }
  return report;
}

}  // namespace footlight::tools

#include "tools/footlight/status/metrics.h"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "tools/footlight/status/printable.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {
namespace {

// The value of a label: backslash and quote are escaped, bytes that are not UTF-8 and control characters are replaced.
std::string label_text(std::string_view text) {
  std::string escaped;
  for (const char c : printable_utf8(text)) {
    if (c == '\\' || c == '"') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

double seconds_of(std::uint64_t ns) { return static_cast<double>(ns) * 1e-9; }

class Page {
 public:
  void family(const char* name, const char* type, const char* help) {
    name_ = name;
    text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  }
  template <class Number>
  void value(const std::string& labels, Number number, const char* suffix = "") {
    text_ += fmt::format("{}{}{}{}{} {}\n", name_, suffix, labels.empty() ? "" : "{", labels, labels.empty() ? "" : "}",
                         number);
  }
  void histogram(const std::string& labels, const Timing& timing) {
    for (int k = 0; k < kTimingPowerCount; ++k) {
      value(fmt::format("{},le=\"{}\"", labels, std::ldexp(1e-9, kTimingPowerFirst + k)),
            timing.below[static_cast<std::size_t>(k)], "_bucket");
    }
    value(labels + ",le=\"+Inf\"", timing.count, "_bucket");
    value(labels, seconds_of(timing.sum_ns), "_sum");
    value(labels, timing.count, "_count");
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  const char* name_ = "";
  std::string text_;
};

}  // namespace

std::string metrics_text(const PumpStatus& status, const ServiceFacts& facts) {
  Page page;
  page.family("footlight_build_info", "gauge", "Always 1; the version of the program is a label.");
  page.value("version=\"" FOOTLIGHT_VERSION "\"", 1);
  page.family("footlight_start_time_seconds", "gauge", "When the bridge started, in seconds since 1970 UTC.");
  page.value("", fmt::format("{:.3f}", static_cast<double>(facts.start_unix_ns) * 1e-9));
  page.family("footlight_real_time", "gauge", "1 if the thread that carries frames has real-time priority.");
  page.value("", facts.real_time ? 1 : 0);
  page.family("footlight_reloads_total", "counter", "Show files read while running, by result.");
  page.value("result=\"taken\"", facts.reloads);
  page.value("result=\"refused\"", facts.reload_failures);
  if (facts.flashes) {
    page.family("footlight_flashes_harmful_total", "counter", "Periods of harmful flashes on an output.");
    page.value("", facts.flashes->harmful);
    page.family("footlight_flashes_held_total", "counter", "Snapshots that the flash guard held back.");
    page.value("", facts.flashes->held);
  }
  page.family("footlight_ticks_total", "counter", "Ticks of the pump.");
  page.value("", status.ticks);

  std::vector<std::string> names;  // of status.ports, as labels
  std::map<std::pair<bool, std::string>, int> seen;
  for (const PortStatus& port : status.ports) {
    const int number = ++seen[{port.is_sink, port.name}];
    names.push_back(fmt::format("port=\"{}{}\",direction=\"{}\"", label_text(port.name),
                                number > 1 ? fmt::format(" #{}", number) : "", port.is_sink ? "out" : "in"));
  }
  const auto per_port = [&](const char* name, const char* type, const char* help, auto&& number_of) {
    page.family(name, type, help);
    for (std::size_t i = 0; i < names.size(); ++i) page.value(names[i], number_of(status.ports[i]));
  };
  const auto per_direction = [&](bool sinks, auto&& write) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (status.ports[i].is_sink == sinks) write(names[i], status.ports[i]);
  };

  per_port("footlight_port_up", "gauge", "0 if a port is unplugged or fails.",
           [](const PortStatus& port) { return port.state == PortState::kGone ? 0 : 1; });
  page.family("footlight_port_state", "gauge", "1 for the current state of a port.");
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (const PortState state : {PortState::kWorking, PortState::kWaiting, PortState::kGone, PortState::kEnded}) {
      page.value(fmt::format("{},state=\"{}\"", names[i], name_of(state)), status.ports[i].state == state ? 1 : 0);
    }
  }
  page.family("footlight_frames_total", "counter", "Frames received from an input, or snapshots sent to an output.");
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::map<Universe, std::uint64_t> frames;  // an endpoint may name a universe twice
    for (const PortUniverseStatus& universe : status.ports[i].universes) frames[universe.universe] += universe.frames;
    for (const auto& [universe, count] : frames)
      page.value(fmt::format("{},universe=\"{}\"", names[i], universe), count);
  }
  per_port("footlight_port_rejected_total", "counter", "Packets or messages that broke their protocol.",
           [](const PortStatus& port) { return port.port.rejected; });
  per_port("footlight_port_dropped_total", "counter",
           "Frames replaced by a newer one inside the port, or in the kernel.",
           [](const PortStatus& port) { return port.port.dropped; });
  per_port("footlight_port_errors_total", "counter", "Reads and writes that the system refused.",
           [](const PortStatus& port) { return port.port.errors; });
  per_port("footlight_port_failures_total", "counter", "Calls of the port that failed.",
           [](const PortStatus& port) { return port.failures; });
  page.family("footlight_port_figure", "gauge", "A measurement of a port's driver; the unit is the end of its name.");
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const PortFigure& figure : status.ports[i].figures)
      page.value(fmt::format("{},figure=\"{}\"", names[i], label_text(figure.name)), figure.value);
  page.family("footlight_port_unrouted_total", "counter", "Inputs: frames of universes that are not part of the run.");
  per_direction(false, [&](const auto& labels, const PortStatus& port) { page.value(labels, port.unrouted); });
  page.family("footlight_port_replaced_total", "counter",
              "Outputs: snapshots replaced by a newer one before they were sent.");
  per_direction(true, [&](const auto& labels, const PortStatus& port) { page.value(labels, port.replaced); });
  page.family("footlight_port_refused_total", "counter", "Outputs: snapshots in calls that failed.");
  per_direction(true, [&](const auto& labels, const PortStatus& port) { page.value(labels, port.refused); });
  page.family("footlight_latency_seconds", "histogram",
              "Outputs: from the stamp of a frame to the return of the call that sent it.");
  per_direction(true, [&](const auto& labels, const PortStatus& port) { page.histogram(labels, port.latency); });
  page.family("footlight_lateness_seconds", "histogram", "Delay of a call behind the port's deadline.");
  for (std::size_t i = 0; i < names.size(); ++i) page.histogram(names[i], status.ports[i].lateness);

  const auto per_universe = [&](const char* name, const char* type, const char* help, auto&& number_of) {
    page.family(name, type, help);
    for (const UniverseStatus& universe : status.universes)
      page.value(fmt::format("universe=\"{}\"", universe.universe), number_of(universe));
  };
  per_universe("footlight_universe_snapshots_total", "counter", "Snapshots made by the merge.",
               [](const UniverseStatus& universe) { return universe.writes; });
  per_universe("footlight_universe_senders", "gauge", "Current senders.",
               [](const UniverseStatus& universe) { return universe.senders.size(); });
  per_universe("footlight_universe_winners", "gauge", "Senders that share the highest priority.",
               [](const UniverseStatus& universe) { return universe.winners; });
  per_universe("footlight_universe_priority", "gauge", "Priority of the winners, 0 to 200.",
               [](const UniverseStatus& universe) { return static_cast<int>(universe.priority); });
  page.family("footlight_universe_age_seconds", "gauge", "Age of the newest frame; no value before the first one.");
  for (const UniverseStatus& universe : status.universes) {
    if (universe.newest.revision == 0) continue;
    const DurationNs age_ns = std::max<DurationNs>(status.stamp_ns - universe.newest.stamp_ns, 0);
    page.value(fmt::format("universe=\"{}\"", universe.universe), seconds_of(static_cast<std::uint64_t>(age_ns)));
  }
  // Gauges: a late frame is no longer lost, and the count of a dropped sender is removed.
  const auto per_sender = [&](const char* name, const char* help, auto&& number_of) {
    page.family(name, "gauge", help);
    for (const UniverseStatus& universe : status.universes) {
      std::map<std::string, int> same;
      for (const SenderStatus& sender : universe.senders) {
        const int number = ++same[sender.name];
        page.value(fmt::format("universe=\"{}\",sender=\"{}{}\"", universe.universe, label_text(sender.name),
                               number > 1 ? fmt::format(" #{}", number) : ""),
                   number_of(sender));
      }
    }
  };
  per_sender("footlight_sender_lost_frames", "Frames of a current sender that never arrived, by sequence number.",
             [](const SenderStatus& sender) { return sender.losses.lost; });
  per_sender("footlight_sender_late_frames", "Frames of a current sender that arrived after a later one, not used.",
             [](const SenderStatus& sender) { return sender.losses.late; });
  page.family("footlight_frames_refused_total", "counter", "Frames ignored: priority above 200, or too many senders.");
  for (const UniverseStatus& universe : status.universes) {
    page.value(fmt::format("universe=\"{}\",reason=\"priority\"", universe.universe), universe.merge.refused_priority);
    page.value(fmt::format("universe=\"{}\",reason=\"full\"", universe.universe), universe.merge.refused_full);
  }
  page.family("footlight_merged_frames_total", "counter",
              "Frames that reached the merge and were not refused, by their fate.");
  for (const UniverseStatus& universe : status.universes) {
    const MergeCounters& merge = universe.merge;
    const auto fate = [&](const char* name, std::uint64_t count) {
      page.value(fmt::format("universe=\"{}\",fate=\"{}\"", universe.universe, name), count);
    };
    fate("shown", merge.frames_shown);
    fate("outranked", merge.frames_outranked);
    fate("priorities", merge.frames_priorities);
    fate("early", merge.frames_early);
    fate("ended", merge.frames_ended);
  }
  page.family("footlight_senders_lost_total", "counter", "Senders dropped, by reason.");
  for (const UniverseStatus& universe : status.universes) {
    const MergeCounters& merge = universe.merge;
    const auto lost = [&](const char* reason, std::uint64_t count) {
      page.value(fmt::format("universe=\"{}\",reason=\"{}\"", universe.universe, reason), count);
    };
    lost("silent", merge.senders_silent);
    lost("ended", merge.senders_ended);
    lost("displaced", merge.senders_displaced);
  }
  return page.take();
}

}  // namespace footlight::tools

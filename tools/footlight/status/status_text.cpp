#include "tools/footlight/status/status_text.h"

#include <fmt/format.h>

#include "tools/footlight/duration.h"

namespace footlight::tools {

const char* name_of(PortState state) {
  switch (state) {
    case PortState::kWorking: return "working";
    case PortState::kWaiting: return "waiting";
    case PortState::kGone: return "gone";
    case PortState::kEnded: return "ended";
  }
  return "?";
}

std::string show_universes(std::span<const Universe> universes) {
  std::string text;
  for (std::size_t i = 0; i < universes.size();) {
    std::size_t last = i;
    while (last + 1 < universes.size() && universes[last + 1] == universes[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ",", universes[i]);
    if (last > i) text += fmt::format("-{}", universes[last]);
    i = last + 1;
  }
  return text;
}

std::string status_line(const PumpStatus& status) {
  std::string line;
  for (const PortStatus& port : status.ports) {
    line += fmt::format("{}{} {} ", line.empty() ? "" : "  ", port.is_sink ? "->" : "<-", port.name);
    if (port.state == PortState::kGone) {
      line += "gone";
    } else if (port.standby) {
      line += "standby";
    } else if (port.frames == 0) {
      line += "no frames yet";
    } else {
      line += fmt::format("{:.0f}/s", port.rate_hz);
    }
    if (port.port.rejected != 0) line += fmt::format(" ({} bad)", port.port.rejected);
    if (port.port.errors != 0) line += fmt::format(" ({} errors)", port.port.errors);
  }
  return line;
}

std::string summary_text(const PumpStatus& status, DurationNs elapsed_ns) {
  std::string text = fmt::format("ran {}\n", show_duration(elapsed_ns));
  const double elapsed_s = static_cast<double>(elapsed_ns) / static_cast<double>(kNsPerS);
  for (const PortStatus& port : status.ports) {
    text += fmt::format("  {} {}: {} frames", port.is_sink ? "out" : "in ", port.name, port.frames);
    if (elapsed_s > 0.0) text += fmt::format(", {:.1f}/s", static_cast<double>(port.frames) / elapsed_s);
    if (port.latency.count != 0) {
      text += fmt::format(", latency p50 {} p99 {} max {}", show_duration(port.latency.p50_ns),
                          show_duration(port.latency.p99_ns), show_duration(port.latency.max_ns));
    }
    if (port.lateness.count != 0) {
      text +=
          fmt::format(", late p99 {} max {}", show_duration(port.lateness.p99_ns), show_duration(port.lateness.max_ns));
    }
    const auto count = [&](const char* what, std::uint64_t number) {
      if (number != 0) text += fmt::format(", {} {}", number, what);
    };
    count("rejected", port.port.rejected);
    count("dropped", port.port.dropped);
    count("replaced", port.replaced);
    count("refused", port.refused);
    count("of universes that are not in this run", port.unrouted);
    count("errors", port.port.errors + port.failures);
    if (!port.trouble.empty()) text += fmt::format("; {}", port.trouble);
    text += '\n';
  }
  // Frames that were received but are in no snapshot.
  for (const UniverseStatus& universe : status.universes) {
    const MergeCounters& merge = universe.merge;
    if (merge.frames == merge.frames_shown) continue;
    text += fmt::format("  universe {}: {} frames, {} shown", universe.universe, merge.frames, merge.frames_shown);
    const auto count = [&](const char* what, std::uint64_t number) {
      if (number != 0) text += fmt::format(", {} {}", number, what);
    };
    count("outranked by another sender", merge.frames_outranked);
    count("with per-address priorities", merge.frames_priorities);
    count("of a new sender, too early", merge.frames_early);
    count("that ended their stream", merge.frames_ended);
    count("refused: priority above 200", merge.refused_priority);
    count("refused: more than eight senders", merge.refused_full);
    text += '\n';
  }
  return text;
}

}  // namespace footlight::tools

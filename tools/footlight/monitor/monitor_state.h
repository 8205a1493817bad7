// The data of the monitor: the pages /status and /levels of a bridge (status_pages.h), and when each slot changed. The
// bridge is another program or the monitor's own pump; both give the same pages.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"
#include "tools/footlight/monitor/slot_changes.h"

namespace footlight::tools {

struct MonitorSender {
  std::string name;  // printable
  int priority = 0;
  DurationNs age_ns = 0;
  double rate_hz = 0.0;
  bool wins = false;
  bool per_address = false;
  std::uint64_t lost = 0;  // frames, by the sender's own numbers
  std::uint64_t late = 0;
};

struct MonitorPort {
  std::string name;  // printable, as what follows
  bool is_out = false;
  std::string state;  // "working", "waiting", "gone", "ended"
  bool standby = false;
  std::string trouble;
  double rate_hz = 0.0;
  std::uint64_t frames = 0;
  std::uint64_t rejected = 0;
  std::uint64_t lost = 0;  // dropped, refused or failed
  DurationNs latency_p99_ns = 0;
};

struct MonitorUniverse : SlotChanges {
  Universe universe = 0;
  double rate_hz = 0.0;
  int priority = 0;
  int sender_count = 0;
  std::vector<MonitorSender> senders;  // those in the page
  std::uint64_t frames_refused = 0;
  TimeNs stamp_ns = 0;         // of the newest frame; 0: none yet
  std::uint64_t revision = 0;  // 0: never written
};

struct MonitorState {
  std::string title;    // the monitored inputs or bridge
  std::string note;     // a note for the user; empty: none
  std::string trouble;  // why updates fail; empty: they do not
  std::string json;     // the last status
  TimeNs now_ns = 0;    // on the clock of the bridge
  std::vector<MonitorPort> ports;
  std::vector<MonitorUniverse> universes;  // ascending

  [[nodiscard]] MonitorUniverse* find(Universe universe);
};

// Both parse a page. kProtocol if it is not such a page.
[[nodiscard]] Status take_status(MonitorState& state, const std::string& text);
[[nodiscard]] Status take_levels(MonitorState& state, const std::string& text);

// One line of JSON: the last status, with the age and the levels of every universe added.
[[nodiscard]] std::string json_of_monitor(const MonitorState& state, const std::string& time);

}  // namespace footlight::tools

// What the monitor knows: what it was told by the pages /status and /levels of a bridge (status_pages.h), and when each
// slot changed. Of a bridge that runs elsewhere or of the monitor's own pump: there is one way to see both.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"

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
  bool stands_by = false;
  std::string trouble;
  double rate_hz = 0.0;
  std::uint64_t frames = 0;
  std::uint64_t rejected = 0;
  std::uint64_t lost = 0;  // dropped, refused or failed
  DurationNs latency_p99_ns = 0;
};

struct MonitorUniverse {
  Universe universe = 0;
  double rate_hz = 0.0;
  int priority = 0;
  int sender_count = 0;
  std::vector<MonitorSender> senders;  // as many as are named
  std::uint64_t frames_refused = 0;
  TimeNs stamp_ns = 0;         // of the newest frame; 0: none ever came
  std::uint64_t revision = 0;  // 0: never written
  Slots levels{};
  std::array<TimeNs, kSlotCountMax> changed_ns{};  // when each level was seen to change; 0: never
};

struct MonitorState {
  std::string title;    // what is watched
  std::string note;     // what a person should know about it; empty: nothing
  std::string trouble;  // why nothing is heard any more; empty: all is well
  std::string json;     // the status that was taken last
  TimeNs now_ns = 0;    // on the clock of the bridge
  std::vector<MonitorPort> ports;
  std::vector<MonitorUniverse> universes;  // ascending

  [[nodiscard]] MonitorUniverse* find(Universe universe);
};

// Both take what a page says. kProtocol where it is no such page.
[[nodiscard]] Status take_status(MonitorState& state, const std::string& json);
[[nodiscard]] Status take_levels(MonitorState& state, const std::string& json);

// One line of JSON: the status that was taken last, with the age and the levels of every universe beside the rest.
[[nodiscard]] std::string json_of_monitor(const MonitorState& state, const std::string& time);

}  // namespace footlight::tools

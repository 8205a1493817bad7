// A pump for a day, with everything going wrong that can: on a clock that is moved by hand, with ports that fail on
// purpose, from one seed.
//
// Three desks over two sources send to five sinks: free, with a rate cap, a main and its standby, and one without a cap
// that never fails. At random times desks fall silent, end, come back, pile up rounds, change priority, send
// per-address priorities and stop doing so; sources fail; sinks fail, go, stall; the machine stands still for up to
// 30 s; the show is read anew with other universes, modes and ports.
//
// What is held against it:
// - after every tick each working sink has the look that is in the buffer: those without a cap at once, the one with a
//   cap within its period, of main and standby at least one; a standby gets nothing while its main works;
// - the sink that never fails gets every look that is made, through every reload;
// - every simulated minute each frame that the desks gave is in just one counter, and so is each look that is meant for
//   a sink;
// - a tick in which nothing out of the ordinary happens allocates nothing, and at every simulated hour as much memory
//   is held as after the first ten minutes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace footlight::testing {

struct SoakOptions {
  double hours = 24.0;    // simulated
  double rate_hz = 44.0;  // rounds a second of each desk; faults come as often at any rate
  std::uint64_t seed = 1;
};

struct SoakReport {
  std::vector<std::string> offences;  // the first 20; empty: all held
  std::uint64_t ticks = 0;
  std::uint64_t frames = 0;     // given by the desks
  std::uint64_t snapshots = 0;  // that reached a sink
  std::uint64_t minutes_checked = 0;
  std::int64_t memory_growth_bytes = 0;  // the most that an hour had above the first ten minutes
  // How often something went wrong on purpose.
  std::uint64_t silences = 0;
  std::uint64_t endings = 0;
  std::uint64_t bursts = 0;
  std::uint64_t priority_changes = 0;
  std::uint64_t claim_changes = 0;  // per-address priorities on, off or other ones
  std::uint64_t source_failures = 0;
  std::uint64_t sink_failures = 0;
  std::uint64_t stalls = 0;
  std::uint64_t jumps = 0;
  std::uint64_t reloads = 0;
  std::uint64_t takeovers = 0;
};

[[nodiscard]] SoakReport run_soak(const SoakOptions& options);

}  // namespace footlight::testing

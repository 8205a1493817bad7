// A pump for a day, with every kind of fault: on a simulated clock, with ports that fail on purpose, from one seed.
//
// Three desks over two sources send to five sinks: free, with a rate cap, a main and its standby, and one without a cap
// that never fails. At random times desks fall silent, end, return, pile up rounds, change priority, start and stop
// per-address priorities. Sources fail. Sinks fail, disappear, stall. The machine stands still for up to 30 s. The show
// is reloaded with other universes, modes and ports.
//
// It checks:
// - after every tick each working sink has the snapshot in the buffer: those without a cap at once, the one with a cap
//   within its period, of main and standby at least one; a standby gets nothing while its main works;
// - the sink that never fails gets every snapshot, through every reload;
// - every simulated minute each frame from the desks is in exactly one counter, and so is each snapshot due to a sink;
// - a tick without anything unusual allocates nothing, and at every simulated hour the memory held is that after the
//   first ten minutes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace footlight::testing {

struct SoakOptions {
  double hours = 24.0;    // simulated
  double rate_hz = 44.0;  // rounds per second of each desk; the frequency of faults does not depend on it
  std::uint64_t seed = 1;
};

struct SoakReport {
  std::vector<std::string> offences;  // the first 20; empty: all checks passed
  std::uint64_t ticks = 0;
  std::uint64_t frames = 0;     // given by the desks
  std::uint64_t snapshots = 0;  // received by a sink
  std::uint64_t minutes_checked = 0;
  std::int64_t memory_growth_bytes = 0;  // the largest excess of an hour over the first ten minutes
  // How often each fault was caused.
  std::uint64_t silences = 0;
  std::uint64_t endings = 0;
  std::uint64_t bursts = 0;
  std::uint64_t priority_changes = 0;
  std::uint64_t claim_changes = 0;  // per-address priorities on, off or changed
  std::uint64_t source_failures = 0;
  std::uint64_t sink_failures = 0;
  std::uint64_t stalls = 0;
  std::uint64_t jumps = 0;
  std::uint64_t reloads = 0;
  std::uint64_t takeovers = 0;
};

[[nodiscard]] SoakReport run_soak(const SoakOptions& options);

}  // namespace footlight::testing

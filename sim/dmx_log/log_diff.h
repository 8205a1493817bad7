// Two logs compared in levels and in time: what `footlight log diff` prints.
//
// Frames are paired universe by universe, in order, in three steps. The offset between the logs is estimated once: over
// all changes of levels that occur exactly once in either log, the median of time in B minus time in A. Then frames
// with equal levels that lie within half a period of each other are pairs; the offset is followed, so drift does not
// tear them apart. Where that fails, the next 48 frames of each side are aligned at the least cost (Needleman and
// Wunsch 1970) of levels that differ, time apart and frames left over; so a frame that was lost costs one frame and a
// stall none.
//
// Levels are those of the whole universe after a frame, so a short frame equals a long one with the rest unchanged.
// Senders, priorities and sequences are not compared: other machines number them otherwise.
// Threads: none; one thread at a time. Memory: 48 bytes for each frame of both logs.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/result.h"
#include "sim/dmx_log/dmx_log.h"

namespace footlight {

struct LogDiffOptions {
  int level_tolerance = 0;  // levels may differ by this much, 0 to 255
  DurationNs time_tolerance_ns = kNsPerMs;
  std::optional<DurationNs> offset_ns;  // time in B minus time in A; else estimated
  bool changes_only = false;            // leave out frames that repeat the levels before them
};

// Distances in time of pairs, beyond the offset, without their sign.
struct LogDiffTimes {
  DurationNs p50_ns = 0;
  DurationNs p99_ns = 0;
  DurationNs max_ns = 0;
};

struct LogUniverseDiff {
  Universe universe = 0;
  std::uint64_t frames_a = 0;
  std::uint64_t frames_b = 0;
  std::uint64_t pairs = 0;
  std::uint64_t only_a = 0;
  std::uint64_t only_b = 0;
  std::uint64_t different = 0;  // pairs with a level further apart than allowed
  int slots_different = 0;      // slots that differ in any of them, each once
  int level_distance_max = 0;
  // Of the first pair that differs, at its lowest address; address 0: none does.
  DurationNs first_ns = 0;  // in A
  Address first_address = 0;
  std::uint8_t first_level_a = 0;
  std::uint8_t first_level_b = 0;
  LogDiffTimes times;
  double drift_ppm = 0.0;  // how much faster B's times grow, by least squares over all pairs
};

enum class LogOffsetFrom { kGiven, kChanges, kFirstFrames, kNothing };

struct LogDiff {
  DurationNs duration_a_ns = 0;
  DurationNs duration_b_ns = 0;
  DurationNs offset_ns = 0;  // time in B minus time in A
  LogOffsetFrom offset_from = LogOffsetFrom::kNothing;
  std::uint64_t offset_votes = 0;          // kChanges: of how many
  std::vector<LogUniverseDiff> universes;  // ascending; those of either log
  bool equal = false;  // no frame without a partner, no level and no time further apart than allowed
};

// Reads both logs from their start, twice where levels differ. Errors: those of LogReader.
[[nodiscard]] Result<LogDiff> diff_logs(LogReader& a, LogReader& b, const LogDiffOptions& options = {});

}  // namespace footlight

// Compares two logs in levels and in time, for `footlight log diff`.
//
// Frames are paired per universe, in order, in three steps. First the offset between the logs is estimated once: the
// median of time in B minus time in A, over all changes of levels that occur exactly once in each log. Then frames with
// equal levels within half a period of each other become pairs; the offset follows the pairs, so that drift does not
// separate them. Where that fails, the next 48 frames of each side are aligned at the least cost (Needleman and Wunsch
// 1970) of different levels, distance in time and frames left over. So a lost frame costs one frame, and a stall costs
// none.
//
// Levels are those of the whole universe after a frame, so a short frame equals a long one with the rest unchanged.
// Senders, priorities and sequences are not compared, because machines number them differently. Threads: none; one
// thread at a time. Memory: 48 bytes for each frame of both logs.
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
  bool changes_only = false;            // ignore frames that repeat the levels before them
};

// Absolute time differences of pairs, after subtracting the offset.
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
  int slots_different = 0;      // slots that differ in any of them, each counted once
  int level_distance_max = 0;
  // Of the first pair that differs, at its lowest address; address 0: no pair differs.
  DurationNs first_ns = 0;  // in A
  Address first_address = 0;
  std::uint8_t first_level_a = 0;
  std::uint8_t first_level_b = 0;
  LogDiffTimes times;
  double drift_ppm = 0.0;  // how much faster B's clock runs, by least squares over all pairs
};

enum class LogOffsetFrom { kGiven, kChanges, kFirstFrames, kNothing };

struct LogDiff {
  DurationNs duration_a_ns = 0;
  DurationNs duration_b_ns = 0;
  DurationNs offset_ns = 0;  // time in B minus time in A
  LogOffsetFrom offset_from = LogOffsetFrom::kNothing;
  std::uint64_t offset_votes = 0;          // kChanges: number of changes used
  std::vector<LogUniverseDiff> universes;  // ascending; all universes of either log
  bool equal = false;  // every frame has a partner, and no level or time differs by more than allowed
};

// Reads both logs from their start, twice where levels differ. Errors: those of LogReader.
[[nodiscard]] Result<LogDiff> diff_logs(LogReader& a, LogReader& b, const LogDiffOptions& options = {});

}  // namespace footlight

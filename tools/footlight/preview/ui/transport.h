// How a log plays in the window: its time, its speed, the part that repeats, and the light of the rig over the log.
// Plain data. The loop of the preview fills it in and carries out what panels and keys ask for.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "sim/core/clock.h"
#include "tools/footlight/preview/ui/rig_index.h"

namespace footlight::tools {

inline constexpr DurationNs kQuickLogNs = 120 * kNsPerS;  // a log that is no longer than this is replayed at once
inline constexpr DurationNs kRepeatMinNs = 100 * kNsPerMs;
inline constexpr double kSpeeds[] = {0.1, 0.25, 0.5, 1, 2, 4};

struct Transport {
  // What is.
  TimeNs now_ns = 0;
  DurationNs duration_ns = 0;
  TimeNs known_ns = 0;  // seeks up to here are quick (SeekIndex); 0 while channels are taken over
  // Of a seek that takes several turns: where its steps began, are and end. now_ns is its end meanwhile.
  struct Seeking {
    TimeNs from_ns = 0;
    TimeNs at_ns = 0;
    TimeNs until_ns = 0;
  };
  std::optional<Seeking> seeking;
  // The time of the levels; nothing during a seek, when they are those from before it.
  [[nodiscard]] std::optional<TimeNs> levels_ns() const { return seeking ? std::nullopt : std::optional(now_ns); }

  // What the user asks for.
  bool playing = true;
  bool repeats = false;  // the whole log
  double speed = 1;      // one of kSpeeds
  // A part that repeats, at least kRepeatMinNs long; each end may be missing: then the start or the end of the log.
  std::optional<TimeNs> from_ns;
  std::optional<TimeNs> to_ns;
  std::optional<TimeNs> seek_ns;  // the loop carries it out and resets it
  bool cancels_seek = false;      // likewise

  // Whether a seek to this time is quick enough to follow a drag.
  [[nodiscard]] bool is_quick(TimeNs time_ns) const { return time_ns <= known_ns || duration_ns <= kQuickLogNs; }
  // Where playing leads in dt_ns >= 0 of real time. What goes beyond the end of what repeats goes on from its start.
  [[nodiscard]] TimeNs next_ns(DurationNs dt_ns) const;
  // The start or the end of the part that repeats is here. The other end is forgotten if it lies on the wrong side, or
  // nearer than kRepeatMinNs. Nothing changes if the log itself is shorter than that on the other side.
  void repeat_from(TimeNs time_ns);
  void repeat_to(TimeNs time_ns);
  void repeat_all() { from_ns = to_ns = std::nullopt; }
  // To the next of kSpeeds in this direction.
  void change_speed(int by);
  // A seek by this much from where the last one goes to.
  void seek_by(DurationNs by_ns);
};

// "2:03.4", "1:02:03.4": tenths of seconds that have passed, not rounded up.
[[nodiscard]] std::string time_text(TimeNs time_ns);

// The mean level of the dimmers of a rig, or of some fixtures, over a log, as far as it is known.
class LightCurve {
 public:
  struct Point {
    TimeNs at_ns = 0;
    float light = 0;  // 0 to 1; without a dimmer among them the mean of all slots that are used
  };
  // which: indices of fixtures; empty: all. Those that the rig does not have are left out.
  LightCurve(const fixtures::Rig& rig, const RigIndex& index, std::span<const int> which = {});
  // levels: universes x 512 in the order of the compiled rig. Times ascend; others are ignored.
  void add(TimeNs at_ns, std::span<const std::uint8_t> levels);
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }

 private:
  std::vector<std::uint32_t> slots_;
  std::vector<Point> points_;
};

}  // namespace footlight::tools

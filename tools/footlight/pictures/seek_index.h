// Moments of a log with the states of all fixtures, so that a seek has only a few seconds of steps to make.
//
// The moments are made ahead, a few milliseconds of steps at a time, by the frame that shows the pictures: it puts its
// own states aside meanwhile. A moment is the end of exactly those steps that a replay from the start makes, so the
// picture after a seek is equal to the bit to that of `footlight render`. One thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/frame.h"
#include "sim/core/clock.h"
#include "tools/footlight/pictures/timeline.h"

namespace footlight::tools {

class SeekIndex {
 public:
  static constexpr std::uint64_t kBytesMax = std::uint64_t{256} << 20;
  static constexpr DurationNs kSpacingNs = 2 * kNsPerS;

  struct Moment {
    Timeline::Position position;
    render::FrameState state;
  };

  // `timeline`: of the same log and rig as the one that is shown, at its start, with can_go(); for the index alone.
  // Moments are at least spacing_ns of the log apart. When they take more than bytes_max of memory, every other one is
  // dropped, and the spacing doubles.
  explicit SeekIndex(Timeline timeline, std::uint64_t bytes_max = kBytesMax, DurationNs spacing_ns = kSpacingNs);

  // Makes moments for about budget_ns, at least one change of levels. Pending steps of the frame are carried out. After
  // an error of the log the frame has its own states. After the loss of a device they are undefined, and the index goes
  // on with the next frame.
  Status work(render::Frame& frame, Clock& clock, DurationNs budget_ns);

  // The last moment at or before this time; nullptr: none is known, so a seek begins at the start of the log.
  [[nodiscard]] const Moment* before(TimeNs time_ns) const;
  // The moments later than this time, ascending.
  [[nodiscard]] std::span<const Moment> after(TimeNs time_ns) const;
  [[nodiscard]] bool done() const { return done_; }
  [[nodiscard]] TimeNs known_ns() const { return done_ ? timeline_.duration_ns() : at_.position.now_ns; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  [[nodiscard]] const std::vector<Moment>& moments() const { return moments_; }

 private:
  Status make_moments(render::Frame& frame, Clock& clock, TimeNs until_ns);
  void keep();

  Timeline timeline_;
  std::uint64_t bytes_max_;
  DurationNs spacing_ns_;
  Moment at_;                 // where the next work() begins
  bool interrupted_ = false;  // timeline_ is beyond at_
  bool done_ = false;
  std::vector<Moment> moments_;  // ascending
  std::uint64_t bytes_ = 0;      // of moments_
};

}  // namespace footlight::tools

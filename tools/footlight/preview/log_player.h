// A log that drives the fixtures of a window: it plays, stands still, and goes to any time.
//
// A seek gives the states of a replay from the start of the log, to the bit. It begins at the last moment before its
// time, of an index (SeekIndex) or of the seek before, or at the start. Where that takes long, it is made in parts, one
// each turn, and can be cancelled. While the log plays, steps are cut at the times of pictures, so the states differ
// from those of a replay in their last bits. Needs no window. One thread.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "render/frame.h"
#include "sim/core/clock.h"
#include "tools/footlight/pictures/seek_index.h"
#include "tools/footlight/pictures/timeline.h"
#include "tools/footlight/preview/light_strips.h"
#include "tools/footlight/preview/ui/transport.h"

namespace footlight::tools {

// Timeline::advance(), where `step` passes the steps to `frame`: carries them out before too many wait.
Status advance_frame(Timeline& timeline, render::Frame& frame, TimeNs until_ns, DurationNs exposure_ns,
                     const Timeline::Step& step);

// Adds what the moments have beyond the curve's last point.
void extend(LightCurve& curve, const SeekIndex& index);
// By at most so many moments, since each takes up to a millisecond.
void extend(LightStrips& strips, const SeekIndex& index, std::size_t moments_max);

class LogPlayer {
 public:
  static constexpr DurationNs kExposureNs = 20 * kNsPerMs;  // of a picture after a seek, as `footlight render --at`
  static constexpr DurationNs kPartNs = 20 * kNsPerMs;      // of real time: a part of a seek

  // What the log drives.
  struct Driven {
    render::vk::Device& device;
    render::Frame& frame;
    bool taken_over = false;        // `step` changes levels: moments lack that
    Timeline::Step step;            // passes a step to the frame and to whatever else follows the levels
    std::function<void()> restart;  // called before steps that do not follow from the steps before
    bool holds_steps = false;       // a picture of the frame is in flight: its GPU cannot be used now
  };

  // read: makes a timeline of the log from its start, for the rig of the frames that are driven. It is called again for
  // the index and for each seek without a moment. The clock outlives this.
  LogPlayer(std::function<Timeline()> read, Clock& clock);

  // For the first picture of a frame, at this time. show() replays the log. show_soon() replays the last kQuickLogNs
  // before the time, or all with VRSL's fixtures: what came before is missing until a seek.
  Status show(TimeNs until_ns, const Driven& driven);
  Status show_soon(TimeNs until_ns, const Driven& driven);

  // All of it. Also for a frame without the states of the one before, whatever was under way.
  Status seek(TimeNs until_ns, const Driven& driven);

  // A seek that is under way: fixtures are at a time between, and levels() are those from before it.
  [[nodiscard]] const std::optional<Transport::Seeking>& seeking() const { return seeking_; }
  // Puts the fixtures back to where they were before it. With VRSL's fixtures, whose states cannot be put back, it ends
  // where it has come to. Without one nothing happens. True: the log should stop, since it would begin the seek anew.
  Result<bool> cancel_seek(const Driven& driven);

  // The steps of one picture, as `transport` has it: a part of a seek, playing or a pause. Sets its times. dt_ns >= 0:
  // since the last call; the part of it that a seek took is not played. In a pause, and at the end of the log, fixtures
  // stand still until something is taken over; then they go on with the levels held.
  // exposure_ns: of the picture that a seek leads to.
  Status turn(Transport& transport, DurationNs dt_ns, const Driven& driven, DurationNs exposure_ns = kExposureNs);
  // After an error of turn(): the log is paused where it is, and its seek is given up.
  void stop(Transport& transport);
  // Whether turn() needs nothing but to note steps in the frame. Required of a turn() with Driven::holds_steps.
  [[nodiscard]] bool can_hold(const Transport& transport, DurationNs dt_ns, const Driven& driven) const;

  // Plays on from now_ns() to until_ns >= now_ns() + exposure_ns, clamped to the log, whose last exposure_ns are the
  // exposure of a picture. Not during a seek.
  Status play_on(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven);

  // Makes moments for about budget_ns. After an error of the log there is no index any more, and take_news() returns
  // why; else it is empty.
  Status work_at_index(DurationNs budget_ns, const Driven& driven);
  [[nodiscard]] std::string take_news() { return std::exchange(news_, {}); }

  // Of a seek that is under way: its end.
  [[nodiscard]] TimeNs now_ns() const { return seeking_ ? seeking_->until_ns : timeline_->now_ns(); }
  [[nodiscard]] DurationNs duration_ns() const { return timeline_->duration_ns(); }
  // Of the picture at now_ns(): the last steps of the last playing or finished seek.
  [[nodiscard]] DurationNs exposed_ns() const { return exposed_ns_; }
  [[nodiscard]] std::span<const std::uint8_t> levels() const { return levels_; }  // of the last step; none before one
  [[nodiscard]] const SeekIndex* index() const { return index_ ? &*index_ : nullptr; }  // null: VRSL's fixtures

 private:
  [[nodiscard]] const SeekIndex::Moment* known_before(TimeNs time_ns, const Driven& driven) const;
  [[nodiscard]] bool goes_on(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) const;
  Status play_to(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven);
  Status begin_seek(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven);
  [[nodiscard]] bool goes_further(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven) const;
  Status begin_going_back(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven);
  Status work_at_seek(DurationNs budget_ns, const Driven& driven);
  Status keep_before(const Driven& driven);
  Status replay(TimeNs until_ns, DurationNs exposure_ns, bool exact, const Driven& driven);
  Status advance(TimeNs until_ns, DurationNs exposure_ns, const Driven& driven);

  std::function<Timeline()> read_;
  Clock& clock_;
  std::optional<Timeline> timeline_;  // always there
  std::optional<SeekIndex> index_;
  std::optional<SeekIndex::Moment> kept_;  // shortly before where the last seek came to
  std::optional<Transport::Seeking> seeking_;
  DurationNs exposure_ns_ = 0;               // of its picture
  DurationNs exposed_ns_ = 0;
  bool exact_ = false;                       // its steps are those of a replay
  bool asked_ = false;                       // by the user; else the log repeats
  std::optional<SeekIndex::Moment> before_;  // where the fixtures were
  bool moved_before_ = false;                // moves_in_pause_, then
  std::vector<std::uint8_t> levels_;
  std::string news_;
  DurationNs sought_ns_ = 0;     // that seeks took since the last turn() began
  bool moves_in_pause_ = false;  // something was taken over since the log was paused
};

}  // namespace footlight::tools

// A and B of the comparison on the stage: whose picture is next, what their fixtures are, and the difference of both
// (decision 0165). Knows no window. One thread.
//
// A picture of B comes first, then one of A for the same time and with the same camera. While the frame has the
// fixtures of another one (AsideStage), or until the states of a moment are kept, steps of its own fixtures wait here.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tools/footlight/pictures/flash_mode.h"
#include "tools/footlight/pictures/flash_watch.h"
#include "tools/footlight/preview/aside_stage.h"
#include "tools/footlight/preview/orbit_camera.h"
#include "tools/footlight/preview/picture_difference.h"
#include "tools/footlight/preview/ui/level_comparison.h"

namespace footlight::tools {

enum class StageCompare { kOff, kBeside, kDifference };
// "off", "beside" or "difference". kBadInput lists them.
[[nodiscard]] Result<StageCompare> stage_compare_of(std::string_view word);
[[nodiscard]] const char* word_of(StageCompare mode);
[[nodiscard]] constexpr StageCompare next_of(StageCompare mode) {
  return mode == StageCompare::kOff      ? StageCompare::kBeside
         : mode == StageCompare::kBeside ? StageCompare::kDifference
                                         : StageCompare::kOff;
}

class StageComparison {
 public:
  static constexpr std::size_t kA = 0;
  static constexpr std::size_t kB = 1;
  using MakePlayer = std::function<std::unique_ptr<LogPlayer>()>;

  [[nodiscard]] StageCompare mode() const { return mode_; }
  [[nodiscard]] bool on() const { return mode_ != StageCompare::kOff; }
  void set_mode(StageCompare mode);

  // Steps of the stage's own fixtures.
  [[nodiscard]] bool holds_steps() const { return holds_; }
  void hold_steps() { holds_ = true; }
  void hold(std::span<const std::uint8_t> levels, DurationNs dt_ns, bool new_exposure);
  // So many are held that no more should be made.
  [[nodiscard]] bool is_full() const;
  // Between two pictures: passes what is held to the frame, and keeps the states of moments on the way.
  Status release(render::Frame& frame);

  // What is compared, as often as it may have changed. The states of a new moment are those of now: they are kept by
  // the next release(), and steps are held until then. log: makes the player of A's log.
  void follow(const LevelComparison& compared, const MakePlayer& log);
  // The frame is of another rig from now on. Moments are then shown by their levels.
  void change_rig();
  // The frame is gone, and what it has put aside.
  void lose_frame();

  // The picture that is begun next: of A or B.
  [[nodiscard]] std::size_t next_side() const { return turn_; }
  // Null: the stage's own.
  [[nodiscard]] AsideStage* aside(std::size_t side) const { return asides_[side].get(); }
  // The one that the frame has the fixtures of; null: its own.
  [[nodiscard]] AsideStage* inside() const;
  [[nodiscard]] std::optional<Transport::Seeking> seeking() const;
  // The picture of next_side() is begun. The camera, time and exposure of B are those of A as well; the exposure ends
  // at the time.
  void begin(const OrbitCamera& camera, TimeNs log_ns, DurationNs exposure_ns);
  // Of B's picture, once one was begun.
  [[nodiscard]] const std::optional<OrbitCamera>& camera() const { return camera_; }
  [[nodiscard]] TimeNs log_ns() const { return log_ns_; }
  [[nodiscard]] DurationNs exposure_ns() const { return exposure_ns_; }
  // The picture that was begun is done, or is given up. B comes next, also if there was begun anew meanwhile: A's
  // picture needs the camera of B's.
  void end() { turn_ = turn_ == kB && camera_ ? kA : kB; }
  void begin_anew();

  // Of the difference: a picture of B, and one of A. True: both were of one size, and there is another difference. It
  // must not be shown while `flashes` hold it back.
  void take_b(const HostPicture& picture);
  [[nodiscard]] bool take_a(const HostPicture& picture, FlashMode flashes, DurationNs at_ns);
  [[nodiscard]] HostPicture picture() const { return {rgba_, width_, height_}; }
  [[nodiscard]] const std::optional<PictureDifference>& difference() const { return difference_; }
  [[nodiscard]] bool held_back() const { return held_back_; }
  [[nodiscard]] const FlashWatch* watch() const { return watch_.get(); }

 private:
  struct Held {
    std::vector<std::uint8_t> levels;
    DurationNs dt_ns = 0;
    bool new_exposure = false;
    std::optional<std::size_t> keeps;  // the states for this side, and no step
  };
  void drop(std::size_t side);
  void follow_flashes(FlashMode mode);

  StageCompare mode_ = StageCompare::kOff;
  std::array<std::unique_ptr<AsideStage>, 2> asides_;
  std::array<std::uint64_t, 2> numbers_{};  // KeptLevels::number of each
  bool holds_ = false;
  std::vector<Held> held_;
  std::size_t held_bytes_ = 0;
  std::size_t turn_ = kB;
  std::optional<OrbitCamera> camera_;
  TimeNs log_ns_ = 0;
  DurationNs exposure_ns_ = 0;
  std::vector<std::uint8_t> rgba_b_;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> rgba_;
  std::optional<PictureDifference> difference_;
  std::unique_ptr<FlashWatch> watch_;
  bool limits_ = false;
  bool held_back_ = false;
};

}  // namespace footlight::tools

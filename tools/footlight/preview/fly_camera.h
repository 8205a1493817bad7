// A camera that flies through the stage with keys that are held, and views of the whole rig from fixed sides. Knows no
// window.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "sim/core/clock.h"
#include "tools/footlight/preview/orbit_camera.h"

namespace footlight::tools {

// What is held.
struct FlyKeys {
  bool ahead = false;
  bool back = false;
  bool left = false;
  bool right = false;
  bool up = false;
  bool down = false;
  bool fast = false;  // kFastFactor times as fast
};

class FlyCamera {
 public:
  static constexpr double kSpeedMinMS = 0.1;
  static constexpr double kSpeedMaxMS = 100;
  static constexpr double kFastFactor = 4;
  // A picture that takes longer moves the camera by no more, so that it does not leave the hall in one step.
  static constexpr DurationNs kStepMaxNs = 250 * kNsPerMs;

  [[nodiscard]] bool on() const { return on_; }
  void set_on(bool on) { on_ = on, moves_ = false; }
  [[nodiscard]] double speed_m_s() const { return speed_m_s_; }
  // A step is a quarter faster; negative: slower. Within the limits above.
  void change_speed(double steps);

  // Moves the camera for dt_ns; diagonals are as fast as straight ways. False: it stays, as it does while this is off.
  bool step(OrbitCamera& camera, const FlyKeys& keys, DurationNs dt_ns);
  // The last step() began a flight: it is another edit than the flight before.
  [[nodiscard]] bool begins() const { return begins_; }

 private:
  bool on_ = false;
  bool moves_ = false;
  bool begins_ = false;
  double speed_m_s_ = 3;
};

// The audience is towards -Y; left and right are those of the audience.
enum class ViewSide { kFront, kAbove, kLeft, kRight, kPlan };
inline constexpr std::size_t kViewSides = 5;
[[nodiscard]] std::string_view name_of(ViewSide side);  // "front of house"
// All of the box in a picture of this width over height. Exposure: as `now` has it.
[[nodiscard]] OrbitCamera view_from(ViewSide side, const Bounds& bounds, double aspect, const OrbitCamera& now);

}  // namespace footlight::tools

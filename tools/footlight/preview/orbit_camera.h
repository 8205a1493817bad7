// A camera that hands move: around a target, across it, towards it. Z up, metres.
#pragma once

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"

namespace footlight::tools {

class OrbitCamera {
 public:
  explicit OrbitCamera(const fixtures::Camera& camera);
  // The same camera again, wherever it was moved to; exposure and name are the first one's.
  [[nodiscard]] fixtures::Camera camera() const;

  // Turns about the target. Positive: to the right, and up (rad); up to a hair short of straight up and down.
  void orbit(double right_rad, double up_rad);
  // Moves across the line of sight, in heights of the picture at the target; positive: to the right, and up.
  void pan(double right, double up);
  // One step is a tenth of the way to the target; negative: away. 5 cm to 50 km from the target.
  void approach(double steps);
  // Looks at the box from as near as has all of it in a picture of this width over height, with a little room round it.
  void frame(const glm::dvec3& low_m, const glm::dvec3& high_m, double aspect);

  [[nodiscard]] double distance_m() const { return distance_m_; }

 private:
  [[nodiscard]] glm::dvec3 forward() const;

  fixtures::Camera camera_;  // name, field of view, exposure, target
  double distance_m_ = 1;
  double azimuth_rad_ = 0;  // of the line of sight: 0 towards +y, growing towards +x
  double elevation_rad_ = 0;
};

// What F looks at: every fixture and the floor under it; the boxes where there is no fixture.
struct Bounds {
  glm::dvec3 low_m{-1};
  glm::dvec3 high_m{1};
};
[[nodiscard]] Bounds bounds_of(const fixtures::Rig& rig);

}  // namespace footlight::tools

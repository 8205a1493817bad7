// A camera that the mouse moves: around a target, sideways, and towards it. Z up, metres.
#pragma once

#include <string>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"

namespace footlight::tools {

class OrbitCamera {
 public:
  explicit OrbitCamera(const fixtures::Camera& camera);
  // The camera at its current position, with the exposure and name of the first one.
  [[nodiscard]] fixtures::Camera camera() const;

  // Turns about the target. Positive: to the right, and up (rad); up to almost straight up and down.
  void orbit(double right_rad, double up_rad);
  // Moves across the line of sight, in picture heights at the target; positive: to the right, and up.
  void pan(double right, double up);
  // One step is a tenth of the distance to the target; negative: away. 5 cm to 50 km from the target.
  void approach(double steps);
  // Moves the camera and its target, metres: to the right and along the line of sight, and straight up.
  void fly(double right_m, double ahead_m, double up_m);
  // Turns about the camera's own place. Positive: to the right, and up (rad); up to almost straight up and down.
  void look(double right_rad, double up_rad);
  // Frames the box: from the nearest position with all of it in a picture of this width over height, with a margin.
  void frame(const glm::dvec3& low_m, const glm::dvec3& high_m, double aspect);

  [[nodiscard]] double distance_m() const { return distance_m_; }
  [[nodiscard]] const std::string& name() const { return camera_.name; }

 private:
  [[nodiscard]] glm::dvec3 forward() const;

  fixtures::Camera camera_;  // name, field of view, exposure, target
  double distance_m_ = 1;
  double azimuth_rad_ = 0;  // of the line of sight: 0 towards +y, increasing towards +x
  double elevation_rad_ = 0;
};

// What key F frames: every fixture and the floor under it, and every display; the boxes if there are neither.
struct Bounds {
  glm::dvec3 low_m{-1};
  glm::dvec3 high_m{1};
};
[[nodiscard]] Bounds bounds_of(const fixtures::Rig& rig);

}  // namespace footlight::tools

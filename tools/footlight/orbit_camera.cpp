#include "tools/footlight/orbit_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace footlight::tools {
namespace {

constexpr double kElevationMaxRad = 89.5 * std::numbers::pi / 180;
constexpr double kDistanceMinM = 0.05;
constexpr double kDistanceMaxM = 2000;

}  // namespace

OrbitCamera::OrbitCamera(const fixtures::Camera& camera) : camera_(camera) {
  const glm::dvec3 way = camera.target_m - camera.position_m;
  distance_m_ = glm::length(way);
  if (!(distance_m_ > 1e-9)) {  // looks at itself: along +y, as the renderer does
    distance_m_ = 1;
    camera_.target_m = camera.position_m + glm::dvec3(0, 1, 0);
    return;
  }
  azimuth_rad_ = std::atan2(way.x, way.y);
  elevation_rad_ = std::asin(std::clamp(way.z / distance_m_, -1.0, 1.0));
}

glm::dvec3 OrbitCamera::forward() const {
  return {std::cos(elevation_rad_) * std::sin(azimuth_rad_), std::cos(elevation_rad_) * std::cos(azimuth_rad_),
          std::sin(elevation_rad_)};
}

fixtures::Camera OrbitCamera::camera() const {
  fixtures::Camera camera = camera_;
  camera.position_m = camera_.target_m - forward() * distance_m_;
  return camera;
}

void OrbitCamera::orbit(double right_rad, double up_rad) {
  azimuth_rad_ = std::remainder(azimuth_rad_ - right_rad, 2 * std::numbers::pi);
  elevation_rad_ = std::clamp(elevation_rad_ - up_rad, -kElevationMaxRad, kElevationMaxRad);
}

void OrbitCamera::pan(double right, double up) {
  const glm::dvec3 right_way(std::cos(azimuth_rad_), -std::sin(azimuth_rad_), 0);
  const glm::dvec3 up_way = glm::cross(right_way, forward());
  const double height_m = 2 * distance_m_ * std::tan(glm::radians(camera_.fov_deg) / 2);
  camera_.target_m += (right_way * right + up_way * up) * height_m;
}

void OrbitCamera::approach(double steps) {
  distance_m_ = std::clamp(distance_m_ * std::pow(0.9, steps), kDistanceMinM, kDistanceMaxM);
}

void OrbitCamera::frame(const glm::dvec3& low_m, const glm::dvec3& high_m, double aspect) {
  camera_.target_m = (low_m + high_m) * 0.5;
  const double radius_m = std::max(glm::length(high_m - low_m) * 0.5, 0.5);
  const double half_height_rad = glm::radians(camera_.fov_deg) / 2;
  const double half_width_rad = std::atan(std::tan(half_height_rad) * aspect);
  distance_m_ =
      std::clamp(radius_m / std::sin(std::min(half_height_rad, half_width_rad)), kDistanceMinM, kDistanceMaxM);
}

Bounds bounds_of(const fixtures::Rig& rig) {
  Bounds bounds{glm::dvec3(1e30), glm::dvec3(-1e30)};
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    bounds.low_m = glm::min(bounds.low_m, glm::dvec3(fixture.position_m.x, fixture.position_m.y, 0));
    bounds.low_m.z = std::min(bounds.low_m.z, fixture.position_m.z);
    bounds.high_m = glm::max(bounds.high_m, fixture.position_m);
  }
  if (rig.fixtures.empty()) {
    for (const fixtures::StageBox& box : rig.boxes) {
      bounds.low_m = glm::min(bounds.low_m, box.min_m);
      bounds.high_m = glm::max(bounds.high_m, box.max_m);
    }
  }
  return bounds.low_m.x <= bounds.high_m.x ? bounds : Bounds{};
}

}  // namespace footlight::tools

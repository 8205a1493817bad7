#include "tools/footlight/preview/orbit_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace footlight::tools {
namespace {

constexpr double kElevationMaxRad = 89.5 * std::numbers::pi / 180;
constexpr double kDistanceMinM = 0.05;
constexpr double kDistanceMaxM = 50'000;  // rigs reach 10 km
constexpr double kFilled = 0.92;          // share of the picture that the framed box fills

// Where the lines through the corners of a box, at the slopes of the picture's edges, meet the plane of the target.
struct Span {
  double low = 1e30;    // of place + depth half
  double high = -1e30;  // of place - depth half
  void add(double place, double depth_half) {
    low = std::min(low, place + depth_half);
    high = std::max(high, place - depth_half);
  }
  [[nodiscard]] double reach() const { return (high - low) / 2; }
  [[nodiscard]] double middle() const { return (high + low) / 2; }
};

}  // namespace

OrbitCamera::OrbitCamera(const fixtures::Camera& camera) : camera_(camera) {
  const glm::dvec3 way = camera.target_m - camera.position_m;
  distance_m_ = glm::length(way);
  if (!(distance_m_ > 1e-9)) {  // position equals target: along +y, as in the renderer
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

void OrbitCamera::fly(double right_m, double ahead_m, double up_m) {
  const glm::dvec3 right_way(std::cos(azimuth_rad_), -std::sin(azimuth_rad_), 0);
  const glm::dvec3 by_m = right_way * right_m + forward() * ahead_m + glm::dvec3(0, 0, up_m);
  const glm::dvec3 next_m = camera_.target_m + by_m;
  if (glm::length(next_m) <= kDistanceMaxM) camera_.target_m = next_m;
}

void OrbitCamera::look(double right_rad, double up_rad) {
  const glm::dvec3 eye_m = camera_.target_m - forward() * distance_m_;
  orbit(-right_rad, -up_rad);
  camera_.target_m = eye_m + forward() * distance_m_;
}

void OrbitCamera::frame(const glm::dvec3& low_m, const glm::dvec3& high_m, double aspect) {
  const glm::dvec3 middle = (low_m + high_m) * 0.5;
  const glm::dvec3 right_way(std::cos(azimuth_rad_), -std::sin(azimuth_rad_), 0);
  const glm::dvec3 forward_way = forward();
  const glm::dvec3 up_way = glm::cross(right_way, forward_way);
  const glm::dvec3 half = glm::max((high_m - low_m) * 0.5, glm::dvec3(0.3));
  // Half the picture at a depth of 1.
  const double half_height = std::tan(glm::radians(camera_.fov_deg) / 2) * kFilled;
  const double half_width = half_height * aspect;
  // Moved sideways by s, at distance d, the camera has a corner in the picture if |place - s| <= (d + depth) half. So s
  // is between max(place - depth half) - d half and min(place + depth half) + d half. The smallest d allows exactly one
  // s.
  Span across;
  Span upward;
  double nearest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at((corner & 1) != 0 ? half.x : -half.x, (corner & 2) != 0 ? half.y : -half.y,
                        (corner & 4) != 0 ? half.z : -half.z);
    const double depth = glm::dot(at, forward_way);
    across.add(glm::dot(at, right_way), depth * half_width);
    upward.add(glm::dot(at, up_way), depth * half_height);
    nearest = std::min(nearest, depth);
  }
  const double needed = std::max(across.reach() / half_width, upward.reach() / half_height);
  distance_m_ = std::clamp(std::max(needed, 0.1 - nearest), kDistanceMinM, kDistanceMaxM);
  camera_.target_m = middle + right_way * across.middle() + up_way * upward.middle();
}

Bounds bounds_of(const fixtures::Rig& rig) {
  Bounds bounds{glm::dvec3(1e30), glm::dvec3(-1e30)};
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    bounds.low_m = glm::min(bounds.low_m, glm::dvec3(fixture.position_m.x, fixture.position_m.y, 0));
    bounds.low_m.z = std::min(bounds.low_m.z, fixture.position_m.z);
    bounds.high_m = glm::max(bounds.high_m, fixture.position_m);
  }
  for (const fixtures::Display& display : rig.displays) {
    const glm::dmat4 pose = fixtures::pose_of(display);
    for (int corner = 0; corner < 4; ++corner) {
      const double x = (corner & 1) != 0 ? 0.5 : -0.5, z = (corner & 2) != 0 ? 0.5 : -0.5;
      const glm::dvec3 at = pose * glm::dvec4(x * display.width_m, 0, z * display.height_m, 1);
      bounds.low_m = glm::min(bounds.low_m, at);
      bounds.high_m = glm::max(bounds.high_m, at);
    }
  }
  if (rig.fixtures.empty() && rig.displays.empty()) {
    for (const fixtures::StageBox& box : rig.boxes) {
      bounds.low_m = glm::min(bounds.low_m, box.min_m);
      bounds.high_m = glm::max(bounds.high_m, box.max_m);
    }
  }
  return bounds.low_m.x <= bounds.high_m.x ? bounds : Bounds{};
}

}  // namespace footlight::tools

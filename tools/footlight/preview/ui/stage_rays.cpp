#include "tools/footlight/preview/ui/stage_rays.h"

#include <algorithm>
#include <cmath>

namespace footlight::tools {
namespace {

constexpr double kNearM = 0.02;
constexpr double kParallel = 1e-3;  // the sine of the angle below which lines are parallel

// False for NaN.
bool within(const glm::dvec3& v, double most) { return glm::dot(v, v) <= most * most; }

}  // namespace

glm::dvec2 slopes_of(const StagePlace& place) {
  const double up = place.view.tan_half_fov;
  return {up * place.size.x / std::max(place.size.y, 1.0), up};
}

std::optional<glm::dvec2> projected(const StagePlace& place, const glm::dvec3& point_m) {
  const glm::dvec3 way = point_m - place.view.position_m;
  const double depth = glm::dot(way, place.view.forward);
  if (!(depth > kNearM)) return std::nullopt;
  const glm::dvec2 slopes = slopes_of(place);
  return place.origin + glm::dvec2((1 + glm::dot(way, place.view.right) / (depth * slopes.x)) / 2 * place.size.x,
                                   (1 - glm::dot(way, place.view.up) / (depth * slopes.y)) / 2 * place.size.y);
}

std::optional<std::pair<glm::dvec2, glm::dvec2>> projected_line(const StagePlace& place, const glm::dvec3& from_m,
                                                                const glm::dvec3& to_m) {
  constexpr double kInFrontM = 2 * kNearM;  // so that the ends that are cut are in front as well
  const auto depth_of = [&](const glm::dvec3& at) { return glm::dot(at - place.view.position_m, place.view.forward); };
  const double from = depth_of(from_m);
  const double to = depth_of(to_m);
  if (!(std::max(from, to) > kInFrontM) || !std::isfinite(from) || !std::isfinite(to)) return std::nullopt;
  glm::dvec3 a = from_m;
  glm::dvec3 b = to_m;
  if (from < kInFrontM) a += (to_m - from_m) * ((kInFrontM - from) / (to - from));
  if (to < kInFrontM) b += (from_m - to_m) * ((kInFrontM - to) / (from - to));
  const auto start = projected(place, a);
  const auto end = projected(place, b);
  if (!start || !end) return std::nullopt;
  return std::pair(*start, *end);
}

std::optional<double> metres_per_unit(const StagePlace& place, const glm::dvec3& point_m) {
  const double depth = glm::dot(point_m - place.view.position_m, place.view.forward);
  if (!(depth > kNearM)) return std::nullopt;
  return 2 * depth * place.view.tan_half_fov / std::max(place.size.y, 1.0);
}

StageRay ray_through(const StagePlace& place, glm::dvec2 at) {
  at -= place.origin;
  const glm::dvec2 slopes = slopes_of(place);
  const glm::dvec3 way = place.view.forward +
                         place.view.right * ((2 * at.x / std::max(place.size.x, 1.0) - 1) * slopes.x) +
                         place.view.up * ((1 - 2 * at.y / std::max(place.size.y, 1.0)) * slopes.y);
  return {place.view.position_m, glm::normalize(way)};
}

std::optional<double> nearest_on_axis(const StageRay& ray, const glm::dvec3& origin_m, const glm::dvec3& axis) {
  const double slant = glm::dot(ray.way, axis);
  const double apart = 1 - slant * slant;  // the square of the sine between them
  if (!(apart > kParallel * kParallel)) return std::nullopt;
  const glm::dvec3 between = origin_m - ray.from_m;
  const double on_ray = (glm::dot(between, ray.way) - glm::dot(between, axis) * slant) / apart;
  const double on_axis = (glm::dot(between, ray.way) * slant - glm::dot(between, axis)) / apart;
  if (!(on_ray > 0) || !(std::abs(on_axis) <= kRayReachM)) return std::nullopt;
  return on_axis;
}

std::optional<glm::dvec3> on_plane(const StageRay& ray, const glm::dvec3& point_m, const glm::dvec3& normal) {
  const double slope = glm::dot(ray.way, normal);
  if (!(std::abs(slope) > kParallel)) return std::nullopt;
  const double along = glm::dot(point_m - ray.from_m, normal) / slope;
  if (!(along > 0)) return std::nullopt;
  const glm::dvec3 met = ray.from_m + ray.way * along;
  if (!within(met - point_m, kRayReachM)) return std::nullopt;
  return met;
}

std::optional<double> into_box(const glm::dvec3& from, const glm::dvec3& way, const glm::dvec3& low,
                               const glm::dvec3& high) {
  constexpr double kBeyond = 1e30;
  double enter = -kBeyond;
  double leave = kBeyond;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(way[i]) < 1e-12) {
      if (from[i] < low[i] || from[i] > high[i]) return std::nullopt;
      continue;
    }
    const double a = (low[i] - from[i]) / way[i];
    const double b = (high[i] - from[i]) / way[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (!(enter <= leave) || !(leave > 0)) return std::nullopt;
  return std::max(enter, 0.0);
}

std::optional<glm::dvec3> surface_on(const fixtures::Rig& rig, const StageRay& ray, double reach_m) {
  double nearest_m = reach_m;
  bool met = false;
  const auto take = [&](double at_m) {
    if (!(at_m > 0) || !(at_m <= nearest_m)) return;
    nearest_m = at_m;
    met = true;
  };
  for (const fixtures::StageBox& box : rig.boxes) {
    if (const auto enter = into_box(ray.from_m, ray.way, box.min_m, box.max_m)) take(*enter);
  }
  if (ray.way.z < -1e-9) take(-ray.from_m.z / ray.way.z);
  if (!met) return std::nullopt;
  return ray.from_m + ray.way * nearest_m;
}

double distance_to_line(glm::dvec2 at, glm::dvec2 from, glm::dvec2 to) {
  const glm::dvec2 way = to - from;
  const double length_2 = glm::dot(way, way);
  const double share = length_2 > 0 ? std::clamp(glm::dot(at - from, way) / length_2, 0.0, 1.0) : 0;
  return glm::length(at - (from + way * share));
}

double snapped(double value, double step) { return std::round(value / step) * step; }

}  // namespace footlight::tools

// Points, rays and lines between a stage and its picture: what handles, clicks and measuring compute with. No Dear
// ImGui. Results are finite; where there is none, such as for a ray along a plane, nothing is returned.
#pragma once

#include <optional>
#include <utility>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "render/image.h"

namespace footlight::tools {

// A part of the window in units of the user interface, with a picture of `view` in it.
struct StagePlace {
  render::View view;
  glm::dvec2 size{1};
  glm::dvec2 origin{0};  // its top left
  [[nodiscard]] glm::dvec2 end() const { return origin + size; }
};

// Half the picture's width and height at a depth of 1.
[[nodiscard]] glm::dvec2 slopes_of(const StagePlace& place);

// Where a point of the stage is; nothing if it is not in front of the camera.
[[nodiscard]] std::optional<glm::dvec2> projected(const StagePlace& place, const glm::dvec3& point_m);
// The part of a line that is in front of the camera; nothing if no part is.
[[nodiscard]] std::optional<std::pair<glm::dvec2, glm::dvec2>> projected_line(const StagePlace& place,
                                                                              const glm::dvec3& from_m,
                                                                              const glm::dvec3& to_m);
// How long a line across the picture is at this point, for one unit of the user interface; nothing behind the camera.
[[nodiscard]] std::optional<double> metres_per_unit(const StagePlace& place, const glm::dvec3& point_m);

struct StageRay {
  glm::dvec3 from_m{0};
  glm::dvec3 way{0, 0, -1};  // unit
};
// From the camera through a point of the picture.
[[nodiscard]] StageRay ray_through(const StagePlace& place, glm::dvec2 at);

// Results farther from the origin of an axis or a plane than this are none: the ray is almost parallel.
inline constexpr double kRayReachM = 10'000;

// The point of an axis that is nearest to a ray, in metres from origin_m. axis: unit. Nothing if they are parallel
// within 0.06 degrees, or if the ray would have to go back.
[[nodiscard]] std::optional<double> nearest_on_axis(const StageRay& ray, const glm::dvec3& origin_m,
                                                    const glm::dvec3& axis);
// Where a ray meets a plane. normal: unit. Nothing if it runs along the plane within 0.06 degrees, or away from it.
[[nodiscard]] std::optional<glm::dvec3> on_plane(const StageRay& ray, const glm::dvec3& point_m,
                                                 const glm::dvec3& normal);
// The distance in units of `way` at which a ray comes into a box; nothing: it does not. 0: it starts inside.
[[nodiscard]] std::optional<double> into_box(const glm::dvec3& from, const glm::dvec3& way, const glm::dvec3& low,
                                             const glm::dvec3& high);

// The first surface that a ray meets within reach_m: a box of the stage, or the floor at height 0. A ray that starts in
// a box leaves it. Displays, scenery and other meshes are not looked at.
[[nodiscard]] std::optional<glm::dvec3> surface_on(const fixtures::Rig& rig, const StageRay& ray, double reach_m);

// Of a point to a line between two others, in the picture.
[[nodiscard]] double distance_to_line(glm::dvec2 at, glm::dvec2 from, glm::dvec2 to);
// The nearest multiple of step > 0.
[[nodiscard]] double snapped(double value, double step);

}  // namespace footlight::tools

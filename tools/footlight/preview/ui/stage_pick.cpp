#include "tools/footlight/preview/ui/stage_pick.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "fixtures/bodies/primitives.h"

namespace footlight::tools {
namespace {

using Box = StagePick::Box;

constexpr double kSmallestHalfM = 0.1;
constexpr double kNever = 1e30;

void include(Box& box, const glm::dvec3& point_m) {
  box.low_m = glm::min(box.low_m, point_m);
  box.high_m = glm::max(box.high_m, point_m);
}

glm::dvec3 corner_of(const glm::dvec3& low, const glm::dvec3& high, int number) {
  return {(number & 1) != 0 ? high.x : low.x, (number & 2) != 0 ? high.y : low.y, (number & 4) != 0 ? high.z : low.z};
}

Box body_box(const fixtures::FixtureType& type, const fixtures::Mode& mode) {
  Box box;
  std::vector<glm::dmat4> poses;
  bool models = false;
  for (const fixtures::Geometry& geometry : mode.geometries) {
    const bool root = geometry.parent == fixtures::kNoIndex;
    poses.push_back(root ? geometry.pose : poses[static_cast<std::size_t>(geometry.parent)] * geometry.pose);
    include(box, glm::dvec3(poses.back()[3]));
    if (geometry.model == fixtures::kNoIndex) continue;
    models = true;
    const glm::dvec3 half = type.models[static_cast<std::size_t>(geometry.model)].size_m / 2.0;
    for (int c = 0; c < 8; ++c) include(box, glm::dvec3(poses.back() * glm::dvec4(corner_of(-half, half, c), 1)));
  }
  const bool simple =
      !models && type.body != fixtures::BodyModel::kNone && !type.beams.empty() && mode.geometries.size() == 4;
  if (simple) {
    const fixtures::BodySize size = fixtures::body_size(type, mode);
    for (const fixtures::BodyVertex& vertex : fixtures::make_body(type.body, size).vertices) {
      const bool head = vertex.part == fixtures::kPartHead || vertex.part == fixtures::kPartLens;
      include(box, glm::dvec3(vertex.position[0], vertex.position[1],
                              static_cast<double>(vertex.position[2]) - (head ? size.pivot_drop_m : 0)));
    }
  }
  if (!(box.low_m.x <= box.high_m.x)) box = {glm::dvec3(0), glm::dvec3(0)};
  const glm::dvec3 middle = (box.low_m + box.high_m) / 2.0;
  const glm::dvec3 half = glm::max((box.high_m - box.low_m) / 2.0, glm::dvec3(kSmallestHalfM));
  return {middle - half, middle + half};
}

}  // namespace

StagePick::StagePick(const fixtures::Rig& rig) : rig_(rig) {
  std::map<std::pair<int, int>, std::size_t> known;
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    const auto [at, fresh] = known.emplace(std::pair(fixture.type, fixture.mode), boxes_.size());
    if (fresh) boxes_.push_back(body_box(fixtures::type_of(rig, fixture), fixtures::mode_of(rig, fixture)));
    box_index_.push_back(at->second);
  }
}

glm::dvec3 StagePick::middle_of(std::size_t fixture) const {
  const Box& box = boxes_[box_index_[fixture]];
  return glm::dvec3(fixtures::pose_of(rig_.fixtures[fixture]) * glm::dvec4((box.low_m + box.high_m) / 2.0, 1));
}

double StagePick::wall_on(const glm::dvec3& from, const glm::dvec3& way) const {
  double wall = kNever;
  for (const fixtures::StageBox& box : rig_.boxes) {
    const auto enter = into_box(from, way, box.min_m, box.max_m);
    if (enter && *enter > 0) wall = std::min(wall, *enter);  // a camera within a box sees out of it, as in the picture
  }
  return wall;
}

std::vector<int> StagePick::fixtures_in(const StagePlace& place, glm::dvec2 low, glm::dvec2 high) const {
  std::vector<int> inside;
  for (std::size_t i = 0; i < rig_.fixtures.size(); ++i) {
    const glm::dvec3 middle = middle_of(i);
    const auto seen = projected(place, middle);
    if (!seen || seen->x < low.x || seen->y < low.y || seen->x > high.x || seen->y > high.y) continue;
    if (wall_on(place.view.position_m, middle - place.view.position_m) < 1) continue;
    inside.push_back(static_cast<int>(i));
  }
  return inside;
}

int StagePick::fixture_at(const StagePlace& place, glm::dvec2 at, double reach_units) const {
  const glm::dvec2 slopes = slopes_of(place);
  const glm::dvec3 from = place.view.position_m;
  const glm::dvec2 inside = at - place.origin;
  const glm::dvec3 way = place.view.forward + place.view.right * ((2 * inside.x / place.size.x - 1) * slopes.x) +
                         place.view.up * ((1 - 2 * inside.y / place.size.y) * slopes.y);
  const double wall = wall_on(from, way);
  int nearest = -1;
  int beside = -1;
  double nearest_depth = wall;
  double least = reach_units;
  for (std::size_t i = 0; i < rig_.fixtures.size(); ++i) {
    const Box& box = boxes_[box_index_[i]];
    const glm::dmat4 pose = fixtures::pose_of(rig_.fixtures[i]);
    const glm::dvec3 middle = middle_of(i);
    const double depth = glm::dot(middle - from, place.view.forward);
    const auto seen = projected(place, middle);
    if (seen && depth < wall) {
      const double off = glm::length(*seen - at);
      if (off < least) {
        least = off;
        beside = static_cast<int>(i);
      }
    }
    // The sphere around the box first: most rays miss it.
    const double scale = std::max(
        {glm::length(glm::dvec3(pose[0])), glm::length(glm::dvec3(pose[1])), glm::length(glm::dvec3(pose[2]))});
    const double radius = scale * glm::length(box.high_m - box.low_m) / 2;
    const double along = glm::dot(middle - from, way) / glm::dot(way, way);
    if (glm::length(middle - from - way * along) > radius) continue;
    const glm::dmat4 back = glm::inverse(pose);
    const auto enter =
        into_box(glm::dvec3(back * glm::dvec4(from, 1)), glm::dvec3(back * glm::dvec4(way, 0)), box.low_m, box.high_m);
    if (enter && *enter < nearest_depth) {
      nearest_depth = *enter;
      nearest = static_cast<int>(i);
    }
  }
  return nearest >= 0 ? nearest : beside;
}

std::optional<StagePick::Mark> StagePick::mark_of(const StagePlace& place, int fixture) const {
  const Box& box = box_of(fixture);
  const glm::dmat4 pose = fixtures::pose_of(rig_.fixtures[static_cast<std::size_t>(fixture)]);
  Mark mark{glm::dvec2(kNever), glm::dvec2(-kNever)};
  for (int c = 0; c < 8; ++c) {
    const auto seen = projected(place, glm::dvec3(pose * glm::dvec4(corner_of(box.low_m, box.high_m, c), 1)));
    if (!seen) return std::nullopt;
    mark.low = glm::min(mark.low, *seen);
    mark.high = glm::max(mark.high, *seen);
  }
  const glm::dvec2 end = place.end();
  const bool beside = mark.high.x < place.origin.x || mark.high.y < place.origin.y || mark.low.x > end.x ||
                      mark.low.y > end.y;
  return beside ? std::nullopt : std::optional(mark);
}

Box StagePick::bounds_of(std::span<const int> which) const {
  Box bounds;
  for (const int fixture : which) {
    const Box& box = box_of(fixture);
    const glm::dmat4 pose = fixtures::pose_of(rig_.fixtures[static_cast<std::size_t>(fixture)]);
    for (int c = 0; c < 8; ++c) include(bounds, glm::dvec3(pose * glm::dvec4(corner_of(box.low_m, box.high_m, c), 1)));
  }
  return bounds;
}

}  // namespace footlight::tools

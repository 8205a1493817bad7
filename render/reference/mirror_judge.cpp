#include "render/reference/mirror_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "fixtures/mirrors/mirror_ball.h"
#include "render/haze.h"

namespace footlight::render {
namespace {

constexpr double kGrazing = 0.01;  // mirrors that light passes at less than this sine send none

// Where the light of a beam seems to come from: light that reaches a place goes along the line from there.
glm::dvec3 way_of_light(const JudgeBeam& beam, const glm::dvec3& place_m) {
  if (!(beam.spread > 0)) return beam.axis;
  return glm::normalize(place_m - (beam.lens_m - beam.axis * (beam.lens_radius_m / beam.spread)));
}

// Radius of a disc with the area of the lens.
double source_radius(const JudgeBeam& beam) {
  if (beam.aspect <= 0) return beam.lens_radius_m;
  return std::sqrt(4 * beam.lens_radius_m * beam.lens_radius_m / beam.aspect / std::numbers::pi);
}

// Distance to the apex; infinite for light that is parallel.
double apex_distance(const JudgeBeam& beam, const glm::dvec3& place_m) {
  return glm::length(place_m - beam.lens_m + beam.axis * (beam.lens_radius_m / beam.spread));
}

// The convolution of two discs, as a profile and a factor of its radius.
struct Blur {
  double profile_power = 4;
  double scale = 1;
};
Blur blur_of(double outline_m, double image_m) {
  const double whole = outline_m + image_m;
  const double square = (outline_m * outline_m + image_m * image_m) / (2 * whole * whole);
  constexpr std::array<std::pair<double, double>, 5> kProfiles = {
      {{4, 5.0 / 12}, {3, 2.0 / 5}, {2, 3.0 / 8}, {1, 1.0 / 3}, {0.5, 1.0 / 4}}};
  const auto* best = &kProfiles[0];
  for (const auto& each : kProfiles) {
    if (std::abs(each.second - square) < std::abs(best->second - square)) best = &each;
  }
  return {best->first, std::sqrt(square / best->second)};
}

void add_mirror(const JudgeBeam& lamp, const fixtures::MirrorBall& ball, const glm::dvec3& center_m,
                const glm::dvec3& normal, JudgeScene& scene) {
  const glm::dvec3 place_m = center_m + ball.diameter_m / 2 * normal;
  const glm::dvec3 way = way_of_light(lamp, place_m);
  const double cosine = -glm::dot(way, normal);
  if (!(cosine > kGrazing)) return;
  // With the cosine, and with what the haze takes on the way.
  const double share = judge_illuminance(lamp, scene.haze, place_m, normal, scene.gobo);
  if (!(share > 0)) return;
  const double area_m2 = ball.mirror_m * ball.mirror_m;
  const double distance_m = glm::dot(place_m - lamp.lens_m, lamp.axis) / glm::dot(way, lamp.axis);
  const double source_m = source_radius(lamp);
  const double to_center_m = glm::distance(center_m, lamp.lens_m);
  const bool parallel = !(lamp.spread > 0);
  const double grown = parallel ? 1 : 1 + to_center_m / apex_distance(lamp, center_m);
  const Blur blur = blur_of(std::sqrt(area_m2 / std::numbers::pi) * grown, source_m);
  JudgeBeam beam;
  beam.lens_m = place_m;
  beam.axis = glm::normalize(way - 2 * glm::dot(way, normal) * normal);
  const glm::dvec3 aside = std::abs(beam.axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  beam.x_axis = glm::normalize(glm::cross(beam.axis, aside));
  beam.y_axis = glm::cross(beam.axis, beam.x_axis);
  beam.lens_radius_m = blur.scale * std::sqrt(area_m2 * cosine / std::numbers::pi);
  const double outline_spread = parallel ? 0 : beam.lens_radius_m / apex_distance(lamp, place_m);
  beam.spread = std::min(outline_spread + blur.scale * source_m / distance_m, 1.0);
  beam.profile_power = blur.profile_power;
  beam.range_m = lamp.range_m;
  beam.strength_lm =
      lamp.strength_lm * (share * area_m2 * ball.reflectance / judge_flux_factor(beam.spread, beam.profile_power));
  scene.beams.push_back(beam);
}

}  // namespace

void add_mirrored(const fixtures::Rig& rig, fixtures::f64::Walker& walker, std::span<const std::size_t> heads,
                  JudgeScene& scene) {
  const std::vector<JudgeBeam> lamps(scene.beams.begin(), scene.beams.end());
  const fixtures::CompiledRig& compiled = walker.rig;
  for (const fixtures::MirrorPairRow& pair : compiled.mirror_pairs) {
    const std::size_t head = compiled.mirror_balls[pair.ball].head;
    const fixtures::HeadRow& row = compiled.heads[head];
    const fixtures::TypeSource& source = compiled.sources[row.type];
    const fixtures::FixtureType& type = rig.types[static_cast<std::size_t>(source.type)];
    const fixtures::Mode& mode = type.modes[static_cast<std::size_t>(source.mode)];
    const fixtures::Geometry& geometry = mode.geometries[static_cast<std::size_t>(source.geometry)];
    fixtures::MirrorBall ball = type.mirror_balls[static_cast<std::size_t>(geometry.mirror_ball)];
    const double scale = fixtures::ball_scale(rig.fixtures[row.fixture]);
    const std::vector<glm::dvec3> normals = fixtures::mirror_normals(ball);
    ball.diameter_m *= scale;
    ball.mirror_m *= scale;
    const auto pose = walker.beam_pose(row, compiled.types[row.type], walker.states[head]);
    const glm::dmat3 turn(glm::dvec3(pose.x_axis), -glm::dvec3(pose.y_axis), -glm::dvec3(pose.axis));
    for (std::size_t i = 0; i < lamps.size(); ++i) {
      if (heads[i] != pair.head) continue;
      for (const glm::dvec3& normal : normals) {
        add_mirror(lamps[i], ball, pose.lens_m, turn * normal, scene);
        add_mirror(lamps[i], ball, pose.lens_m, -(turn * normal), scene);
      }
    }
  }
}

}  // namespace footlight::render

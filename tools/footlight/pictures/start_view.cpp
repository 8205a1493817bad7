#include "tools/footlight/pictures/start_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "fixtures/bodies/body.h"
#include "fixtures/model/degrees.h"
#include "tools/footlight/preview/orbit_camera.h"

namespace footlight::tools {
namespace {

constexpr double kMarginM = 0.6;  // bodies reach so far from where they hang
constexpr double kFilled = 0.92;  // of the picture
constexpr double kFovMaxDeg = 95;
constexpr double kEyeM = 1.7;
constexpr double kFromWallM = 0.4;
constexpr double kColumn = 0.03;         // half the width of a column, over half that of the picture
constexpr std::size_t kSamplesMax = 32;  // fixtures that are looked for
constexpr std::size_t kChunk = 256;      // triangles that share a bounding box

// What is in the way: the triangles of the scene's objects in boxes of kChunk.
class Obstacles {
 public:
  explicit Obstacles(const fixtures::Rig& rig) {
    fixtures::Diagnostics diagnostics;  // reported when the scene is drawn
    const fixtures::Mesh mesh = fixtures::scene_mesh(rig, diagnostics);
    for (const std::uint32_t index : mesh.indices) corners_.emplace_back(mesh.vertices[index].position_m);
    for (std::size_t at = 0; at < corners_.size(); at += 3 * kChunk) {
      Bounds box{glm::dvec3(1e30), glm::dvec3(-1e30)};
      for (const glm::dvec3& corner : chunk(at)) {
        box.low_m = glm::min(box.low_m, corner);
        box.high_m = glm::max(box.high_m, corner);
      }
      boxes_.push_back(box);
    }
  }

  // How far from `from` along the unit `way` the first triangle is; `far` where there is none before.
  [[nodiscard]] double first_m(const glm::dvec3& from, const glm::dvec3& way, double far) const {
    for (std::size_t b = 0; b < boxes_.size(); ++b) {
      if (!meets(boxes_[b], from, way, far)) continue;
      const auto corners = chunk(b * 3 * kChunk);
      for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
        // Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
        const glm::dvec3 u = corners[i + 1] - corners[i];
        const glm::dvec3 v = corners[i + 2] - corners[i];
        const glm::dvec3 p = glm::cross(way, v);
        const double determinant = glm::dot(u, p);
        if (std::abs(determinant) < 1e-14) continue;
        const glm::dvec3 s = from - corners[i];
        const double a = glm::dot(s, p) / determinant;
        const glm::dvec3 q = glm::cross(s, u);
        const double c = glm::dot(way, q) / determinant;
        const double t = glm::dot(v, q) / determinant;
        if (a >= 0 && c >= 0 && a + c <= 1 && t > 1e-6 && t < far) far = t;
      }
    }
    return far;
  }

 private:
  [[nodiscard]] std::span<const glm::dvec3> chunk(std::size_t at) const {
    return std::span(corners_).subspan(at, std::min(3 * kChunk, corners_.size() - at));
  }

  static bool meets(const Bounds& box, const glm::dvec3& from, const glm::dvec3& way, double far) {
    double enter = 0;
    double leave = far;
    for (int i = 0; i < 3; ++i) {
      const double inverse = 1 / (std::abs(way[i]) > 1e-12 ? way[i] : 1e-12);
      const double a = (box.low_m[i] - from[i]) * inverse;
      const double b = (box.high_m[i] - from[i]) * inverse;
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
  }

  std::vector<glm::dvec3> corners_;
  std::vector<Bounds> boxes_;
};

// Half the picture's height at a depth of 1 that a camera there needs for a point; infinite for one behind it.
double needed(const glm::dvec3& position, const glm::dvec3& target, const glm::dvec3& point, double aspect) {
  const glm::dvec3 forward = glm::normalize(target - position);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
  const glm::dvec3 above = glm::cross(right, forward);
  const glm::dvec3 way = point - position;
  const double depth = glm::dot(way, forward);
  if (!(depth > 0.3)) return std::numeric_limits<double>::infinity();
  return std::max(std::abs(glm::dot(way, above)), std::abs(glm::dot(way, right)) / aspect) / depth;
}

// Where a point is across the picture, 0 in its middle, times the depth of half its width.
double across_of(const glm::dvec3& position, const glm::dvec3& target, const glm::dvec3& point) {
  const glm::dvec3 forward = glm::normalize(target - position);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
  const glm::dvec3 way = point - position;
  return glm::dot(way, right) / std::max(glm::dot(way, forward), 0.3);
}

// Largest share of the fixtures that are in one column of the picture, behind or above each other.
double in_one_column(const std::vector<double>& across, double half_width) {
  std::size_t most = 0;
  for (const double one : across) {
    const auto near = [&](double other) { return std::abs(other - one) < kColumn * half_width; };
    most = std::max(most, static_cast<std::size_t>(std::count_if(across.begin(), across.end(), near)));
  }
  return static_cast<double>(most) / static_cast<double>(across.size());
}

// Of all lamps at full.
double flux_lm(const fixtures::Rig& rig) {
  double sum = 0;
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    const fixtures::FixtureType& type = rig.types[static_cast<std::size_t>(fixture.type)];
    for (const auto& geometry : type.modes[static_cast<std::size_t>(fixture.mode)].geometries) {
      if (geometry.kind != fixtures::GeometryKind::kBeam || geometry.beam == fixtures::kNoIndex) continue;
      const fixtures::Beam& beam = type.beams[static_cast<std::size_t>(geometry.beam)];
      const bool shines = beam.type != fixtures::BeamType::kNone && beam.type != fixtures::BeamType::kGlow;
      if (shines && std::isfinite(beam.flux_lm)) sum += std::clamp(beam.flux_lm, 0.0, 1e7);
    }
  }
  return sum;
}

}  // namespace

fixtures::Camera start_view(const fixtures::Rig& rig, double aspect, bool lit) {
  fixtures::Camera camera;
  camera.name = "start";
  Bounds bounds = bounds_of(rig);
  const double floor_m = std::min(bounds.low_m.z, 0.0);
  // As much of what is below the rig as it is wide.
  const double width_m = std::max({bounds.high_m.x - bounds.low_m.x, bounds.high_m.y - bounds.low_m.y, 4.0});
  double lowest_m = bounds.high_m.z;
  for (const auto& fixture : rig.fixtures) lowest_m = std::min(lowest_m, fixtures::pose_of(fixture)[3].z);
  for (const auto& display : rig.displays) {
    lowest_m = std::min(lowest_m, display.position_m.z - 0.5 * std::hypot(display.width_m, display.height_m));
  }
  bounds.low_m.z = std::max(bounds.low_m.z, lowest_m - width_m);
  bounds.low_m -= glm::dvec3(kMarginM, kMarginM, 0);
  bounds.high_m += glm::dvec3(kMarginM, kMarginM, 0.5 * kMarginM);
  const glm::dvec3 centre = (bounds.low_m + bounds.high_m) * 0.5;
  std::array<glm::dvec3, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners[static_cast<std::size_t>(i)] = {(i & 1) != 0 ? bounds.high_m.x : bounds.low_m.x,
                                            (i & 2) != 0 ? bounds.high_m.y : bounds.low_m.y,
                                            (i & 4) != 0 ? bounds.high_m.z : bounds.low_m.z};
  }
  std::vector<glm::dvec3> samples;
  const std::size_t every = rig.fixtures.size() / kSamplesMax + 1;
  for (std::size_t i = 0; i < rig.fixtures.size(); i += every) {
    const glm::dmat4 pose = fixtures::pose_of(rig.fixtures[i]);
    const double length = glm::length(glm::dvec3(pose[2]));
    // A little below what it hangs from.
    samples.push_back(glm::dvec3(pose[3]) - (length > 0 ? glm::dvec3(pose[2]) * (0.25 / length) : glm::dvec3(0)));
  }
  if (samples.empty()) samples.push_back(centre);

  const Obstacles obstacles(rig);
  const double half_height = std::tan(camera.fov_deg / 2 * fixtures::kRadPerDeg) * kFilled;
  const double half_height_max = std::tan(kFovMaxDeg / 2 * fixtures::kRadPerDeg) * kFilled;
  if (lit) {
    constexpr double kGrey = 0.3;
    constexpr double kHalfWhite = 0.5 * 1.2;
    const double floor_m2 = (bounds.high_m.x - bounds.low_m.x + 2) * (bounds.high_m.y - bounds.low_m.y + 2);
    const double cd_m2 = flux_lm(rig) / floor_m2 * kGrey / std::numbers::pi;
    camera.exposure_ev = std::clamp(std::log2(std::max(cd_m2, 1e-9) / kHalfWhite), camera.exposure_ev, 14.0);
  }
  double best = -1;
  for (const double azimuth_deg : {0.0, 25.0, -25.0, 50.0, -50.0, 90.0, -90.0, 135.0, -135.0, 180.0}) {
    for (const double elevation_deg : {8.0, 20.0, -8.0, -20.0}) {
      const double azimuth = azimuth_deg * fixtures::kRadPerDeg;
      const double elevation = elevation_deg * fixtures::kRadPerDeg;
      const glm::dvec3 out(std::sin(azimuth) * std::cos(elevation), -std::cos(azimuth) * std::cos(elevation),
                           std::sin(elevation));
      const auto at = [&](double distance) {
        glm::dvec3 position = centre + out * distance;
        position.z = std::max(position.z, floor_m + kEyeM);
        return position;
      };
      const auto needs = [&](const glm::dvec3& position) {
        double most = 0;
        for (const glm::dvec3& corner : corners) most = std::max(most, needed(position, centre, corner, aspect));
        return most;
      };
      double near = 0.5;
      double far = 4;
      while (far < 1e5 && needs(at(far)) > half_height) far *= 2;
      for (int i = 0; i < 30; ++i) (needs(at((near + far) / 2)) > half_height ? near : far) = (near + far) / 2;

      // A wall in between: the camera stays in front of it.
      const glm::dvec3 unobstructed = at(far);
      const glm::dvec3 way = glm::normalize(unobstructed - centre);
      const double whole_m = glm::length(unobstructed - centre);
      const double free_m = obstacles.first_m(centre, way, whole_m + kFromWallM) - kFromWallM;
      const glm::dvec3 position = centre + way * std::max(std::min(whole_m, free_m), 1.0);
      const double fits = std::clamp(needs(position), half_height, half_height_max);
      std::size_t seen = 0;
      std::vector<double> across;
      for (const glm::dvec3& sample : samples) {
        across.push_back(across_of(position, centre, sample));
        if (needed(position, centre, sample, aspect) > fits) continue;
        const double distance = glm::length(sample - position);
        const glm::dvec3 to_eye = (position - sample) / std::max(distance, 1e-9);
        if (obstacles.first_m(sample, to_eye, distance) >= distance) ++seen;
      }
      // The front, and a usual field of view, where they cost few fixtures; but not with most of them in one column.
      const double score = static_cast<double>(seen) / static_cast<double>(samples.size()) -
                           0.3 * std::max(in_one_column(across, fits * aspect) - 0.5, 0.0) -
                           0.15 * std::abs(azimuth_deg) / 180 - 0.1 * std::abs(elevation_deg - 8) / 30 -
                           0.3 * (fits - half_height) / (half_height_max - half_height);
      if (score <= best) continue;
      best = score;
      camera.position_m = position;
      camera.target_m = centre;
      camera.fov_deg = 2 * std::atan(fits / kFilled) / fixtures::kRadPerDeg;
    }
  }
  return camera;
}

void add_start_view(fixtures::Rig& rig, double aspect, bool lit) {
  if (rig.made_up_cameras) rig.cameras.insert(rig.cameras.begin(), start_view(rig, aspect, lit));
}

double work_light_lx(double exposure_ev) {
  constexpr double kWorkLightLx = 150;
  return std::max(kWorkLightLx, faint_light_lx(exposure_ev));
}

double faint_light_lx(double exposure_ev) { return 2.5 * std::exp2(exposure_ev); }

}  // namespace footlight::tools

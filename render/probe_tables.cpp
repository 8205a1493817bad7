#include "render/probe_tables.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "fixtures/bodies/solids.h"
#include "render/pass.h"
#include "render/sheen_rays.h"

namespace footlight::render {
namespace {

using fixtures::ReflectionProbe;
using fixtures::SolidBox;
using glm::dvec3;

// Walls and floors so far from lamps and scenery belong to the room.
constexpr dvec3 kReachM{10, 10, 30};
constexpr double kLampM = 0.5;    // around the place of a lamp
constexpr double kLeastM = 0.1;   // a side of the box

bool is_inside(const SolidBox& solid, const dvec3& at) {
  const double volume = glm::dot(solid.half_m[0], glm::cross(solid.half_m[1], solid.half_m[2]));
  if (volume == 0) return false;
  for (int i = 0; i < 3; ++i) {
    const dvec3 dual = glm::cross(solid.half_m[(i + 1) % 3], solid.half_m[(i + 2) % 3]) / volume;
    if (!(std::abs(glm::dot(dual, at - solid.center_m)) < 1)) return false;
  }
  return true;
}
bool is_covered(const std::vector<SolidBox>& solids, const dvec3& at) {
  return std::any_of(solids.begin(), solids.end(), [&](const SolidBox& solid) { return is_inside(solid, at); });
}

// Moves the sides of the box to the inner faces of the stage boxes around it. A side without one is open, and goes to
// where the others end: mirrored rays that leave there see nothing wherever it is, and those that do not still end at
// the right wall.
void reach_walls(const std::vector<fixtures::StageBox>& boxes, ReflectionProbe& probe) {
  const dvec3 low = probe.min_m, high = probe.max_m, middle = 0.5 * (low + high);
  dvec3 far_low = low, far_high = high;
  bool open_low[3] = {true, true, true}, open_high[3] = {true, true, true};
  for (const fixtures::StageBox& box : boxes) {
    const bool near = glm::all(glm::lessThan(box.min_m, high + kReachM)) &&
                      glm::all(glm::greaterThan(box.max_m, low - kReachM));
    if (!near) continue;
    for (int axis = 0; axis < 3; ++axis) {
      if (box.max_m[axis] <= middle[axis]) {
        probe.min_m[axis] = std::min(probe.min_m[axis], box.max_m[axis]);
        open_low[axis] = open_low[axis] && box.max_m[axis] > low[axis] + kLampM;
      }
      if (box.min_m[axis] >= middle[axis]) {
        probe.max_m[axis] = std::max(probe.max_m[axis], box.min_m[axis]);
        open_high[axis] = open_high[axis] && box.min_m[axis] < high[axis] - kLampM;
      }
      far_low[axis] = std::min(far_low[axis], std::max(box.min_m[axis], low[axis] - kReachM[axis]));
      far_high[axis] = std::max(far_high[axis], std::min(box.max_m[axis], high[axis] + kReachM[axis]));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (open_low[axis]) probe.min_m[axis] = far_low[axis];
    if (open_high[axis]) probe.max_m[axis] = far_high[axis];
  }
}

// A display before a wall is what is looked at there: the side goes to its face. Left alone are those that are small,
// or askew, or farther from the side.
void reach_displays(const std::vector<fixtures::Display>& displays, ReflectionProbe& probe) {
  constexpr double kLeastM2 = 2, kBeforeWallM = 2, kStraight = 0.98;
  const dvec3 low = probe.min_m, high = probe.max_m, middle = 0.5 * (low + high);
  for (const fixtures::Display& display : displays) {
    if (display.width_m * display.height_m < kLeastM2 || !(display.nits > 0)) continue;
    const dvec3 front = -dvec3(fixtures::pose_of(display)[1]), at = display.position_m;
    for (int axis = 0; axis < 3; ++axis) {
      if (front[axis] > kStraight && at[axis] < middle[axis] && std::abs(at[axis] - low[axis]) < kBeforeWallM) {
        probe.min_m[axis] = std::max(probe.min_m[axis], at[axis]);
      }
      if (-front[axis] > kStraight && at[axis] > middle[axis] && std::abs(at[axis] - high[axis]) < kBeforeWallM) {
        probe.max_m[axis] = std::min(probe.max_m[axis], at[axis]);
      }
    }
  }
}

ReflectionProbe own_probe(const fixtures::Rig& rig, const std::vector<SolidBox>& solids) {
  ReflectionProbe probe;
  probe.min_m = dvec3(std::numeric_limits<double>::max());
  probe.max_m = dvec3(std::numeric_limits<double>::lowest());
  const auto add = [&](const dvec3& low, const dvec3& high) {
    probe.min_m = glm::min(probe.min_m, low);
    probe.max_m = glm::max(probe.max_m, high);
  };
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    add(fixture.position_m - kLampM, fixture.position_m + kLampM);
  }
  for (std::size_t s = rig.boxes.size(); s < solids.size(); ++s) {
    const SolidBox& solid = solids[s];
    const dvec3 reach = glm::abs(solid.half_m[0]) + glm::abs(solid.half_m[1]) + glm::abs(solid.half_m[2]);
    add(solid.center_m - reach, solid.center_m + reach);
  }
  if (rig.fixtures.empty() && solids.size() == rig.boxes.size()) {
    for (const fixtures::StageBox& box : rig.boxes) add(box.min_m, box.max_m);
  }
  reach_walls(rig.boxes, probe);
  reach_displays(rig.displays, probe);
  return probe;
}

}  // namespace

std::vector<ReflectionProbe> scene_probes(const fixtures::Rig& rig) {
  std::vector<ReflectionProbe> probes = rig.probes;
  if (probes.empty()) {
    const std::vector<SolidBox> solids = fixtures::scene_solids(rig);
    ReflectionProbe own = own_probe(rig, solids);
    if (!glm::all(glm::greaterThan(own.max_m - own.min_m, dvec3(kLeastM)))) return {};
    // From the middle, or above it where that is inside something.
    dvec3 at = 0.5 * (own.min_m + own.max_m);
    const double step_m = (own.max_m.z - at.z) / 16;
    for (int i = 0; i < 15 && is_covered(solids, at); ++i) at.z += step_m;
    own.position_m = at;
    // Floors go on beside it, and what they mirror is still there.
    own.blend_m = std::max(own.blend_m, 0.5 * std::max(own.max_m.x - own.min_m.x, own.max_m.y - own.min_m.y));
    probes.push_back(own);
  }
  for (ReflectionProbe& probe : probes) {
    if (!probe.position_m) probe.position_m = 0.5 * (probe.min_m + probe.max_m);
  }
  return probes;
}

std::uint64_t probe_bytes(std::uint32_t binding, const MemoryShape& shape) {
  const bool is_one = binding == FL_BINDING_PROBES || binding == FL_BINDING_PROBE_LIGHT;
  if (!is_one || !has_probes(shape.needs, shape.settings)) return 0;
  const std::uint64_t probes = std::max<std::size_t>(shape.rig.probes.size(), 1);
  if (binding == FL_BINDING_PROBES) return probes * sizeof(ProbeRow);
  return (std::uint64_t{FL_PROBE_SHARES} * FL_PROBE_SHARES + probes * FL_PROBE_ALL) * sizeof(vec4);
}

Status make_probe_tables(vk::Device& device, const MemoryShape& shape, fixtures::Diagnostics& diagnostics,
                         RigTables& r) {
  static_assert(fixtures::kProbesMax == FL_PROBES_MAX);
  r.has_probes = has_probes(shape.needs, shape.settings);
  std::vector<ProbeRow> rows;
  std::vector<vec4> light(1, vec4(0));
  if (r.has_probes) {
    const std::vector<SolidBox> solids = fixtures::scene_solids(shape.rig);
    for (const ReflectionProbe& probe : scene_probes(shape.rig)) {
      const dvec3 at = *probe.position_m;
      rows.push_back({vec4(probe.min_m, probe.blend_m), vec4(probe.max_m, 0), vec4(at, 0)});
      if (!is_covered(solids, at)) continue;
      diagnostics.add({fixtures::Severity::kWarning,
                       "probe-inside",
                       {shape.rig.name},
                       fmt::format("the reflection probe at {:.3g}, {:.3g}, {:.3g} m is inside a box or scenery", at.x,
                                   at.y, at.z),
                       "it shows no more than that; give it another position_m"});
    }
    light = probe_share_table();
    light.resize(light.size() + rows.size() * FL_PROBE_ALL, vec4(0));
  }
  r.probe_count = static_cast<std::uint32_t>(rows.size());
  FL_ASSIGN(r.probes, vk::Buffer::table(device, rows));
  FL_ASSIGN(r.probe_light, vk::Buffer::table(device, light));
  return {};
}

}  // namespace footlight::render

#include "render/bounce_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "fixtures/bodies/solids.h"
#include "render/pass.h"

namespace footlight::render {
namespace {

using fixtures::SolidBox;
using glm::dvec3;

constexpr double kCoverM = 5e-3;      // a cell is covered if this far in front of it is inside a solid
constexpr double kPatchLeastM = 0.2;  // patches and probes are no denser, since nothing of a stage is finer
constexpr double kProbeLeastM = 0.25;

struct Bounds {
  dvec3 low{std::numeric_limits<double>::max()};
  dvec3 high{std::numeric_limits<double>::lowest()};
  void add(const dvec3& at) {
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  void add(const Bounds& other) {
    add(other.low);
    add(other.high);
  }
  [[nodiscard]] bool empty() const { return low.x > high.x; }
  // Of n . p.
  [[nodiscard]] double most_along(const dvec3& n) const {
    return glm::dot(n, dvec3(n.x > 0 ? high.x : low.x, n.y > 0 ? high.y : low.y, n.z > 0 ? high.z : low.z));
  }
};

Bounds bounds_of(const SolidBox& solid) {
  const dvec3 reach = glm::abs(solid.half_m[0]) + glm::abs(solid.half_m[1]) + glm::abs(solid.half_m[2]);
  Bounds bounds;
  bounds.add(solid.center_m - reach);
  bounds.add(solid.center_m + reach);
  return bounds;
}

// A solid without volume has no inside: it is made 0.1 mm thick.
std::array<dvec3, 3> thick(const SolidBox& solid) {
  std::array<dvec3, 3> half = {solid.half_m[0], solid.half_m[1], solid.half_m[2]};
  constexpr double kThinM = 5e-5;
  for (std::size_t i = 0; i < 3; ++i) {
    if (glm::length(half[i]) >= kThinM) continue;
    const dvec3 across = glm::cross(half[(i + 1) % 3], half[(i + 2) % 3]);
    half[i] = glm::length(across) > 0 ? glm::normalize(across) * kThinM : dvec3(0);
  }
  return half;
}

BounceSolidRow row_of(const SolidBox& solid) {
  BounceSolidRow row{};
  const auto half = thick(solid);
  const double volume = glm::dot(half[0], glm::cross(half[1], half[2]));
  for (std::size_t i = 0; i < 3; ++i) {
    // Nothing is inside a solid whose edges have no volume.
    const dvec3 dual = volume != 0 ? glm::cross(half[(i + 1) % 3], half[(i + 2) % 3]) / volume : dvec3(0);
    row.dual[i] = vec4(dual, volume != 0 ? -glm::dot(dual, solid.center_m) : 2.0);
  }
  std::fill(std::begin(row.first), std::end(row.first), FL_NONE);
  const glm::uvec3 albedo(glm::clamp(solid.albedo, 0.0, 1.0) * 1023.0 + 0.5);
  std::fill(std::begin(row.count), std::end(row.count), FL_BOUNCE_ALBEDO(albedo.x, albedo.y, albedo.z));
  return row;
}

bool holds(const BounceSolidRow& row, const dvec3& at) {
  for (const vec4& dual : row.dual) {
    if (!(std::abs(glm::dot(dvec3(dual), at) + static_cast<double>(dual.w)) < 1)) return false;
  }
  return true;
}

bool is_covered(const BounceScene& scene, const dvec3& at) {
  for (std::size_t n = 0; n < scene.tree.size();) {
    const fixtures::TreeNode& node = scene.tree[n];
    bool inside = true;
    for (int i = 0; i < 3; ++i) {
      inside = inside && at[i] >= static_cast<double>(node.low[i]) && at[i] <= static_cast<double>(node.high[i]);
    }
    const std::uint32_t first = node.leaf >> fixtures::kTreeCountBits;
    const std::uint32_t count = inside ? node.leaf & ((1u << fixtures::kTreeCountBits) - 1) : 0;
    for (std::uint32_t s = first; s < first + count; ++s) {
      if (holds(scene.solids[scene.order[s]], at)) return true;
    }
    n = inside ? n + 1 : node.skip;
  }
  return false;
}

// The tree of triangles, each of which is a solid's bounds.
void add_tree(const std::vector<SolidBox>& solids, BounceScene& scene) {
  std::vector<fixtures::BodyVertex> vertices;
  std::vector<std::uint32_t> indices;
  for (const SolidBox& solid : solids) {
    const Bounds bounds = bounds_of(solid);
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const dvec3& corner : {bounds.low - 1e-4, bounds.high + 1e-4}) {
      fixtures::BodyVertex vertex{};
      for (int i = 0; i < 3; ++i) vertex.position[i] = static_cast<float>(corner[i]);
      vertices.push_back(vertex);
    }
    indices.insert(indices.end(), {first, first + 1, first});
  }
  fixtures::add_tree(vertices, indices, 0, scene.tree);
  for (std::size_t t = 0; t < indices.size(); t += 3) scene.order.push_back(indices[t] / 2);
}

struct Face {
  std::uint32_t solid;
  int number;  // as BounceSolidRow
  double u_m;  // lengths of its edges
  double v_m;
};

std::uint32_t patches_along(double length_m, double side_m) {
  return static_cast<std::uint32_t>(std::clamp(std::lround(length_m / side_m), 1l, 512l));
}
// Its light would be that of a line.
bool is_thin(const Face& face, double side_m) { return std::min(face.u_m, face.v_m) < 0.25 * side_m; }

// Faces that can reflect light to anything.
std::vector<Face> faces_of(const std::vector<SolidBox>& solids, const Bounds& all) {
  std::vector<Face> faces;
  for (std::size_t s = 0; s < solids.size(); ++s) {
    const auto half = thick(solids[s]);
    for (int number = 0; number < 6; ++number) {
      const auto axis = static_cast<std::size_t>(number / 2);
      const dvec3& u = half[(axis + 1) % 3];
      const dvec3& v = half[(axis + 2) % 3];
      const dvec3 across = glm::cross(u, v);
      if (!(glm::length(across) > 0)) continue;
      const dvec3 out = half[axis] * (number % 2 == 0 ? -1.0 : 1.0);
      const dvec3 normal = glm::normalize(glm::dot(across, out) < 0 ? -across : across);
      if (all.most_along(normal) <= glm::dot(normal, solids[s].center_m + out) + 0.01) continue;
      faces.push_back({static_cast<std::uint32_t>(s), number, 2 * glm::length(u), 2 * glm::length(v)});
    }
  }
  return faces;
}

void add_patches(const Face& face, const SolidBox& solid, double side_m, BounceScene& scene) {
  const auto half = thick(solid);
  const auto axis = static_cast<std::size_t>(face.number / 2);
  const std::uint32_t columns = patches_along(face.u_m, side_m), rows = patches_along(face.v_m, side_m);
  const dvec3 half_u = half[(axis + 1) % 3] / static_cast<double>(columns);
  const dvec3 half_v = half[(axis + 2) % 3] / static_cast<double>(rows);
  const dvec3 out = half[axis] * (face.number % 2 == 0 ? -1.0 : 1.0);
  dvec3 normal = glm::normalize(glm::cross(half_u, half_v));
  if (glm::dot(normal, out) < 0) normal = -normal;
  scene.solids[face.solid].first[face.number] = static_cast<std::uint32_t>(scene.patches.size());
  scene.solids[face.solid].count[face.number] = columns | rows << 16;
  const auto along = [](std::uint32_t i, std::uint32_t count) { return 2.0 * i + 1 - count; };
  constexpr std::uint32_t kCells = FL_BOUNCE_CELLS;
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const dvec3 center = solid.center_m + out + along(column, columns) * half_u + along(row, rows) * half_v;
      std::uint32_t exposed = 0, count = 0;
      for (std::uint32_t cell = 0; cell < kCells * kCells; ++cell) {
        const dvec3 at = center + (along(cell % kCells, kCells) * half_u + along(cell / kCells, kCells) * half_v) /
                                      static_cast<double>(kCells);
        if (is_covered(scene, at + kCoverM * normal)) continue;
        exposed |= 1u << cell;
        ++count;
      }
      const double area = 4 * glm::length(glm::cross(half_u, half_v));
      const double longer = 2 * std::max(glm::length(half_u), glm::length(half_v));
      scene.patches.push_back({vec4(center, area * count / (kCells * kCells)), vec4(half_u, longer), vec4(half_v, 0),
                               vec4(normal, 0), static_cast<float>(solid.albedo.x), static_cast<float>(solid.albedo.y),
                               static_cast<float>(solid.albedo.z), exposed});
    }
  }
}

// To the next face with patches along an axis, m.
float clear_m(const std::vector<BounceSolidRow>& solids, const dvec3& from, int axis, double way) {
  double nearest = FL_FAR_M;
  for (const BounceSolidRow& solid : solids) {
    double enter = 0, leave = FL_FAR_M;
    int face = -1;
    for (int i = 0; i < 3; ++i) {
      const double at = glm::dot(dvec3(solid.dual[i]), from) + static_cast<double>(solid.dual[i].w);
      const double slope = static_cast<double>(solid.dual[i][axis]) * way;
      if (std::abs(slope) < 1e-12) {
        if (std::abs(at) >= 1) leave = -1;
        continue;
      }
      const double in = ((slope > 0 ? -1 : 1) - at) / slope, out = ((slope > 0 ? 1 : -1) - at) / slope;
      if (in > enter) {
        enter = in;
        face = 2 * i + (slope > 0 ? 0 : 1);
      }
      leave = std::min(leave, out);
    }
    if (face >= 0 && enter < leave && solid.first[face] != FL_NONE) nearest = std::min(nearest, enter);
  }
  return static_cast<float>(nearest);
}

void add_probes(const Bounds& lit, BounceScene& scene) {
  std::vector<BounceSolidRow> walls;
  std::copy_if(scene.solids.begin(), scene.solids.end(), std::back_inserter(walls), [](const BounceSolidRow& solid) {
    return std::any_of(std::begin(solid.first), std::end(solid.first), [](uint first) { return first != FL_NONE; });
  });
  const dvec3 size = lit.high - lit.low;
  double apart_m = kProbeLeastM;
  const auto count = [&](int axis) { return std::max(1.0, std::ceil(size[axis] / apart_m)); };
  while (count(0) * count(1) * count(2) > FL_BOUNCE_PROBES_MAX) apart_m *= 1.02;
  const dvec3 counts(count(0), count(1), count(2));
  const dvec3 low = 0.5 * (lit.low + lit.high) - 0.5 * (counts - 1.0) * apart_m;
  scene.grid.low = vec4(low, apart_m);
  scene.grid.probes_x = static_cast<std::uint32_t>(counts.x);
  scene.grid.probes_y = static_cast<std::uint32_t>(counts.y);
  scene.grid.probes_z = static_cast<std::uint32_t>(counts.z);
  for (std::uint32_t z = 0; z < scene.grid.probes_z; ++z) {
    for (std::uint32_t y = 0; y < scene.grid.probes_y; ++y) {
      for (std::uint32_t x = 0; x < scene.grid.probes_x; ++x) {
        const dvec3 at = low + dvec3(x, y, z) * apart_m;
        BounceProbeRow probe{};
        probe.usable = is_covered(scene, at) ? 0 : 1;
        for (int axis = 0; axis < 3; ++axis) {
          const auto side = static_cast<std::size_t>(axis) * 2;
          probe.clear_m[side] = clear_m(walls, at, axis, 1);
          probe.clear_m[side + 1] = clear_m(walls, at, axis, -1);
        }
        scene.probes.push_back(probe);
      }
    }
  }
}

}  // namespace

BounceScene bounce_scene(const fixtures::Rig& rig, const Extent& objects, bool with_scenery) {
  BounceScene scene;
  std::vector<SolidBox> solids = fixtures::scene_solids(rig);
  if (!with_scenery) solids.resize(rig.boxes.size());
  // What is lit by probes, and all there is.
  Bounds lit, all;
  for (std::size_t s = rig.boxes.size(); s < solids.size(); ++s) lit.add(bounds_of(solids[s]));
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    lit.add(fixture.position_m - 0.5);
    lit.add(fixture.position_m + 0.5);
  }
  if (with_scenery && objects.low_m.x <= objects.high_m.x) {
    lit.add(dvec3(objects.low_m));
    lit.add(dvec3(objects.high_m));
  }
  if (!lit.empty()) all = lit;
  for (const SolidBox& solid : solids) all.add(bounds_of(solid));
  if (lit.empty() || solids.empty()) return scene;

  for (const SolidBox& solid : solids) scene.solids.push_back(row_of(solid));
  add_tree(solids, scene);
  const std::vector<Face> faces = faces_of(solids, all);
  double side_m = kPatchLeastM;
  const auto patches = [&] {
    std::uint64_t count = 0;
    for (const Face& face : faces) {
      if (is_thin(face, side_m)) continue;
      count += std::uint64_t{patches_along(face.u_m, side_m)} * patches_along(face.v_m, side_m);
    }
    return count;
  };
  while (patches() > FL_BOUNCE_PATCHES_MAX) side_m *= 1.04;
  for (const Face& face : faces) {
    if (!is_thin(face, side_m)) add_patches(face, solids[face.solid], side_m, scene);
  }
  scene.grid.patches = static_cast<std::uint32_t>(scene.patches.size());
  add_probes(lit, scene);
  return scene;
}

std::uint64_t bounce_bytes(std::uint32_t binding, const MemoryShape& shape) {
  constexpr std::uint64_t kPatches = FL_BOUNCE_PATCHES_MAX, kProbes = FL_BOUNCE_PROBES_MAX;
  if (!has_bounce(shape.needs, shape.settings)) return 0;
  const std::uint64_t boxes = shape.rig.boxes.size();
  // Builds the scenery.
  const auto solids = [&]() -> std::uint64_t {
    return has_bodies(shape.needs, shape.settings) ? fixtures::scene_solids(shape.rig).size() : boxes;
  };
  switch (binding) {
    case FL_BINDING_BOUNCE_SOLIDS: return (boxes + solids()) * sizeof(BounceSolidRow);  // boxes twice
    case FL_BINDING_BOUNCE_TREE: return 2 * solids() * sizeof(TreeRow);
    case FL_BINDING_BOUNCE_PATCHES: return kPatches * sizeof(BouncePatchRow);
    case FL_BINDING_BOUNCE_GRID: return sizeof(BounceGrid) + kProbes * sizeof(BounceProbeRow);
    case FL_BINDING_BOUNCE_FORMS: return kPatches * (kPatches + 6 * kProbes) * sizeof(float);
    case FL_BINDING_BOUNCE_FLUX: return kPatches * 6 * sizeof(std::uint32_t);
    case FL_BINDING_BOUNCE_LIGHT: return (FL_BOUNCE_LISTS * kPatches + 6 * kProbes) * sizeof(vec4);
    default: return 0;
  }
}

Status make_bounce_tables(vk::Device& device, const MemoryShape& shape, RigTables& r) {
  r.has_bounce = has_bounce(shape.needs, shape.settings);
  BounceScene scene;
  if (r.has_bounce) scene = bounce_scene(shape.rig, r.objects, has_bodies(shape.needs, shape.settings));
  r.bounce_patches = scene.grid.patches;
  r.bounce_probes = static_cast<std::uint32_t>(scene.probes.size());
  std::vector<std::byte> grid(sizeof(BounceGrid) + scene.probes.size() * sizeof(BounceProbeRow));
  std::copy_n(reinterpret_cast<const std::byte*>(&scene.grid), sizeof(BounceGrid), grid.data());
  const auto probes = std::as_bytes(std::span(scene.probes));
  std::copy(probes.begin(), probes.end(), grid.begin() + sizeof(BounceGrid));
  static_assert(fixtures::kTreeCountBits == FL_TREE_COUNT_BITS && fixtures::kNoTree == FL_NONE);
  std::vector<TreeRow> tree;
  for (const fixtures::TreeNode& node : scene.tree) {
    tree.push_back(
        {node.low[0], node.low[1], node.low[2], node.skip, node.high[0], node.high[1], node.high[2], node.leaf});
  }
  if (r.has_bounce && tree.empty()) tree.push_back({});  // where nothing is solid: its end is its first node
  // The stage boxes as the picture numbers them, then all solids as the leaves of the tree do.
  std::vector<BounceSolidRow> solids;
  if (!scene.solids.empty()) solids.assign(scene.solids.begin(), scene.solids.begin() + r.box_count);
  for (const std::uint32_t own : scene.order) solids.push_back(scene.solids[own]);
  const std::uint64_t patches = scene.patches.size(), probe_count = scene.probes.size();
  FL_ASSIGN(r.bounce_solids, vk::Buffer::table(device, solids));
  FL_ASSIGN(r.bounce_tree, vk::Buffer::table(device, tree));
  FL_ASSIGN(r.bounce_patch_rows, vk::Buffer::table(device, scene.patches));
  FL_ASSIGN(r.bounce_grid, vk::Buffer::filled(device, grid, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  const auto room = [&](std::uint64_t bytes) {
    return vk::Buffer::device_local(device, std::max<std::uint64_t>(bytes, 16), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  };
  FL_ASSIGN(r.bounce_forms,
            room(patches * (bounce_row(r.bounce_patches) + bounce_row(6 * r.bounce_probes)) * sizeof(float)));
  FL_ASSIGN(r.bounce_flux, room(patches * 6 * sizeof(std::uint32_t)));
  FL_ASSIGN(r.bounce_light, room((FL_BOUNCE_LISTS * patches + 6 * probe_count) * sizeof(vec4)));
  return {};
}

}  // namespace footlight::render

#include "render/reference/judge_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "fixtures/bodies/body.h"
#include "fixtures/bodies/solids.h"

namespace footlight::render {
namespace {

using glm::dvec3;

constexpr double kLeastM = 1e-6;  // a ray from a triangle does not meet it again

bool meets(const fixtures::TreeNode& node, const Ray& ray, double end_m) {
  double enter = 0, leave = end_m;
  for (int axis = 0; axis < 3; ++axis) {
    const double from = ray.origin_m[axis], way = ray.direction[axis];
    const double low = static_cast<double>(node.low[axis]), high = static_cast<double>(node.high[axis]);
    if (way == 0) {
      if (from < low || from > high) return false;
      continue;
    }
    const double a = (low - from) / way, b = (high - from) / way;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

// Where a ray meets a triangle, as its length and the shares of the second and the third corner (Moeller and Trumbore
// 1997, "Fast, Minimum Storage Ray/Triangle Intersection").
std::optional<dvec3> met(const Ray& ray, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 u = b - a, v = c - a, p = glm::cross(ray.direction, v);
  const double det = glm::dot(u, p);
  if (det == 0) return {};
  const dvec3 from = ray.origin_m - a, q = glm::cross(from, u);
  const double x = glm::dot(from, p) / det, y = glm::dot(ray.direction, q) / det;
  if (!(x >= 0 && y >= 0 && x + y <= 1)) return {};
  return dvec3(glm::dot(v, q) / det, x, y);
}

}  // namespace

JudgeMesh::JudgeMesh(fixtures::Mesh mesh) : mesh_(std::move(mesh)) {
  std::map<const fixtures::RgbImage*, glm::vec3> means;  // materials may share an image
  for (fixtures::MeshMaterial& material : mesh_.materials) {
    if (!material.texture) continue;
    const auto [mean, fresh] = means.try_emplace(material.texture->image.get());
    if (fresh) mean->second = mean_reflectance(*mean->first);
    material.albedo *= mean->second;
  }
  std::vector<fixtures::BodyVertex> corners;
  for (const fixtures::MeshVertex& vertex : mesh_.vertices) {
    const glm::vec3& p = vertex.position_m;
    corners.push_back({{p.x, p.y, p.z}, {0, 0, 1}, 0});
  }
  add_tree(corners, mesh_.indices, 0, nodes_);
}

std::optional<SurfaceHit> JudgeMesh::hit(const Ray& ray) const {
  double nearest = std::numeric_limits<double>::infinity();
  std::size_t triangle = 0;
  dvec3 at(0);
  for (std::size_t n = 0; n < nodes_.size();) {
    const fixtures::TreeNode& node = nodes_[n];
    if (!meets(node, ray, nearest)) {
      n = node.skip;
      continue;
    }
    ++n;
    const std::size_t first = node.leaf >> fixtures::kTreeCountBits;
    for (std::size_t t = first; t < first + (node.leaf & ((1u << fixtures::kTreeCountBits) - 1)); ++t) {
      const auto corner = [&](std::size_t c) { return dvec3(mesh_.vertices[mesh_.indices[3 * t + c]].position_m); };
      const std::optional<dvec3> place = met(ray, corner(0), corner(1), corner(2));
      if (!place || !(place->x > kLeastM) || !(place->x < nearest)) continue;
      nearest = place->x;
      triangle = t;
      at = *place;
    }
  }
  if (!(nearest < std::numeric_limits<double>::infinity())) return {};
  const auto vertex = [&](std::size_t c) { return mesh_.vertices[mesh_.indices[3 * triangle + c]]; };
  const dvec3 a(vertex(0).position_m), b(vertex(1).position_m), c(vertex(2).position_m);
  dvec3 flat = glm::normalize(glm::cross(b - a, c - a));
  if (glm::dot(flat, ray.direction) > 0) flat = -flat;
  dvec3 normal = (1 - at.y - at.z) * dvec3(vertex(0).normal) + at.y * dvec3(vertex(1).normal) +
                 at.z * dvec3(vertex(2).normal);
  if (glm::dot(normal, flat) < 0) normal = -normal;
  if (!(glm::dot(normal, ray.direction) < 0)) normal = flat;
  const fixtures::MeshMaterial& material = mesh_.materials[vertex(0).material];
  return SurfaceHit{nearest, glm::normalize(normal), dvec3(material.albedo),
                    material.sheen && !material.sheen->matt() ? material.sheen : std::nullopt, true};
}

void add_meshes(JudgeScene& scene, const fixtures::Rig& rig) {
  if (rig.scenery.empty() && rig.objects.empty()) return;
  fixtures::Diagnostics reported_by_the_frame;
  std::vector<fixtures::SolidBox> solids;
  const auto mesh = std::make_shared<const JudgeMesh>(scene_mesh(rig, reported_by_the_frame, &solids));
  scene.others = [mesh](const Ray& ray) { return mesh->hit(ray); };
  const std::vector<fixtures::SolidBox> scenery = fixtures::scene_solids(rig);
  solids.insert(solids.end(), scenery.begin() + static_cast<std::ptrdiff_t>(rig.boxes.size()), scenery.end());
  for (const fixtures::SolidBox& solid : solids) {
    scene.solids.push_back({solid.center_m, {solid.half_m[0], solid.half_m[1], solid.half_m[2]}, solid.slack_m});
  }
}

}  // namespace footlight::render

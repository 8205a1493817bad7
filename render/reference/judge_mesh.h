// Scenery and objects for the judge: rays and triangles in double, by a tree of their boxes.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fixtures/bodies/mesh.h"
#include "fixtures/bodies/tree.h"
#include "render/reference/judge.h"

namespace footlight::render {

class JudgeMesh {
 public:
  // mesh: in stage space, with at least one material where there are triangles. A texture counts as its
  // mean colour.
  explicit JudgeMesh(fixtures::Mesh mesh);

  // The nearest triangle, from either side. The normal is between those of its corners and faces the ray.
  [[nodiscard]] std::optional<SurfaceHit> hit(const Ray& ray) const;

 private:
  fixtures::Mesh mesh_;
  std::vector<fixtures::TreeNode> nodes_;  // empty: there are no triangles
};

// Adds the scenery and the objects of a rig to what a judged scene shows, and what stands for them where light is
// blocked. Files that cannot be read are left out, as in the picture.
void add_meshes(JudgeScene& scene, const fixtures::Rig& rig);

}  // namespace footlight::render

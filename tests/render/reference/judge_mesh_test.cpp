// What the judge meets beside boxes, and displays with fewer pixels, without a GPU.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/bodies/body.h"
#include "render/reference/display_judge.h"
#include "render/reference/judge_mesh.h"
#include "sim/core/random.h"

namespace footlight::render {
namespace {

using glm::dvec3;

dvec3 any_way(SeededNumbers& numbers) {
  return glm::normalize(dvec3(numbers.between(-1, 1), numbers.between(-1, 1), numbers.between(-1, 1)));
}

// The nearest triangle of all, each cut by itself as a plane with three edges.
double nearest_m(const fixtures::Mesh& mesh, const Ray& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    dvec3 corner[3];
    for (std::size_t c = 0; c < 3; ++c) corner[c] = dvec3(mesh.vertices[mesh.indices[3 * t + c]].position_m);
    const dvec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double along = glm::dot(normal, corner[0] - ray.origin_m) / glm::dot(normal, ray.direction);
    if (!(along > 1e-6) || along >= nearest) continue;
    const dvec3 place = ray.origin_m + along * ray.direction;
    bool within = true;
    for (int c = 0; c < 3; ++c) {
      within = within && glm::dot(normal, glm::cross(corner[(c + 1) % 3] - corner[c], place - corner[c])) >= 0;
    }
    if (within) nearest = along;
  }
  return nearest;
}

TEST_CASE("the judge meets the triangles of scenery that are nearest, with their normal towards it and their sheen") {
  fixtures::Rig rig;
  for (const auto kind : {fixtures::SceneryKind::kPerson, fixtures::SceneryKind::kDanceFloor}) {
    rig.scenery.push_back(fixtures::default_scenery(kind));
    rig.scenery.back().sheen = fixtures::Sheen{0.35, 0};
  }
  fixtures::Diagnostics none;
  const fixtures::Mesh all = fixtures::scene_mesh(rig, none);
  JudgeScene scene;
  add_meshes(scene, rig);
  REQUIRE(scene.others);
  CHECK(scene.solids.size() > 17);  // a person has so many
  SeededNumbers numbers(5);
  int met = 0;
  for (int i = 0; i < 400; ++i) {
    Ray ray{dvec3(0, 0, 0.9) + 3.0 * any_way(numbers), {}};
    ray.direction = glm::normalize(dvec3(0, 0, 0.9) + 0.6 * any_way(numbers) - ray.origin_m);
    const double expected = nearest_m(all, ray);
    const auto hit = judge_hit(scene, ray);
    REQUIRE(hit.has_value() == std::isfinite(expected));
    if (!hit) continue;
    ++met;
    CHECK(hit->t_m == doctest::Approx(expected).epsilon(1e-9));
    CHECK(glm::dot(hit->normal, ray.direction) < 0);
    CHECK(glm::length(hit->normal) == doctest::Approx(1));
    CHECK(hit->sheen.has_value());
    CHECK(hit->shaped);
  }
  CHECK(met > 100);
  // A box before it is nearer.
  scene.boxes.push_back({"box", {-1, -2.2, 0}, {1, -2, 2}});
  const auto hit = judge_hit(scene, {{0, -4, 0.9}, {0, 1, 0}});
  REQUIRE(hit);
  CHECK(hit->t_m == doctest::Approx(1.8));
  scene.matt = true;
  scene.boxes.clear();
  CHECK(!judge_hit(scene, {{0, -4, 0.9}, {0, 1, 0}})->sheen);
}

TEST_CASE("the judge meets a textured triangle with the mean colour of its texture times that of its material") {
  const auto image = std::make_shared<const fixtures::RgbImage>(fixtures::RgbImage{2, 1, {255, 0, 0, 0, 0, 255}});
  fixtures::Mesh mesh;
  mesh.materials.push_back({"print", glm::vec3(1, 1, 0.5F),
                            std::make_shared<const fixtures::MeshTexture>(fixtures::MeshTexture{image})});
  mesh.materials.push_back({"plain", glm::vec3(0.25F)});
  for (const std::uint32_t material : {0u, 1u}) {
    const float x = 4 * static_cast<float>(material);
    for (const glm::vec3& at : {glm::vec3(x, 0, 0), glm::vec3(x + 2, 0, 0), glm::vec3(x, 0, 2)}) {
      mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back({at, glm::vec3(0, -1, 0), material});
    }
  }
  const JudgeMesh judge(mesh);
  const auto color_at = [&](double x) {
    const auto hit = judge.hit({{x, -1, 0.5}, {0, 1, 0}});
    REQUIRE(hit);
    return hit->albedo;
  };
  CHECK(color_at(0.5) == dvec3(0.5, 0, 0.25));
  CHECK(color_at(4.5) == dvec3(0.25));
}

TEST_CASE("a display with joined pixels lights a place two metres away as its own pixels do, within 2 percent") {
  JudgeScene scene;
  JudgeDisplay display;
  display.columns = 23;
  display.rows = 17;
  display.pixels_cd_m2.clear();
  SeededNumbers numbers(2);
  for (int i = 0; i < display.columns * display.rows; ++i) {
    display.pixels_cd_m2.emplace_back(numbers.uniform(), 0.02 * (i % display.columns), 1);
  }
  scene.displays.push_back(display);
  const dvec3 place(0.3, -2, -0.4), normal = glm::normalize(dvec3(0.1, 1, 0.3));
  const dvec3 whole = judge_display_lux(scene, place, normal);
  join_display_lights(scene, 20);
  REQUIRE(scene.display_lights.size() == 1);
  CHECK(scene.display_lights[0].pixels_cd_m2.size() <= 20);
  CHECK(scene.display_lights[0].pixels_cd_m2.size() >= 12);
  const dvec3 joined = judge_display_lux(scene, place, normal);
  for (int c = 0; c < 3; ++c) CHECK(joined[c] == doctest::Approx(whole[c]).epsilon(0.02));
}

}  // namespace
}  // namespace footlight::render

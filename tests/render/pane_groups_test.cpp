// Groups of panes, and the lines along which their glass is summed: no GPU.
#include "render/pane_groups.h"

#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <memory>
#include <utility>
#include <vector>

#include "render/beam.h"
#include "tests/render/scenes.h"

namespace footlight::render {
namespace {

using testing::Random;

fixtures::Pane pane_at(double x, double y, double z) {
  fixtures::Pane pane;
  pane.position_m = {x, y, z};
  pane.width_m = 1;
  pane.height_m = 2;
  return pane;
}
fixtures::Rig rig_of(std::vector<fixtures::Pane> panes) {
  fixtures::Rig rig;
  rig.sun.direction = glm::normalize(glm::dvec3(0.3, -1, -0.7));
  rig.panes = std::move(panes);
  return rig;
}
std::shared_ptr<const fixtures::PaneImage> image_of_size(int width, int height) {
  const auto texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{width, height, std::vector<glm::vec3>(texels)});
}

TEST_CASE("the line from any eye to any place of the glass is in the fan of its side") {
  Random random(5);
  for (int i = 0; i < 20'000; ++i) {
    const double scale = std::pow(10.0, random.between(-3, 4));
    const glm::dvec2 eye(random.between(-scale, scale), random.between(-scale, scale));
    const glm::dvec2 place(random.between(-1, 1), random.between(-1, 1));
    const glm::dvec2 way = place - eye;
    const std::uint32_t side = f64::shaft_fan_side(way);
    const f64::ShaftFan fan = f64::shaft_fan(side, eye);
    const double p = std::max(std::abs(way.x), std::abs(way.y));
    const double q = (side >= 2 ? way.x : way.y) / p;
    CAPTURE(eye.x);
    CAPTURE(eye.y);
    CAPTURE(side);
    CHECK(q >= fan.q_low - 1e-9);
    CHECK(q <= fan.q_high + 1e-9);
    CHECK(fan.q_low >= -1);
    CHECK(fan.q_high <= 1);
    CHECK(p >= fan.p_low - 1e-9 * scale);
    CHECK(p <= fan.p_high + 1e-9 * scale);
    CHECK(glm::length(f64::shaft_fan_place(side, eye, q, p) - place) < 1e-9 * std::max(scale, 1.0));
  }
}

TEST_CASE("a fan has no lines where the glass lies on another side of the eye") {
  const glm::dvec2 eye(-5, 0.2);  // all of the glass is to the right
  for (std::uint32_t side = 0; side < 4; ++side) {
    const f64::ShaftFan fan = f64::shaft_fan(side, eye);
    CHECK((fan.q_high > fan.q_low) == (side == 0));
  }
}

TEST_CASE("the line in place of an exponential keeps the light of even glass and its first moment") {
  for (const double loss : {-0.5, -0.1, 0.0, 1e-6, 0.2, 0.5}) {
    double mean = 0, moment = 0;
    const int steps = 20'000;
    for (int i = 0; i < steps; ++i) {
      const double y = (i + 0.5) / steps - 0.5;
      mean += std::exp(-loss * y) / steps;
      moment += y * std::exp(-loss * y) / steps;
    }
    CAPTURE(loss);
    const glm::dvec2 line = f64::shaft_line(loss);
    CHECK(line.x == doctest::Approx(mean).epsilon(1e-7));
    CHECK(line.y / 12 == doctest::Approx(moment).epsilon(1e-5));
  }
}

TEST_CASE("panes of a wall are one group, and panes in another plane or far away are not in it") {
  std::vector<fixtures::Pane> panes;
  for (int i = 0; i < 12; ++i) panes.push_back(pane_at(1.5 * i, 5, 3));
  CHECK(pane_groups(rig_of(panes)).rows.size() == 1);
  panes.push_back(pane_at(3, 4.9, 3));
  panes.push_back(pane_at(400, 5, 3));
  panes.push_back(pane_at(3, 5, 6));
  panes.back().rotation_deg = {0, 0, 10};
  const PaneGroups groups = pane_groups(rig_of(panes));
  REQUIRE(groups.rows.size() == 4);
  CHECK(groups.rows[0].pane_count == 12);
  CHECK(groups.panes.size() == panes.size());
}

TEST_CASE("a wall that is turned and typed in millimetres is one group, and light meets each pane where it really is") {
  std::vector<fixtures::Pane> panes;
  for (int i = 0; i < 16; ++i) {
    const double away = 1.5 * i, angle = 0.5235987755982988;
    const auto typed = [](double m) { return std::round(1000 * m) / 1000; };
    panes.push_back(pane_at(typed(away * std::cos(angle)), typed(5 + away * std::sin(angle)), 3));
    panes.back().rotation_deg = {0, 0, 30};
  }
  const fixtures::Rig rig = rig_of(panes);
  const PaneGroups groups = pane_groups(rig);
  REQUIRE(groups.rows.size() == 1);
  const PaneGroupRow& row = groups.rows[0];
  Random random(9);
  for (std::size_t i = 0; i < panes.size(); ++i) {
    const glm::dmat4 pose = fixtures::pose_of(rig.panes[i]);
    const glm::dvec3 right = glm::dvec3(pose[0]) * 0.5, up = glm::dvec3(pose[2]);
    const glm::dvec3 normal = glm::cross(right, up);
    for (int k = 0; k < 20; ++k) {
      const double u = random.between(-1, 1), v = random.between(-1, 1);
      // A place behind the pane, on the light through (u, v) of it.
      const glm::dvec3 place = rig.panes[i].position_m + u * right + v * up + 3.0 * rig.sun.direction;
      const glm::dvec3 from = place - glm::dvec3(row.center);
      const double x = glm::dot(glm::dvec3(row.across), from), y = glm::dot(glm::dvec3(row.upward), from);
      const GroupPaneRow& pane = groups.panes[i];
      const auto of = [&](const glm::vec4& to) {
        return static_cast<double>(to.x) * x + static_cast<double>(to.y) * y + static_cast<double>(to.z);
      };
      CHECK(of(pane.to_u) == doctest::Approx(u).epsilon(1e-4).scale(1));
      CHECK(of(pane.to_v) == doctest::Approx(v).epsilon(1e-4).scale(1));
      CHECK(glm::length(normal) > 0);
    }
  }
}

TEST_CASE("plain panes, dark ones and a sun in their plane need no sums, nor does a rig without haze") {
  std::vector<fixtures::Pane> panes = {pane_at(0, 5, 3)};
  CHECK(pane_groups(rig_of(panes)).entries == 0);  // plain
  panes[0].image = std::make_shared<fixtures::PaneImage>(
      fixtures::PaneImage{8, 8, std::vector<glm::vec3>(64, glm::vec3(0.5))});
  fixtures::Rig rig = rig_of(panes);
  CHECK(pane_groups(rig).entries > 10'000);
  CHECK(pane_groups(rig, false).entries == 0);
  CHECK(pane_group_bytes(FL_BINDING_PANE_LINES, rig, false) < 100);
  rig.panes[0].color = {0, 0, 0};
  CHECK(pane_groups(rig).entries == 0);
  rig.panes[0].color = {1, 1, 1};
  rig.sun.direction = {1, 0, 0};  // along the glass
  CHECK(pane_groups(rig).entries == 0);
}

TEST_CASE("the grid of a group lists each pane where it is") {
  std::vector<fixtures::Pane> panes;
  for (int i = 0; i < 30; ++i) {
    panes.push_back(pane_at(1.2 * (i % 10), 5, 2.5 * (i / 10)));
    panes.back().rotation_deg = {0, 7.0 * i, 0};  // in the plane
  }
  const PaneGroups groups = pane_groups(rig_of(panes));
  REQUIRE(groups.rows.size() == 1);
  const PaneGroupRow& row = groups.rows[0];
  Random random(3);
  int found = 0;
  for (int i = 0; i < 3000; ++i) {
    const glm::vec2 at(random.between(-1, 1), random.between(-1, 1));
    const auto x = static_cast<std::uint32_t>((at.x * 0.5f + 0.5f) * static_cast<float>(row.grid_x));
    const auto y = static_cast<std::uint32_t>((at.y * 0.5f + 0.5f) * static_cast<float>(row.grid_y));
    const std::uint32_t word =
        groups.grids[row.grid_first + std::min(y, row.grid_y - 1) * row.grid_x + std::min(x, row.grid_x - 1)];
    const std::uint32_t first = word >> FL_PANE_GRID_COUNT_BITS;
    const std::uint32_t count = word & ((1u << FL_PANE_GRID_COUNT_BITS) - 1);
    for (std::uint32_t k = 0; k < groups.panes.size(); ++k) {
      const GroupPaneRow& pane = groups.panes[k];
      const float u = pane.to_u.x * at.x + pane.to_u.y * at.y + pane.to_u.z;
      const float v = pane.to_v.x * at.x + pane.to_v.y * at.y + pane.to_v.z;
      if (std::abs(u) > 1 || std::abs(v) > 1) continue;
      ++found;
      const auto begin = groups.grids.begin() + first;
      CHECK(std::find(begin, begin + count, k) != begin + count);
    }
  }
  CHECK(found > 1000);
}

TEST_CASE("tables of panes have room for the finest images in the most planes") {
  fixtures::Pane pane = pane_at(0, 5, 3);
  pane.image = image_of_size(600, 80);
  std::vector<fixtures::Pane> panes;
  for (int i = 0; i < fixtures::kPanesMax; ++i) {
    panes.push_back(pane);
    panes.back().position_m.y += i;
  }
  const PaneGroups groups = pane_groups(rig_of(panes));
  CHECK(groups.rows.size() == panes.size());
  CHECK(groups.entries * kPaneLineBytes <= kPaneLineBytesMax);
  CHECK(pane_groups(rig_of({pane})).rows[0].lines > groups.rows[0].lines);
}

}  // namespace
}  // namespace footlight::render

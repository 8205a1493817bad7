// Mirror balls: the beams of their mirrors against the judge, against traced rays and against the light on walls, and
// what must hold of them anywhere.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "fixtures/mirrors/mirror_ball.h"
#include "fixtures/simulate/walker.h"
#include "render/beam.h"
#include "render/plan.h"
#include "render/reference/judge.h"
#include "render/reference/mirror_judge.h"
#include "render/reference/norms.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr double kRoomM = 4;  // half the width and depth of the room; its height is 5 m
constexpr std::size_t kLamps = 2;

// Fixtures 0 and 1 are lamps, 2 is a ball in the middle of a closed room.
Scene ball_scene(const std::string& ball = "diameter_m = 0.5, mirror_m = 0.1", double beam_deg = 20,
                 const std::string& position = "[0, 0, 3.45]") {
  const auto box = [](const char* name, const char* low, const char* high) {
    return std::string("[[box]]\nname = \"") + name + "\"\nmin = " + low + "\nmax = " + high +
           "\nalbedo = [0.4, 0.5, 0.6]\n";
  };
  Scene scene;
  scene.rig = must(fixtures::parse_rig(
      "[rig]\nname = \"Ball\"\nambient_lx = 0\n[haze]\nreach_m = 60\nscattering_per_m = 0.02\n"
      "[[fixture]]\nname = \"Pin {}\"\nuniverse = 1\naddress = 1\ncount = 2\n"
      "type = \"generic/par\"\nposition = [3, -1, 4.2]\nposition_step = [-5.5, -1.7, 0.1]\naim = [0, 0, 3]\n"
      "[[fixture]]\nname = \"Ball\"\ntype = \"generic/mirror-ball\"\nuniverse = 1\naddress = 101\nposition = " +
          position + "\nmirror_ball = { " + ball + " }\n" + box("Floor", "[-5, -5, -1]", "[5, 5, 0]") +
          box("Ceiling", "[-5, -5, 5]", "[5, 5, 6]") + box("Left", "[-5, -5, 0]", "[-4, 5, 5]") +
          box("Right", "[4, -5, 0]", "[5, 5, 5]") + box("Front", "[-5, -5, 0]", "[5, -4, 5]") +
          box("Back", "[-5, 4, 0]", "[5, 5, 5]") +
          "[[camera]]\nname = \"main\"\nposition = [0.5, -3.6, 1.7]\ntarget = [0, 1, 2.6]\nfov_deg = 80\n",
      "ball.toml"));
  for (fixtures::FixtureType& type : scene.rig.types) {
    for (fixtures::Beam& beam : type.beams) beam.beam_angle_deg = beam.field_angle_deg = beam_deg;
  }
  scene.camera = scene.rig.cameras.front();
  scene.compile();
  for (std::size_t lamp = 0; lamp < kLamps; ++lamp) {
    scene.set(lamp, "Dimmer", 1);
    scene.set(lamp, "ColorAdd_G", lamp == 0 ? 0.5 : 1);
    scene.set(lamp, "ColorAdd_B", lamp == 0 ? 0.25 : 1);
  }
  scene.slots(2)[100] = 0;
  scene.slots(2)[101] = 90;
  return scene;
}

JudgeScene judged_scene(const Scene& scene, std::int64_t dt_ns = 0) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, dt_ns);
  return judge_scene(scene.rig, walker);
}

// In stage space.
glm::dvec3 lens_of(const BeamRow& row, const View& view) {
  return view.position_m - (static_cast<double>(row.eye.x) * glm::dvec3(row.x_axis) +
                            static_cast<double>(row.eye.y) * glm::dvec3(row.y_axis) +
                            static_cast<double>(row.eye.z) * glm::dvec3(row.axis));
}

// How far the rows of the mirrors of a scene are from the judge's beams.
struct RowErrors {
  std::size_t rows = 0;
  double place_m = 0;
  double turn = 0;
  double size = 0;   // of radius and spread, relative
  double light = 0;  // relative to the brightest row
};
RowErrors row_errors(vk::Device& device, const Scene& scene) {
  const auto frame = make_frame(device, scene, judged_settings(8, 8));
  (void)draw(*frame, scene);
  const auto rows = must(frame->read_beams());
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const JudgeScene judge = judge_scene(scene.rig, walker, gobos_of_judge(scene));
  REQUIRE(rows.size() == judge.beams.size());
  REQUIRE(rows.size() > kLamps + 20);
  CHECK(rows.size() <= scene.compiled.beams_max);
  const View view = view_of(scene.camera);
  RowErrors errors;
  double brightest = 0;
  for (std::size_t i = kLamps; i < rows.size(); ++i) {
    const BeamRow& row = rows[i];
    const JudgeBeam& beam = judge.beams[i];
    REQUIRE(row.head == 2);
    CHECK(static_cast<double>(row.eye.w) == beam.profile_power);
    errors.place_m = std::max(errors.place_m, glm::distance(lens_of(row, view), beam.lens_m));
    errors.turn = std::max(errors.turn, glm::distance(glm::dvec3(row.axis), beam.axis));
    errors.size = std::max({errors.size, std::abs(static_cast<double>(row.x_axis.w) / beam.lens_radius_m - 1),
                            std::abs(static_cast<double>(row.y_axis.w) / beam.spread - 1)});
    errors.light = std::max(errors.light, glm::distance(glm::dvec3(row.j0), beam.strength_lm));
    brightest = std::max(brightest, glm::length(beam.strength_lm));
  }
  errors.light /= brightest;
  errors.rows = rows.size() - kLamps;
  std::fprintf(stderr, "%zu rows of mirrors: place %.2g m, direction %.2g, size %.2g, light %.2g\n", errors.rows,
               errors.place_m, errors.turn, errors.size, errors.light);
  CHECK(errors.place_m < 3e-6);
  CHECK(errors.turn < 1e-6);
  CHECK(errors.size < 1e-5);
  return errors;
}

TEST_CASE("the rows of mirrors are those of the judge, behind those of the lamps, in order") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const char* ball : {"diameter_m = 0.5, mirror_m = 0.1", "diameter_m = 0.4, mirror_m = 0.02"}) {
    CHECK(row_errors(vulkan.device(), ball_scene(ball)).light < 2e-5);
  }
}

TEST_CASE("mirrors in the light of a rectangular beam have the judge's light") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene wide = ball_scene();
  for (fixtures::FixtureType& type : wide.rig.types) {
    for (fixtures::Beam& beam : type.beams) {
      beam.type = fixtures::BeamType::kRectangle;
      beam.rectangle_ratio = 2;
    }
  }
  const auto levels = wide.levels;
  wide.compile();
  wide.levels = levels;
  REQUIRE(wide.compiled.needs.rectangle);
  CHECK(row_errors(vulkan.device(), wide).light < 2e-5);
}

TEST_CASE("a picture of a ball's spots in haze and on walls agrees with the judge") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = ball_scene();
  const RadianceImage picture = draw_new(vulkan.device(), scene, judged_settings(48, 27));
  const JudgedImage judged = judge_image(judged_scene(scene), view_of(scene.camera), 48, 27, {.stated_error = false});
  const PictureNorms norms = picture_norms(picture.rgb, judged.rgb);
  std::fprintf(stderr, "spots of a ball: relL2 %.3g, p99 %.3g, max %.3g\n", norms.rel_l2, norms.p99, norms.max);
  CHECK(norms.nonfinite == 0);
  CHECK(norms.rel_l2 < 3e-3);
}

// Where a ray ends on the walls, floor and ceiling of the room.
glm::dvec3 end_in_room(const glm::dvec3& from_m, const glm::dvec3& way) {
  double t_m = 1e9;
  const glm::dvec3 low(-kRoomM, -kRoomM, 0), high(kRoomM, kRoomM, 5);
  for (int axis = 0; axis < 3; ++axis) {
    if (way[axis] > 0) t_m = std::min(t_m, (high[axis] - from_m[axis]) / way[axis]);
    if (way[axis] < 0) t_m = std::min(t_m, (low[axis] - from_m[axis]) / way[axis]);
  }
  return from_m + t_m * way;
}

TEST_CASE("the middle of each spot is within 1 mm of where the mirrored lamp sends its light through the mirror") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = ball_scene("diameter_m = 0.4, mirror_m = 0.02");
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  (void)draw(*frame, scene);
  const auto rows = must(frame->read_beams());
  REQUIRE(rows.size() > kLamps);
  const JudgeScene judge = judged_scene(scene);
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const auto& head = scene.compiled.heads[2];
  const glm::dvec3 center = walker.beam_pose(head, scene.compiled.types[head.type], walker.states[2]).lens_m;
  const View view = view_of(scene.camera);
  double farthest_m = 0;
  for (std::size_t i = kLamps; i < rows.size(); ++i) {
    const glm::dvec3 place = lens_of(rows[i], view);
    const glm::dvec3 normal = glm::normalize(place - center);
    double nearest_m = 1e9;
    for (std::size_t l = 0; l < kLamps; ++l) {
      const JudgeBeam& lamp = judge.beams[l];
      const glm::dvec3 apex = lamp.lens_m - lamp.axis * (lamp.lens_radius_m / lamp.spread);
      const glm::dvec3 image = apex - 2 * glm::dot(apex - place, normal) * normal;
      nearest_m = std::min(nearest_m, glm::distance(end_in_room(place, glm::normalize(place - image)),
                                                    end_in_room(place, glm::normalize(glm::dvec3(rows[i].axis)))));
    }
    farthest_m = std::max(farthest_m, nearest_m);
  }
  std::fprintf(stderr, "%zu spots: at most %.2g m from the traced ray\n", rows.size() - kLamps, farthest_m);
  CHECK(farthest_m < 1e-3);
}

// Lumens that a beam brings to the walls of the room, by points in the plane of each wall around the spot.
double lumens_on_walls(const JudgeBeam& beam, const fixtures::Haze& haze) {
  constexpr int kPoints = 160;
  double sum = 0;
  const glm::dvec3 low(-kRoomM, -kRoomM, 0), high(kRoomM, kRoomM, 5);
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) {
      glm::dvec3 normal(0);
      normal[axis] = upper ? -1 : 1;
      const double slope = glm::dot(beam.axis, normal);
      if (!(slope < -0.02)) continue;
      const double plane = upper ? high[axis] : low[axis];
      const double t_m = (plane - beam.lens_m[axis]) / beam.axis[axis];
      const glm::dvec3 middle = beam.lens_m + t_m * beam.axis;
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const double reach_m = 1.6 * (beam.lens_radius_m + beam.spread * t_m) / -slope;
      const double from_u = std::max(middle[u] - reach_m, low[u]), to_u = std::min(middle[u] + reach_m, high[u]);
      const double from_v = std::max(middle[v] - reach_m, low[v]), to_v = std::min(middle[v] + reach_m, high[v]);
      if (from_u >= to_u || from_v >= to_v) continue;
      const double cell_m2 = (to_u - from_u) * (to_v - from_v) / (kPoints * kPoints);
      for (int i = 0; i < kPoints; ++i) {
        for (int j = 0; j < kPoints; ++j) {
          glm::dvec3 point = middle;
          point[u] = from_u + (i + 0.5) / kPoints * (to_u - from_u);
          point[v] = from_v + (j + 0.5) / kPoints * (to_v - from_v);
          sum += judge_illuminance(beam, haze, point, normal, {}) * cell_m2 * beam.strength_lm.x;
        }
      }
    }
  }
  return sum;
}

// Lumens that the squares of all mirrors get from a lamp, by points on each.
double lumens_on_mirrors(const JudgeBeam& lamp, const fixtures::MirrorBall& ball, const glm::dmat3& turn,
                         const glm::dvec3& center_m, const fixtures::Haze& haze) {
  constexpr int kPoints = 24;
  double sum = 0;
  for (const glm::dvec3& half : fixtures::mirror_normals(ball)) {
    for (const double side : {-1.0, 1.0}) {
      const glm::dvec3 normal = turn * (side * half);
      const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), normal));
      const glm::dvec3 up = glm::cross(normal, right);
      const double cell_m2 = ball.mirror_m * ball.mirror_m / (kPoints * kPoints);
      for (int i = 0; i < kPoints * kPoints; ++i) {
        const glm::dvec3 at = center_m + ball.diameter_m / 2 * normal +
                              ball.mirror_m * ((i % kPoints + 0.5) / kPoints - 0.5) * right +
                              ball.mirror_m * ((i / kPoints + 0.5) / kPoints - 0.5) * up;
        sum += judge_illuminance(lamp, haze, at, normal, {}) * cell_m2 * lamp.strength_lm.x;
      }
    }
  }
  return sum;
}

TEST_CASE("the walls of a closed room get the lumens that the mirrors get, times their reflectance") {
  for (const double beam_deg : {8.0, 20.0, 60.0}) {
    for (const char* ball : {"diameter_m = 0.5, mirror_m = 0.1", "diameter_m = 0.5, mirror_m = 0.03"}) {
      CAPTURE(beam_deg);
      CAPTURE(ball);
      Scene scene = ball_scene(ball, beam_deg);
      scene.rig.haze.scattering_per_m = 0;
      scene.compile();
      for (std::size_t lamp = 0; lamp < kLamps; ++lamp) scene.set(lamp, "Dimmer", 1);
      const JudgeScene judge = judged_scene(scene);
      fixtures::f64::Walker walker(scene.compiled);
      walker.step(scene.levels, 0);
      const auto& head = scene.compiled.heads[2];
      const auto pose = walker.beam_pose(head, scene.compiled.types[head.type], walker.states[2]);
      const glm::dmat3 turn(glm::dvec3(pose.x_axis), -glm::dvec3(pose.y_axis), -glm::dvec3(pose.axis));
      const fixtures::MirrorBall& mirrors = fixtures::type_of(scene.rig, scene.rig.fixtures[2]).mirror_balls[0];
      double got_lm = 0;
      for (std::size_t l = 0; l < kLamps; ++l) {
        got_lm += lumens_on_mirrors(judge.beams[l], mirrors, turn, pose.lens_m, judge.haze);
      }
      double walls_lm = 0;
      for (std::size_t i = kLamps; i < judge.beams.size(); ++i) walls_lm += lumens_on_walls(judge.beams[i], judge.haze);
      const double error = walls_lm / (got_lm * mirrors.reflectance) - 1;
      std::fprintf(stderr, "%.0f degrees, %zu spots: %.1f lm on the mirrors, %.1f lm on the walls, %.2g off\n",
                   beam_deg, judge.beams.size() - kLamps, got_lm, walls_lm, error);
      CHECK(std::abs(error) < (mirrors.mirror_m > 0.05 ? 3e-2 : 5e-3));
    }
  }
}

// The root mean square radius of the spot of a mirror on a screen across its light, by rays from points of the lens
// through points of the square, and that of the beam in its place.
TEST_CASE("a spot is as large as one of rays from a lens over a square mirror") {
  struct Case {
    double mirror_m, lens_m, away_m, spread;
  };
  for (const Case& c : {Case{0.02, 0.055, 4, 0.04}, Case{0.01, 0.055, 4, 0.04}, Case{0.05, 0.055, 4, 0.04},
                        Case{0.02, 0.1, 3, 0.2}, Case{0.02, 0.01, 5, 0.02}, Case{0.05, 0.02, 8, 0.1}}) {
    const double apex_m = c.lens_m / c.spread + c.away_m;
    double scale = 0;
    const double disc_m = f64::mirror_radius(c.mirror_m, 1, 1);
    const double power = f64::mirror_profile(disc_m, c.lens_m, c.away_m, 1 / apex_m, scale);
    const double radius_m = f64::mirror_radius(c.mirror_m, 1, scale);
    const double spread = f64::mirror_spread(radius_m, c.lens_m, c.away_m, 1 / apex_m, scale);
    for (const double screen : {0.25, 0.5, 1.0, 2.0, 4.0}) {
      const double to_m = screen * c.away_m;
      Random random(7);
      double square = 0;
      constexpr int kRays = 40'000;
      for (int i = 0; i < kRays; ++i) {
        const double turn = random.between(0, 2 * std::numbers::pi);
        const double off = c.lens_m * std::sqrt(random.between(0, 1));
        const glm::dvec2 lens(off * std::cos(turn), off * std::sin(turn));
        const glm::dvec2 mirror(random.between(-0.5, 0.5) * c.mirror_m, random.between(-0.5, 0.5) * c.mirror_m);
        const glm::dvec2 hit = mirror + (mirror - lens) * (to_m / c.away_m);
        square += glm::dot(hit, hit) / kRays;
      }
      const double whole = radius_m + spread * to_m;
      const double share = power < 0.75 ? 0.25 : (power + 1) / (2 * power + 4);
      const double error = whole * std::sqrt(share / square) - 1;
      std::fprintf(stderr, "mirror %.2g m, lens %.3g m, %.0f m away, screen %.3g m: %.3g m, %+.3f\n", c.mirror_m,
                   c.lens_m, c.away_m, to_m, std::sqrt(square), error);
      CHECK(std::abs(error) < 0.18);
      if (screen == 1) CHECK(std::abs(error) < 0.08);
    }
  }
}

TEST_CASE("spots follow the lamp: its colour, its dimmer, its strobe and where it points") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = ball_scene();
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  const auto rows_of = [&] {
    (void)draw(*frame, scene);
    return must(frame->read_beams());
  };
  const auto both = rows_of();
  scene.set(0, "Dimmer", 0);
  const auto second = rows_of();
  const JudgeScene judge = judged_scene(scene);
  CHECK(second.size() == judge.beams.size());
  CHECK(second.size() < both.size());
  scene.set(1, "ColorAdd_R", 0);
  const auto cyan = rows_of();
  REQUIRE(cyan.size() == second.size());
  for (std::size_t i = 0; i < cyan.size(); ++i) {
    CHECK(cyan[i].j0.x == 0);
    CHECK(cyan[i].j0.y > 0);
    CHECK(second[i].j0.x > 0);
  }
  scene.set(1, "Dimmer", 0);
  CHECK(rows_of().empty());
  CHECK(must(frame->read_counts()).dark_count == 3);
  scene.set(1, "Dimmer", 1);
  scene.rig.fixtures[1].rotation_deg = {0, 0, 0};  // past the ball
  Scene away = ball_scene();
  away.rig.fixtures[0].rotation_deg = away.rig.fixtures[1].rotation_deg = {180, 0, 0};
  const auto levels = away.levels;
  away.compile();
  away.levels = levels;
  const auto other = make_frame(vulkan.device(), away, judged_settings(8, 8));
  (void)draw(*other, away);
  CHECK(must(other->read_counts()).live_count == 2);
}

TEST_CASE("a ball that turns moves its spots, and a replay has the same rows to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = ball_scene("diameter_m = 0.4, mirror_m = 0.03");
  const auto run = [&](int rotation, std::int64_t dt_ns) {
    scene.slots(2)[100] = static_cast<std::uint8_t>(rotation);
    const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
    frame->step(scene.levels, 0);
    for (int i = 0; i < 5; ++i) frame->step(scene.levels, dt_ns);
    must(frame->draw(view_of(scene.camera), 0));
    return must(frame->read_beams());
  };
  const auto bytes = [](const std::vector<BeamRow>& rows) {
    const auto* first = reinterpret_cast<const char*>(rows.data());
    return std::string(first, first + rows.size() * sizeof(BeamRow));
  };
  const auto still = run(132, 100 * kMs);
  const auto slow = run(200, 100 * kMs);
  CHECK(bytes(still) == bytes(run(132, 100 * kMs)));
  CHECK(bytes(slow) == bytes(run(200, 100 * kMs)));
  CHECK(bytes(slow) != bytes(still));
}

TEST_CASE("a lamp inside a ball, at a mirror or of no width, a black ball and a very fast one give finite rows") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto check = [&](const Scene& scene, const char* what) {
    CAPTURE(what);
    const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
    frame->step(scene.levels, 0);
    frame->step(scene.levels, 3'600'000 * kMs);
    must(frame->draw(view_of(scene.camera), 0));
    const auto rows = must(frame->read_beams());
    CHECK(rows.size() <= scene.compiled.beams_max);
    for (const BeamRow& row : rows) {
      for (const vec4& part : {row.x_axis, row.y_axis, row.axis, row.eye, row.j0}) {
        for (int c = 0; c < 4; ++c) CHECK(std::isfinite(part[c]));
      }
      CHECK(row.x_axis.w > 0);
      CHECK(row.j0.x >= 0);
    }
    for (const float value : must(frame->read_radiance()).rgb) CHECK(std::isfinite(value));
    return rows.size();
  };
  const auto placed = [](Scene scene, const glm::dvec3& lamp_m) {
    scene.rig.fixtures[0].position_m = scene.rig.fixtures[1].position_m = lamp_m;
    const auto levels = scene.levels;
    scene.compile();
    scene.levels = levels;
    return scene;
  };
  CHECK(check(placed(ball_scene("diameter_m = 3, mirror_m = 0.3"), {0, 0, 1.9}), "inside") == kLamps);
  check(placed(ball_scene(), {0.25, 0, 3.43}), "at a mirror");
  check(ball_scene("diameter_m = 0.5, mirror_m = 0.1", 0.01), "no width");
  const auto black = ball_scene("diameter_m = 0.5, mirror_m = 0.1, reflectance = 0");
  CHECK(check(black, "black") > kLamps);
  Scene fast = ball_scene();
  for (fixtures::FixtureType& type : fast.rig.types) {
    if (type.mirror_balls.empty()) continue;
    for (auto& function : type.modes[0].channels[0].functions) function.physical_to *= 1e6;
  }
  const auto levels = fast.levels;
  fast.compile();
  fast.levels = levels;
  fast.slots(2)[100] = 255;
  check(fast, "very fast");
}

TEST_CASE("a rig without a ball has no pass for mirrors and none of its buffers, and says so") {
  const Scene with = ball_scene();
  Scene without = with;
  without.rig.fixtures.pop_back();
  without.compile();
  const FrameSettings settings = judged_settings(8, 8);
  const auto has_pass = [&](const Scene& scene) {
    const auto plan = plan_frame(scene.compiled.needs, settings);
    return std::any_of(plan.begin(), plan.end(), [](const PassPlan& pass) { return pass.name == "mirrors"; });
  };
  CHECK(has_pass(with));
  CHECK_FALSE(has_pass(without));
  const auto out = left_out_passes(without.compiled.needs, settings);
  CHECK(std::any_of(out.begin(), out.end(), [](const LeftOutPass& pass) { return pass.name == "mirrors"; }));
  const auto memory = plan_memory({without.rig, without.compiled, without.compiled.needs, settings});
  CHECK(std::none_of(memory.begin(), memory.end(), [](const PassMemory& pass) { return pass.name == "mirrors"; }));
}

}  // namespace
}  // namespace footlight::render

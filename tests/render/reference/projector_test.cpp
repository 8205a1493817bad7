// Projectors by the judge: the lumens of a picture, its size on a wall, and which way it is up.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/gobos/gobo_images.h"
#include "fixtures/model/rig.h"
#include "fixtures/projectors/projector.h"
#include "fixtures/simulate/walker.h"
#include "render/reference/judge.h"
#include "tests/support/must.h"

namespace footlight::render {
namespace {

using footlight::testing::must;

constexpr double kWallM = 8;  // from the lens, along +y
constexpr double kLensM = 3;  // above the floor
constexpr int kTexels = 512;

// What a projector makes of a wall: lx at x and z in metres from the axis of its lens.
class Wall {
 public:
  explicit Wall(const std::string& keys)
      : rig_(must(fixtures::parse_rig("[rig]\nname = \"x\"\nambient_lx = 0\n[haze]\nscattering_per_m = 0\n"
                                      "[[projector]]\nposition = [0, 0, 3]\naim = [0, 8, 3]\nlumens = 5000\n" +
                                          keys,
                                      "rig.toml"))),
        compiled_(must(fixtures::compile(rig_))) {
    fixtures::f64::Walker walker(compiled_);
    walker.step(std::vector<std::uint8_t>(compiled_.universes.size() * kSlotCountMax), 0);
    texels_ = must(fixtures::gobo_texels(compiled_.images.at(0), kTexels, 0.01));
    scene_ = judge_scene(rig_, walker);
    REQUIRE(scene_.beams.size() == 1);
  }
  [[nodiscard]] double lx(double x, double z) const {
    const JudgeBeam& beam = scene_.beams[0];
    const auto gobo = [this](int, double u, double v) {  // v is downwards
      const auto texel = [](double at) { return std::clamp(static_cast<int>((at + 1) / 2 * kTexels), 0, kTexels - 1); };
      return static_cast<double>(texels_[static_cast<std::size_t>(3 * (texel(v) * kTexels + texel(u)))]);
    };
    return beam.strength_lm.r * judge_illuminance(beam, scene_.haze, {x, kWallM, kLensM + z}, {0, -1, 0}, gobo);
  }
  [[nodiscard]] const fixtures::Projector& words() const { return *rig_.types.at(0).said_by_rig.projector; }

 private:
  fixtures::Rig rig_;
  fixtures::CompiledRig compiled_;
  std::vector<float> texels_;
  JudgeScene scene_;
};

TEST_CASE("the lumens of a projector arrive within its picture, which is where throw ratio and lens shift put it") {
  for (const char* shift : {"[0, 0]", "[0.1, 0.5]"}) {
    CAPTURE(std::string(shift));
    const Wall wall("throw_ratio = 2\naspect = 1.6\nlens_radius_m = 0.001\nlens_shift = " + std::string(shift) + "\n");
    const double width_m = kWallM / 2, height_m = width_m / 1.6;
    const double right_m = width_m * wall.words().lens_shift.x, up_m = height_m * wall.words().lens_shift.y;
    constexpr int kNodes = 200;
    constexpr double kExtent = 1.2;  // of the picture
    double inside_lm = 0, beside_lm = 0;
    for (int i = 0; i < kNodes; ++i) {
      for (int j = 0; j < kNodes; ++j) {
        const double u = kExtent * ((i + 0.5) / kNodes - 0.5), v = kExtent * ((j + 0.5) / kNodes - 0.5);
        const double lm = wall.lx(right_m + u * width_m, up_m + v * height_m) * width_m * height_m * kExtent * kExtent /
                          (kNodes * kNodes);
        // Within two texels of the gobo the edge may be on either side.
        (std::max(std::abs(u), std::abs(v)) < 0.51 ? inside_lm : beside_lm) += lm;
      }
    }
    CHECK(inside_lm == doctest::Approx(5000).epsilon(0.02));
    CHECK(beside_lm == 0);
    const double middle_lx = wall.lx(right_m, up_m);
    CHECK(wall.lx(right_m + 0.49 * width_m, up_m) > 0.75 * middle_lx * (up_m > 0 ? 0.9 : 1));
  }
}

TEST_CASE("a keystone leaves a place its light, and blackens what is outside") {
  const std::string optics = "throw_ratio = 2\naspect = 1.6\nlens_radius_m = 0.001\n";
  const Wall plain(optics), moved(optics + "keystone = { top_left = [0.25, 0], top_right = [-0.25, 0] }\n");
  const double width_m = kWallM / 2, height_m = width_m / 1.6;
  double inside_lm = 0, plain_lm = 0;
  constexpr int kNodes = 120;
  for (int i = 0; i < kNodes; ++i) {
    for (int j = 0; j < kNodes; ++j) {
      const double u = (i + 0.5) / kNodes - 0.5, v = (j + 0.5) / kNodes - 0.5;
      const double half = 0.5 - 0.25 * (v + 0.5);  // of the picture's width at this height
      const double before_lx = plain.lx(u * width_m, v * height_m), after_lx = moved.lx(u * width_m, v * height_m);
      if (std::abs(u) < half - 0.01 && std::abs(v) < 0.49) {
        CHECK(after_lx == doctest::Approx(before_lx).epsilon(1e-6));
        inside_lm += after_lx * width_m * height_m / (kNodes * kNodes);
      } else if (std::abs(u) > half + 0.01) {
        CHECK(after_lx == 0);
      }
      plain_lm += before_lx * width_m * height_m / (kNodes * kNodes);
    }
  }
  CHECK(plain_lm == doctest::Approx(5000).epsilon(0.02));
  CHECK(inside_lm < 0.85 * plain_lm);
  CHECK(inside_lm > 0.65 * plain_lm);
}

TEST_CASE("a dimmed projector without levels is dark, and one without an address is at full") {
  CHECK(Wall("throw_ratio = 2\n").lx(0, 0) > 100);
  const fixtures::Rig rig = must(fixtures::parse_rig(
      "[rig]\nname = \"x\"\n[[projector]]\nposition = [0, 0, 3]\naim = [0, 8, 3]\nuniverse = 1\n", "rig.toml"));
  const fixtures::CompiledRig compiled = must(fixtures::compile(rig));
  fixtures::f64::Walker walker(compiled);
  walker.step(std::vector<std::uint8_t>(kSlotCountMax), 0);
  CHECK(judge_scene(rig, walker).beams.empty());
}

}  // namespace
}  // namespace footlight::render

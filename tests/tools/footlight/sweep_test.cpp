// Sweeps of the report: their words, and scenes that differ in one property.
#include <doctest/doctest.h>

#include "tests/support/must.h"
#include "tools/footlight/report/sweep.h"

namespace footlight::tools {
namespace {

using footlight::testing::must;

TEST_CASE("a sweep is a property and numbers with commas, and anything else is refused with the forms that are right") {
  const Sweep sweep = must(parse_sweep("beams=100,1000,10000"));
  CHECK(sweep.of == Sweep::Of::kBeams);
  CHECK(sweep.values == std::vector<double>{100, 1000, 10000});
  CHECK(must(parse_sweep("gobos=0,12.5,100")).values == std::vector<double>{0, 12.5, 100});
  for (const char* wrong : {"", "beams", "beams=", "beams=0", "beams=1,", "beams=1,,2", "gobos=101", "clutter=-1",
                            "lamps=3", "pixels=1e3x", "clutter=nan"}) {
    INFO(wrong);
    const auto refused = parse_sweep(wrong);
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().message.find("expected beams=, pixels=, gobos=") != std::string::npos);
  }
}

TEST_CASE("the scenes of a sweep differ in what is swept and in nothing else") {
  PictureReportOptions options;
  const SweepScene scene{.beams = 24};
  const Scene plain = must(scene_of_sweep({Sweep::Of::kClutter, {}}, 0, scene, options));
  const Scene cluttered = must(scene_of_sweep({Sweep::Of::kClutter, {}}, 7, scene, options));
  CHECK(plain.rig.fixtures.size() == 24);
  CHECK(cluttered.rig.boxes.size() == plain.rig.boxes.size() + 7);
  CHECK(cluttered.levels == plain.levels);
  CHECK(must(scene_of_sweep({Sweep::Of::kBeams, {}}, 5, scene, options)).rig.fixtures.size() == 5);
  CHECK(options.width == 640);
  CHECK(must(scene_of_sweep({Sweep::Of::kPixels, {}}, 3840 * 2160, scene, options)).levels == plain.levels);
  CHECK(options.width == 3840);
  CHECK(options.height == 2160);
}

// A level that is not 0 on the wheel's slot is a gobo.
TEST_CASE("a share of gobos is a share of the beams") {
  PictureReportOptions options;
  for (const double percent : {25.0, 50.0, 100.0}) {
    const Scene scene = must(scene_of_sweep({Sweep::Of::kGobos, {}}, percent, {.beams = 64}, options));
    int with_gobo = 0;
    // 51 beams of 10 slots a universe.
    for (std::size_t i = 0; i < 64; ++i) with_gobo += scene.levels[i / 51 * 512 + i % 51 * 10 + 6] > 0 ? 1 : 0;
    CHECK(with_gobo >= 64 * percent / 100 - 2);
    CHECK(with_gobo <= 64 * percent / 100 + 2);
  }
}

}  // namespace
}  // namespace footlight::tools

// The report of the features that a rig does not need.
#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "fixtures/model/features.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tools/footlight/report/left_out.h"

namespace footlight::tools {
namespace {

using footlight::testing::HeadlessVulkan;
using footlight::testing::must;

// Bodies and smooth edges are left out, because each row compiles the shaders of a whole frame.
const LeftOutOptions kSmall{
    .settings = {.width = 32, .height = 18, .tile_beams = 1, .bodies = false, .edge_samples = 0},
    .runs = 3,
    .go_on = {}};

// Without haze and boxes the rig has neither beams nor surfaces to draw: those shaders compile longest, and only the
// rows of the needs that add their passes compile them.
Scene clear_scene(int beams) {
  Scene scene = must(make_beams_scene(beams, ""));
  scene.rig.haze.scattering_per_m = 0;
  scene.rig.boxes.clear();
  scene.compiled = must(fixtures::compile(scene.rig));
  return scene;
}

const LeftOutRow& row_of(const std::vector<LeftOutRow>& rows, const std::string& name, bool pass) {
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const auto& each) { return each.name == name && each.pass == pass; });
  REQUIRE_MESSAGE((found != rows.end()), name);
  return *found;
}

TEST_CASE("each need that a rig lacks, and the passes that it adds, have bytes, and a time if shaders depend on it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = clear_scene(3);
  const auto rows = must(measure_left_out(vulkan.device(), scene, kSmall));
  std::size_t missing = 0;
  for (const fixtures::Feature& feature : fixtures::features()) {
    if (!(scene.compiled.needs.*feature.need)) ++missing;
  }
  CHECK(missing > 15);
  const auto passes = render::left_out_passes(scene.compiled.needs, kSmall.settings);
  CHECK(rows.size() == missing + passes.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const LeftOutRow& row = rows[i];
    INFO(row.name);
    CHECK(row.pass == (i < passes.size()));
    if (row.pass) CHECK(row.name == passes[i].name);
    CHECK(!row.text.empty());
    if (row.pass) continue;
    // Without a floor that mirrors there is nothing to time.
    CHECK(row.times.has_value() == (row.on_gpu && row.name != "gloss"));
    if (!row.times) continue;
    CHECK(row.times->ms_p10 <= row.times->ms_p50);
    CHECK(row.times->ms_p50 <= row.times->ms_p90);
  }
  CHECK(row_of(rows, "blades", false).bytes == scene.compiled.beams_max * sizeof(render::BladesRow));
  CHECK(row_of(rows, "motion", false).on_gpu);
  CHECK(row_of(rows, "motion", false).bytes == 0);
  CHECK(!row_of(rows, "machines", false).on_gpu);  // they have no state on the GPU
  CHECK(!row_of(rows, "bodies", true).on_gpu);     // the settings leave them out, and no need adds them

  const LeftOutRow& beams = row_of(rows, "beams", true);
  const LeftOutRow& haze = row_of(rows, "haze", false);
  std::uint64_t pass_bytes = 0;
  for (const char* name : {"tiles", "depths", "shadowtiles", "coarse", "records", "fine", "shade", "beams", "glare"}) {
    pass_bytes += row_of(rows, name, true).bytes;
  }
  REQUIRE(beams.times);
  REQUIRE(haze.times);
  CHECK(beams.times->ms_p10 > 0);
  CHECK(haze.bytes == pass_bytes);
}

TEST_CASE("without runs nothing is timed, and the bytes are the same") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = must(make_beams_scene(3, ""));
  const LeftOutOptions options{.settings = {.width = 32, .height = 18, .tile_beams = 1}, .runs = 0, .go_on = {}};
  const auto rows = must(measure_left_out(vulkan.device(), scene, options));
  CHECK(row_of(rows, "blades", false).bytes == scene.compiled.beams_max * sizeof(render::BladesRow));
  CHECK(row_of(rows, "motion", false).on_gpu);
  std::set<std::string> passes;
  for (const LeftOutRow& row : rows) {
    CAPTURE(row.name);
    CHECK(!row.times);
    if (row.pass) passes.insert(row.name);
  }
  // Nothing has a gobo, haze is even, there is no laser, sun or display, judged pictures have no reflected light, and
  // no depth of field is asked for.
  CHECK(passes == std::set<std::string>{"gobos", "gloss", "haze", "lasers", "mirrors", "shafts", "displays", "strips",
                                        "bounce", "probes", "reflections", "blur"});
  CHECK(row_of(rows, "gobo", false).bytes > 0);
  CHECK(row_of(rows, "plumes", false).bytes > row_of(rows, "clouds", false).bytes);
  CHECK((text_of(rows, "beams").find("not timed") != std::string::npos));

  // The same without a device.
  const LeftOutPlan plan = plan_left_out({scene.rig, scene.compiled, scene.compiled.needs, options.settings});
  REQUIRE(plan.rows.size() == rows.size());
  std::uint64_t code_bytes = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CAPTURE(rows[i].name);
    CHECK(plan.rows[i].name == rows[i].name);
    CHECK(plan.rows[i].bytes == rows[i].bytes);
    CHECK(plan.rows[i].on_gpu == rows[i].on_gpu);
    CHECK(plan.rows[i].code_bytes == rows[i].code_bytes);
    CHECK((rows[i].code_bytes > 0) == rows[i].pass);
    code_bytes += rows[i].code_bytes;
  }
  CHECK(plan.code_bytes == code_bytes);
  CHECK(plan.used_code_bytes > plan.code_bytes);
}

TEST_CASE("measuring ends between two rows when go_on returns false") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = clear_scene(1);
  LeftOutOptions options = kSmall;
  options.go_on = [](double done, double) { return done < 2; };
  const auto rows = must(measure_left_out(vulkan.device(), scene, options));
  CHECK(std::count_if(rows.begin(), rows.end(), [](const LeftOutRow& row) { return !row.pass; }) == 2);
}

TEST_CASE("rows state milliseconds and bytes, as text and as JSON") {
  const std::vector<LeftOutRow> rows = {
      {.name = "beams", .text = "beams in the air", .pass = true, .bytes = 3 << 20, .times = {{0.5, 1.25, 2}}},
      {.name = "blades", .text = "no edges are cut", .bytes = 9216, .times = {{-0.01, 0.002, 0.01}}},
      {.name = "motion", .text = "no axes", .bytes = 0, .times = {}},
      {.name = "machines", .text = "the air stays", .on_gpu = false, .times = {}}};
  const std::string text = text_of(rows, "demo@30s");
  CHECK((text.find("demo@30s") != std::string::npos));
  CHECK(
      (text.find("\n  pass beams: beams in the air; +1.250 ms (+0.500 to +2.000), 3072.0 KiB\n") != std::string::npos));
  CHECK((text.find("\n  blades: no edges are cut; +0.002 ms (-0.010 to +0.010), 9216 B\n") != std::string::npos));
  CHECK((text.find("\n  motion: no axes, 0 B\n") != std::string::npos));
  CHECK((text.find("\n  machines: the air stays; nothing on the GPU\n") != std::string::npos));
  CHECK((text_of({}, "demo").find("  nothing\n") != std::string::npos));

  const std::string lines = json_of(rows);
  const auto first = nlohmann::json::parse(lines.substr(0, lines.find('\n')));
  CHECK(first["event"] == "left-out");
  CHECK(first["pass"] == "beams");
  CHECK(first["ms_p50"] == 1.25);
  CHECK(first["bytes"] == 3 << 20);
  CHECK(std::count(lines.begin(), lines.end(), '\n') == 4);
  CHECK((lines.find("\"need\":\"machines\"") != std::string::npos));
}

}  // namespace
}  // namespace footlight::tools

// Curves of knobs: measured, and kept in a file.
#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tools/footlight/pictures/knob_curves.h"

namespace footlight::tools {
namespace {

using footlight::testing::HeadlessVulkan;
using footlight::testing::must;
using footlight::testing::TempFolder;
using render::GoboMethod;
using render::KnobCurves;

KnobCurves some_curves() {
  KnobCurves curves;
  render::Knobs knobs;
  knobs.tile_error = 1.0 / 3;
  knobs.gobo_method = GoboMethod::kTables;
  curves.beams = {{knobs, 1e-3, 1.0 / 7}, {knobs, 0, 2}};
  curves.gobos = {{knobs, 1e-2, 3}};
  curves.bodies = {{knobs, 0, 4}};
  knobs.divisor = 2;
  knobs.bounce = false;
  curves.left_out = {{knobs, 0, 5}};
  return curves;
}

bool equal(const KnobCurves& a, const KnobCurves& b) {
  const auto same = [](const std::vector<render::KnobPoint>& one, const std::vector<render::KnobPoint>& other) {
    return std::equal(one.begin(), one.end(), other.begin(), other.end(),
                      [](const render::KnobPoint& x, const render::KnobPoint& y) {
                        return x.knobs == y.knobs && x.error == y.error && x.ms == y.ms;
                      });
  };
  return same(a.beams, b.beams) && same(a.gobos, b.gobos) && same(a.bodies, b.bodies) && same(a.left_out, b.left_out);
}

render::vk::DeviceFacts some_facts() {
  render::vk::DeviceFacts facts;
  facts.properties.driverVersion = 0x1234;
  facts.id.deviceUUID[3] = 7;
  return facts;
}

std::string read(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}
void write(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

TEST_CASE("curves are read back to the bit, by the same device, driver and program only") {
  const TempFolder folder;
  const auto facts = some_facts();
  const std::string path = knob_curves_path(folder.file("new/folder"), facts);
  CHECK(!read_knob_curves(path, facts, "p"));
  must(write_knob_curves(path, facts, "p", some_curves()));
  const auto back = read_knob_curves(path, facts, "p");
  REQUIRE(back);
  CHECK(equal(*back, some_curves()));
  CHECK(!read_knob_curves(path, facts, "q"));
  auto other = facts;
  other.properties.driverVersion = 0x1235;
  CHECK(!read_knob_curves(path, other, "p"));
  CHECK(knob_curves_path("", other) != knob_curves_path("", facts));
  other = facts;
  other.id.deviceUUID[15] = 1;
  CHECK(!read_knob_curves(path, other, "p"));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.file("new/folder")), {}) == 1);  // no part is left
  CHECK(!write_knob_curves("/proc/none/a", facts, "p", some_curves()));
}

TEST_CASE("a file of curves that is cut off or changed anywhere is ignored") {
  const TempFolder folder;
  const auto facts = some_facts();
  const std::string path = folder.file("curves");
  must(write_knob_curves(path, facts, "p", some_curves()));
  const std::string whole = read(path);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    write(path, whole.substr(0, i));
    CHECK(!read_knob_curves(path, facts, "p"));
    std::string changed = whole;
    changed[i] ^= 1;
    write(path, changed);
    CHECK(!read_knob_curves(path, facts, "p"));
  }
  write(path, whole + "x");
  CHECK(!read_knob_curves(path, facts, "p"));
  KnobCurves unsound = some_curves();
  unsound.beams[0].ms = -1;
  must(write_knob_curves(path, facts, "p", unsound));
  CHECK(!read_knob_curves(path, facts, "p"));
}

TEST_CASE("curves are not measured where their file is whole, and are where it is damaged") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  KnobCurveOptions options;
  options.go_on = [](double, double) { return false; };
  int measured = 0;
  const auto curves = [&] {
    return machine_knob_curves(vulkan.device(), folder.file(""), options, [&] { ++measured; });
  };
  const std::string path = knob_curves_path(folder.file(""), vulkan.device().facts());
  must(write_knob_curves(path, vulkan.device().facts(), curves_program(), some_curves()));
  CHECK(equal(must(curves()), some_curves()));
  CHECK(measured == 0);
  write(path, "damaged");
  CHECK(!curves());  // go_on ends it
  CHECK(measured == 1);
  CHECK(curves_program().starts_with("0.1.0-"));
}

}  // namespace
}  // namespace footlight::tools

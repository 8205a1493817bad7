// The knobs of --ms in a window under Xvfb.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tests/tools/footlight/display.h"
#include "tests/tools/footlight/one_par.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/pictures/knob_curves.h"

namespace footlight::testing {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kPatience(120);  // a picture of lavapipe takes seconds on a busy machine

// A machine on which everything takes so little time that all fits.
render::KnobCurves quick_curves() {
  render::KnobCurves curves;
  render::Knobs exact;
  exact.tile_error = 0;
  exact.nodes = 8;
  curves.beams = {{exact, 0, 2}, {render::Knobs{}, 1e-4, 1}};
  curves.gobos = {{render::Knobs{}, 1e-3, 1}};
  curves.bodies = {{render::Knobs{}, 0, 1}};
  double ms = 1;
  curves.left_out = {{render::Knobs{}, 0, ms}};
  for (const render::Knobs& knobs : render::left_out_knobs()) curves.left_out.push_back({knobs, 0, ms *= 0.5});
  return curves;
}

TEST_CASE("a window that begins without shadows and reflected light on a CPU adds them where the time allows it") {
  if (std::system("command -v Xvfb > /dev/null") != 0) {  // NOLINT: fixed words
    MESSAGE("skipped: needs Xvfb; 'sudo apt-get install xvfb'");
    return;
  }
  const TempFolder folder;
  {
    const HeadlessVulkan vulkan;
    if (!vulkan) return;
    if (!vulkan.device().is_software()) return;
    const auto& facts = vulkan.device().facts();
    must(tools::write_knob_curves(tools::knob_curves_path(folder.file("footlight"), facts), facts,
                                  tools::curves_program(), quick_curves()));
  }
  std::ofstream(folder.file("rig.toml")) << kOnePar << kFrontCamera;
  const Display display(320, 180);
  REQUIRE(!display.name().empty());
  Footlight window({"preview", folder.file("rig.toml"), "--ms", "60000", "--size", "320x180", "--json"},
                   {{"DISPLAY", display.name()},
                    {"WAYLAND_DISPLAY", ""},
                    {"XDG_CACHE_HOME", folder.file("")},
                    {"XDG_STATE_HOME", folder.file("state")},
                    {"ASAN_OPTIONS", "detect_leaks=0"}});  // drivers of GPUs leak
  bool began_without = false;
  std::string last;
  bool whole = false;
  for (const auto begun = Clock::now(); !whole && Clock::now() - begun < kPatience;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    last = window.last_line();
    const auto figures = nlohmann::json::parse(last, nullptr, false);
    if (!figures.is_object() || figures["event"] != "frames" || !figures.contains("knobs")) continue;
    const std::string text = figures["knobs"];
    began_without = began_without || text.find("no reflected light, no shadows") != std::string::npos;
    whole = text == "tile error 0, 8 nodes, gobos as suit the device, bodies 0.5 px";
  }
  INFO("the last line is ", last);
  CHECK(whole);
  CHECK(began_without);
  window.signal(SIGTERM);
  CHECK(window.wait().exit_code == 0);
}

}  // namespace
}  // namespace footlight::testing

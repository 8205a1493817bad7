#include "tools/footlight/report/other_light.h"

#include <algorithm>

#include "fixtures/simulate/walker.h"
#include "render/reference/judge.h"
#include "sim/core/counted.h"

namespace footlight::tools {

OtherLight other_light(const Scene& scene) {
  OtherLight light;
  const fixtures::Sun& sun = scene.rig.sun;
  light.sun = scene.compiled.needs.panes && (sun.illuminance_lx > 0 || sun.sky_lx > 0);
  if (!scene.compiled.needs.displays) return light;
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const render::JudgeScene judge = render::judge_scene(scene.rig, walker);
  light.displays = std::any_of(judge.displays.begin(), judge.displays.end(), [](const render::JudgeDisplay& display) {
    return std::any_of(display.pixels_cd_m2.begin(), display.pixels_cd_m2.end(),
                       [](const glm::dvec3& pixel) { return std::max({pixel.r, pixel.g, pixel.b}) > 0; });
  });
  return light;
}

std::string lights_of(const fixtures::Rig& rig) {
  std::string text;
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) text += (text.empty() ? "" : ", ") + counted(count, what);
  };
  add(rig.fixtures.size(), "fixture");
  add(rig.displays.size(), "display");
  return text;
}

}  // namespace footlight::tools

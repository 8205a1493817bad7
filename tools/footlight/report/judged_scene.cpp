#include "tools/footlight/report/judged_scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "fixtures/gobos/gobo.h"
#include "fixtures/gobos/gobo_images.h"
#include "fixtures/simulate/walker.h"
#include "render/pass.h"
#include "render/reference/plume_judge.h"

namespace footlight::tools {
namespace {

using namespace render;

// Texels of an image. The judge interpolates between them as the GPU does.
struct Texels {
  int size = 0;
  std::vector<float> rgb;

  [[nodiscard]] glm::dvec3 at(int column, int row) const {
    const int x = std::clamp(column, 0, size - 1);
    const int y = std::clamp(row, 0, size - 1);
    const float* texel =
        &rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x))];
    return {texel[0], texel[1], texel[2]};
  }
  // x, y: -1 to 1.
  [[nodiscard]] glm::dvec3 through(double x, double y) const {
    const double column = (0.5 * x + 0.5) * size - 0.5;
    const double row = (0.5 * y + 0.5) * size - 0.5;
    const double left = std::floor(column);
    const double top = std::floor(row);
    const int i = static_cast<int>(left);
    const int j = static_cast<int>(top);
    return glm::mix(glm::mix(at(i, j), at(i + 1, j), column - left),
                    glm::mix(at(i, j + 1), at(i + 1, j + 1), column - left), row - top);
  }
};

// The images of the rig in the order of its layers: built-in ones from their formulas, others from their texels.
GoboColors gobos_of(const fixtures::CompiledRig& compiled, int size_px) {
  struct Layer {
    int builtin = 0;
    Texels texels;
  };
  std::vector<Layer> layers;
  for (const fixtures::ImageSource& image : compiled.images) {
    Layer layer;
    for (int gobo = 1; gobo <= fixtures::kGoboCount; ++gobo) {
      if (image.name == std::string(fixtures::kBuiltinImage) + fixtures::gobo_name(gobo)) layer.builtin = gobo;
    }
    if (layer.builtin == 0) {
      auto texels = fixtures::gobo_texels(image, size_px, kGoboEdge);
      layer.texels = {size_px,
                      texels ? std::move(*texels) : fixtures::stand_in_texels(layers.size(), size_px, kGoboEdge)};
    }
    layers.push_back(std::move(layer));
  }
  const auto shared = std::make_shared<const std::vector<Layer>>(std::move(layers));  // the judge copies the function
  return [shared](int layer, double x, double y) {
    const Layer& one = shared->at(static_cast<std::size_t>(layer - 1));
    return one.builtin > 0 ? glm::dvec3(fixtures::gobo_transmission(one.builtin, x, y, kGoboEdge))
                           : one.texels.through(x, y);
  };
}

bool only_builtin(const fixtures::CompiledRig& compiled) {
  return std::all_of(compiled.images.begin(), compiled.images.end(), [](const fixtures::ImageSource& image) {
    return image.name.starts_with(fixtures::kBuiltinImage);
  });
}

}  // namespace

JudgeScene judge_of(const Scene& scene, const FrameSettings& settings, bool on_cpu) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  const int size_px = gobo_size_px(settings, scene.compiled.images.size(), on_cpu);
  const GoboColors gobos = gobos_of(scene.compiled, size_px);
  JudgeScene judge =
      judge_scene(scene.rig, walker, [gobos](int gobo, double x, double y) { return gobos(gobo, x, y).x; });
  if (!only_builtin(scene.compiled)) judge.colors = gobos;
  // With 64 points of a lens the judge of gobos out of focus is off by up to 1e-2 itself (docs/decisions/0194).
  for (JudgeBeam& beam : judge.beams) {
    if (beam.focus_per_m >= 0) beam.blur_points = 1024;
  }
  judge.glosses.clear();
  if (scene.compiled.needs.plumes) add_plumes(judge, plume_field(scene.puffs, scene.rig.haze.scattering_per_m, 0));
  return judge;
}

}  // namespace footlight::tools

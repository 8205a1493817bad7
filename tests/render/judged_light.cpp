#include "tests/render/judged_light.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "fixtures/simulate/walker.h"
#include "render/reference/judge.h"

namespace footlight::render::testing {

void view_from(Scene& scene, glm::dvec3 from, glm::dvec3 to) {
  scene.rig.cameras[0].position_m = from;
  scene.rig.cameras[0].target_m = to;
}

RadianceImage drawn_light(vk::Device& device, const Scene& scene, int width, int height, bool judged,
                          const std::function<void(FrameSettings&)>& change) {
  FrameSettings settings = judged_settings(width, height);
  settings.widen_thin = !judged;
  change(settings);
  auto frame = make_frame(device, scene, settings);
  frame->step(scene.levels, 0);
  must(frame->draw(view_of(scene.rig.cameras[0]), 0));
  return must(frame->read_radiance());
}

std::vector<double> judged_light(const Scene& scene, int width, int height) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  JudgeOptions options;
  options.stated_error = false;
  return judge_image(judge_scene(scene.rig, walker), view_of(scene.rig.cameras[0]), width, height, options).rgb;
}

double rel_l2(const RadianceImage& image, const std::vector<double>& judge) {
  double error = 0, light = 0;
  for (std::size_t i = 0; i < judge.size(); ++i) {
    const double difference = static_cast<double>(image.rgb[i]) - judge[i];
    error += difference * difference;
    light += judge[i] * judge[i];
  }
  REQUIRE(light > 0);
  return std::sqrt(error / light);
}

double sum_of(const RadianceImage& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += static_cast<double>(value);
  return sum;
}

void print_error(const char* what, double error) {
  if (std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr) std::printf("%-44s %.2e\n", what, error);
}

}  // namespace footlight::render::testing

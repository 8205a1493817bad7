#include "tools/footlight/report/laser_report.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "fixtures/simulate/walker.h"
#include "render/reference/laser_judge.h"
#include "tools/footlight/report/judged_scene.h"

namespace footlight::tools {
namespace {

using namespace render;

constexpr double kStepPx = 0.3;

Result<std::vector<JudgeLaser>> lit_of(const Scene& scene) {
  fixtures::f64::Walker walker(scene.compiled);
  walker.step(scene.levels, 0);
  FL_ASSIGN(std::vector<JudgeLaser> lasers, judged_lasers(scene.rig, walker, light_range_m(scene.rig)));
  std::erase_if(lasers, [](const JudgeLaser& laser) {
    return laser.moves.empty() || !(std::max({laser.flux_lm.x, laser.flux_lm.y, laser.flux_lm.z}) > 0);
  });
  return lasers;
}

Result<RadianceImage> drawn(vk::Device& device, const Scene& scene, const View& view, const FrameSettings& settings) {
  FL_ASSIGN(const auto frame, Frame::create(device, scene.rig, scene.compiled, settings));
  frame->step(scene.levels, 0);
  FL_TRY(frame->draw(view, scene.camera.exposure_ev));
  return frame->read_radiance();
}

}  // namespace

Result<int> lit_lasers(const Scene& scene) {
  FL_ASSIGN(const auto lasers, lit_of(scene));
  return static_cast<int>(lasers.size());
}

Result<std::optional<LaserError>> measure_lasers(vk::Device& device, const Scene& scene, const View& view,
                                                 const FrameSettings& settings,
                                                 const std::function<bool(double done)>& go_on) {
  FL_ASSIGN(const std::vector<JudgeLaser> lasers, lit_of(scene));
  if (lasers.empty()) return std::optional<LaserError>();
  FrameSettings small = settings;
  small.width = std::min(settings.width, kLaserJudgePx);
  small.height =
      std::max(1, static_cast<int>(std::lround(static_cast<double>(settings.height) * small.width / settings.width)));
  small.widen_thin = true;  // else no laser is drawn
  Scene even = scene;
  even.rig.haze.noise = even.rig.haze.height_m = 0;
  even.compiled.needs.haze_field = even.compiled.needs.plumes = false;
  FL_ASSIGN(const RadianceImage with, drawn(device, even, view, small));
  Scene dark = even;
  dark.compiled.needs.laser = false;
  FL_ASSIGN(const RadianceImage without, drawn(device, dark, view, small));
  std::vector<float> light(with.rgb.size());
  for (std::size_t i = 0; i < light.size(); ++i) light[i] = with.rgb[i] - without.rgb[i];

  const JudgeScene judge = judge_of(even, small, device.is_software());
  // Work grows with the square of the number of pieces.
  const auto judged = [&](double step_px, double begin, double share) {
    const auto so_far = [&](double done) { return !go_on || go_on(begin + share * done); };
    return judge_lasers(judge, lasers, view, small.width, small.height, step_px, so_far);
  };
  const std::vector<double> rough = judged(2 * kStepPx, 0, 0.2);
  if (rough.empty()) return std::optional<LaserError>();
  const std::vector<double> fine = judged(kStepPx, 0.2, 0.8);
  if (fine.empty()) return std::optional<LaserError>();
  LaserError error{picture_norms(light, fine), 0, static_cast<int>(lasers.size()), small.width, small.height};
  double square = 0, difference = 0;
  for (std::size_t i = 0; i < fine.size(); ++i) {
    square += fine[i] * fine[i];
    difference += (rough[i] - fine[i]) * (rough[i] - fine[i]);
  }
  error.own_rel_l2 = square > 0 ? std::sqrt(difference / square) : 0;
  return std::optional<LaserError>(error);
}

}  // namespace footlight::tools

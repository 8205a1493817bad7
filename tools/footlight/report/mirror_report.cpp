#include "tools/footlight/report/mirror_report.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "render/pass.h"
#include "render/reference/bounce_judge.h"
#include "render/reference/cores.h"
#include "render/reference/display_judge.h"
#include "render/reference/judge_mesh.h"
#include "render/reference/pixel_sample.h"
#include "tools/footlight/report/judged_scene.h"

namespace footlight::tools {
namespace {

using namespace render;

constexpr int kBounces = 8;             // surfaces on a path of light that surfaces reflect
constexpr double kTolerance = 1e-2;     // relative, of the integrals of each ray; a hundredth of it is used
constexpr double kSamePlaceM = 0.01;    // a pixel shows what the judge's ray meets
constexpr int kDisplayCells = 64;       // that displays light the air and surfaces with; all of them
constexpr std::uint64_t kMirrorSeed = 2;

// The pictures with and without probes, and what they show.
struct Drawn {
  RadianceImage with, without;
  std::vector<float> distances_m;
};

Result<Drawn> draw_both(vk::Device& device, const Scene& scene, const View& view, const FrameSettings& settings) {
  Drawn drawn;
  FrameSettings own = settings;
  own.bodies = own.bounce = own.probes = true;
  own.probe_texels = FL_PROBE_TEXELS;
  FL_ASSIGN(const auto frame, Frame::create(device, scene.rig, scene.compiled, own));
  frame->set_puffs(scene.puffs);
  frame->step(scene.levels, 0);
  FL_TRY(frame->draw(view, scene.camera.exposure_ev));
  FL_ASSIGN(drawn.with, frame->read_radiance(&drawn.distances_m));
  own.probes = false;
  FL_TRY(frame->change(own));
  FL_TRY(frame->draw(view, scene.camera.exposure_ev));
  FL_ASSIGN(drawn.without, frame->read_radiance());
  return drawn;
}

// The pixels whose surface mirrors, in the order of the picture.
std::vector<std::uint32_t> shiny_pixels(const JudgeScene& judge, const View& view, const Drawn& drawn) {
  const int width = drawn.with.width, height = drawn.with.height;
  std::vector<std::uint8_t> shiny(drawn.distances_m.size());
  std::atomic<int> next{0};
  on_threads(0, [&] {
    for (int y = next++; y < height; y = next++) {
      for (int x = 0; x < width; ++x) {
        const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
        const std::optional<SurfaceHit> hit = judge_hit(judge, pixel_ray(view, width, height, x, y));
        const auto shown_m = static_cast<double>(drawn.distances_m[pixel]);
        shiny[pixel] = hit && hit->sheen && std::abs(hit->t_m - shown_m) <= kSamePlaceM * hit->t_m ? 1 : 0;
      }
    }
  });
  std::vector<std::uint32_t> pixels;
  for (std::size_t i = 0; i < shiny.size(); ++i) {
    if (shiny[i] != 0) pixels.push_back(static_cast<std::uint32_t>(i));
  }
  return pixels;
}

// What surfaces mirror at the pixels, 3 values each; empty if go_on ended it.
class MirrorJudge {
 public:
  MirrorJudge(JudgeScene judge, const View& view, const FrameSettings& settings,
              const std::vector<std::uint32_t>& pixels, const std::function<bool(double)>& go_on)
      : judge_(std::move(judge)), view_(view), settings_(settings), pixels_(pixels), go_on_(go_on) {}

  // done, share: of the whole that this part begins at and takes.
  std::vector<double> by_rays(int rays, double done, double share) {
    judge_.sheen_rays = rays;
    std::vector<double> light = radiance(done, share);
    judge_.sheen_rays = 0;
    const std::vector<double> without = light.empty() ? light : radiance(done + share, 0);
    if (without.empty()) return {};
    for (std::size_t i = 0; i < light.size(); ++i) light[i] -= without[i];
    return light;
  }

 private:
  std::vector<double> radiance(double done, double share) {
    JudgeOptions options{.tolerance = kTolerance, .stated_error = false, .go_on = {}};
    if (go_on_) options.go_on = [&](int some, int all) { return go_on_(done + share * some / all); };
    JudgedPixels judged = judge_pixels(judge_, view_, settings_.width, settings_.height, pixels_, options);
    return judged.whole ? std::move(judged.rgb) : std::vector<double>();
  }

  JudgeScene judge_;
  const View& view_;
  const FrameSettings& settings_;
  const std::vector<std::uint32_t>& pixels_;
  const std::function<bool(double)>& go_on_;
};

std::vector<double> difference(const std::vector<float>& a, const std::vector<float>& b) {
  std::vector<double> out(a.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<double>(a[i]) - static_cast<double>(b[i]);
  return out;
}

void fill_row(const PixelSample& sample, const std::vector<double>& mirrored, const std::vector<float>& whole,
              const std::vector<double>& expected, const std::vector<double>& by_half, MirrorRow& row) {
  const std::vector<float> values(mirrored.begin(), mirrored.end());
  const SampledNorms norms = sampled_norms(sample, values, expected);
  row.rel_l2 = norms.norms.rel_l2;
  row.rel_l2_low = norms.rel_l2_low;
  row.rel_l2_high = norms.rel_l2_high;
  double error = 0, own = 0, square = 0, all = 0, sum = 0, expected_sum = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double weight = sample.weight(i / 3);
    error += weight * std::pow(mirrored[i] - expected[i], 2);
    own += weight * std::pow(by_half[i] - expected[i], 2);
    square += weight * expected[i] * expected[i];
    all += weight * std::pow(static_cast<double>(whole[i]), 2);
    sum += weight * mirrored[i];
    expected_sum += weight * expected[i];
  }
  row.own_rel_l2 = square > 0 ? std::sqrt(own / square) : 0;
  row.picture_rel_l2 = all > 0 ? std::sqrt(error / all) : 0;
  row.sum = expected_sum != 0 ? sum / expected_sum : 0;
}

}  // namespace

Result<std::optional<MirrorRow>> measure_mirrored(vk::Device& device, const Scene& scene, const View& view,
                                                  const MirrorOptions& options) {
  FrameSettings settings = options.settings;
  settings.bounce = settings.probes = settings.bodies = true;
  if (!has_probes(scene.compiled.needs, settings)) return std::optional<MirrorRow>();
  FL_ASSIGN(const Drawn drawn, draw_both(device, scene, view, options.settings));
  JudgeScene judge = judge_of(scene, options.settings, device.is_software());
  add_meshes(judge, scene.rig);
  join_display_lights(judge, kDisplayCells);
  const std::vector<std::uint32_t> shiny = shiny_pixels(judge, view, drawn);
  if (shiny.empty()) return std::optional<MirrorRow>();
  // These pixels as a picture of one row, whose strata are those of what they mirror.
  RadianceImage pilot{static_cast<int>(shiny.size()), 1, {}};
  std::vector<float> whole, without;
  for (const std::uint32_t pixel : shiny) {
    for (std::size_t c = 3 * std::size_t{pixel}; c < 3 * std::size_t{pixel} + 3; ++c) {
      whole.push_back(drawn.with.rgb[c]);
      without.push_back(drawn.without.rgb[c]);
      pilot.rgb.push_back(std::abs(drawn.with.rgb[c] - drawn.without.rgb[c]));
    }
  }
  const PixelSample sample = sample_pixels(pilot, options.judge_pixels, kMirrorSeed);
  std::vector<std::uint32_t> pixels;
  for (const std::uint32_t place : sample.pixels) pixels.push_back(shiny[place]);

  MirrorRow row;
  row.pixels = static_cast<std::int64_t>(shiny.size());
  row.judged = static_cast<std::int64_t>(pixels.size());
  const JudgeScene lamps = judge;  // without the light that surfaces reflect, which its paths find
  const PathScene paths = path_scene(lamps);
  judge.bounced_lx = bounced_lx_of(paths, kBounces);
  MirrorJudge rays(std::move(judge), view, options.settings, pixels, options.go_on);
  const std::vector<double> expected = rays.by_rays(kMirrorRays, 0, 2.0 / 3);
  if (expected.empty()) return std::optional<MirrorRow>();
  const std::vector<double> by_half = rays.by_rays(kMirrorRays / 2, 2.0 / 3, 1.0 / 3);
  if (by_half.empty()) return std::optional<MirrorRow>();
  const std::vector<float> with_there = at_sample<float>(sample, whole, 3);
  fill_row(sample, difference(with_there, at_sample<float>(sample, without, 3)), with_there, expected, by_half, row);
  return std::optional<MirrorRow>(row);
}

std::string text_of(const MirrorRow& row, std::int64_t pixels) {
  const std::string interval =
      row.judged < row.pixels ? fmt::format(" ({:.3f} to {:.3f})", row.rel_l2_low, row.rel_l2_high) : "";
  return fmt::format(
      "Mirrored light of shiny surfaces, {:.1f} % of the pixels: rel_l2 {:.3f}{} at {} of them, against {} rays a "
      "place in double, whose own error is {:.3f}. That is {:.3f} of all light there. The sum of the mirrored light is "
      "{:.2f} times that of the rays. Maps of probes {:.3f} ms, reading them {:.3f} ms.\n\n",
      100.0 * static_cast<double>(row.pixels) / static_cast<double>(pixels), row.rel_l2, interval, row.judged,
      kMirrorRays, row.own_rel_l2, row.picture_rel_l2, row.sum, row.probes_ms, row.reflections_ms);
}

std::string json_of(const MirrorRow& row) {
  return fmt::format(R"({{"event":"mirrored","pixels":{},"judged":{},"rays":{},"rel_l2":{:.6g},"rel_l2_low":{:.6g},)"
                     R"("rel_l2_high":{:.6g},"own_rel_l2":{:.6g},"picture_rel_l2":{:.6g},"sum":{:.6g},)"
                     R"("probes_ms":{:.4f},"reflections_ms":{:.4f}}})"
                     "\n",
                     row.pixels, row.judged, kMirrorRays, row.rel_l2, row.rel_l2_low, row.rel_l2_high, row.own_rel_l2,
                     row.picture_rel_l2, row.sum, row.probes_ms, row.reflections_ms);
}

}  // namespace footlight::tools

#include "render/reference/laser_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "fixtures/laser/figure.h"
#include "fixtures/laser/power.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

constexpr double kPixelSigma = 0.6;  // a pixel is a Gaussian
constexpr int kReachPx = 4;          // beyond it is 2e-10
constexpr double kNearM = 1e-3;

// Weights and places, in deviations, of a normal distribution.
std::vector<std::pair<double, double>> normal_nodes(double sigma_px) {
  std::vector<std::pair<double, double>> nodes;
  if (sigma_px < 0.15) {  // Gauss-Hermite
    return {{1.0 / 6, -std::sqrt(3.0)}, {2.0 / 3, 0}, {1.0 / 6, std::sqrt(3.0)}};
  }
  const int count = std::clamp(static_cast<int>(std::ceil(10 * sigma_px / 0.4)), 15, 199);
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const double z = 10.0 * (i + 0.5) / count - 5;
    nodes.emplace_back(std::exp(-z * z / 2), z);
    sum += nodes.back().first;
  }
  for (auto& [weight, z] : nodes) weight /= sum;
  return nodes;
}

class LaserJudge {
 public:
  LaserJudge(const JudgeScene& scene, const View& view, int width, int height, double step_px)
      : scene_(scene),
        view_(view),
        width_(width),
        height_(height),
        step_px_(step_px),
        pixel_(2 * view.tan_half_fov / height),
        rgb_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 0.0) {}

  // Calls go_on with the share of the moves that are done. False: it ended the picture.
  bool add(const JudgeLaser& laser, const std::function<bool(double)>& go_on) {
    for (std::size_t done = 0; done < laser.moves.size(); ++done) {
      const JudgeMove& move = laser.moves[done];
      const int count = pieces_of(laser, move);
      for (int i = 0; i < count; ++i) {
        const auto moves = static_cast<double>(laser.moves.size());
        if (go_on && !go_on((static_cast<double>(done) + static_cast<double>(i) / count) / moves)) return false;
        const glm::dvec2 at = move.from_rad + (move.to_rad - move.from_rad) * ((i + 0.5) / count);
        add_beam(laser, direction(laser, at), laser.flux_lm * move.rgb * (move.share / count));
      }
    }
    return true;
  }
  std::vector<double> take() { return std::move(rgb_); }

 private:
  static glm::dvec3 direction(const JudgeLaser& laser, const glm::dvec2& rad) {
    return std::cos(rad.y) * (std::cos(rad.x) * laser.axis + std::sin(rad.x) * laser.right) +
           std::sin(rad.y) * laser.up;
  }

  // Where the camera sees a place, in pixels; false: behind it.
  bool seen_at(const glm::dvec3& place_m, glm::dvec2& px) const {
    const glm::dvec3 away = place_m - view_.position_m;
    const double depth_m = glm::dot(away, view_.forward);
    if (depth_m < kNearM) return false;
    px = glm::dvec2(width_ / 2.0 + glm::dot(away, view_.right) / (depth_m * pixel_),
                    height_ / 2.0 - glm::dot(away, view_.up) / (depth_m * pixel_));
    return true;
  }

  // Short times of a move, so that the picture of the beam goes less than a step in each.
  [[nodiscard]] int pieces_of(const JudgeLaser& laser, const JudgeMove& move) const {
    const glm::dvec3 a = direction(laser, move.from_rad);
    const glm::dvec3 b = direction(laser, move.to_rad);
    const double end_m = std::max(end_of(laser, a), end_of(laser, b));
    double most_px = 0;
    for (int i = 1; i <= 40; ++i) {
      glm::dvec2 from, to;
      if (!seen_at(laser.lens_m + a * (end_m * i / 40), from) || !seen_at(laser.lens_m + b * (end_m * i / 40), to)) {
        continue;
      }
      most_px = std::max(most_px, std::min(glm::length(to - from), 4.0 * width_));
    }
    return std::max(1, static_cast<int>(std::ceil(most_px / step_px_)));
  }

  [[nodiscard]] double end_of(const JudgeLaser& laser, const glm::dvec3& way) const {
    const auto hit = judge_hit(scene_, {laser.lens_m, way});
    return hit ? std::min(hit->t_m, laser.range_m) : laser.range_m;
  }
  [[nodiscard]] double extinction_per_m() const { return scene_.haze.scattering_per_m + scene_.haze.absorption_per_m; }
  [[nodiscard]] static double sigma_at(const JudgeLaser& laser, double r_m) {
    return std::hypot(laser.sigma_m, laser.slope * r_m);
  }

  void add_beam(const JudgeLaser& laser, const glm::dvec3& way, const glm::dvec3& flux_lm) {
    const glm::dvec3 across =
        glm::normalize(glm::cross(way, std::abs(way.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
    const glm::dvec3 beside = glm::cross(way, across);
    const double end_m = end_of(laser, way);
    if (scene_.haze.scattering_per_m > 0) add_air(laser, way, across, beside, end_m, flux_lm);
    if (end_m < laser.range_m) add_spot(laser, way, across, beside, end_m, flux_lm);
  }

  void add_air(const JudgeLaser& laser, const glm::dvec3& way, const glm::dvec3& across, const glm::dvec3& beside,
               double end_m, const glm::dvec3& flux_lm) {
    for (double r_m = 0; r_m < end_m;) {
      double step_m = 0.02 * std::max(glm::length(laser.lens_m + way * r_m - view_.position_m), 0.05);
      glm::dvec2 from, to;
      for (int i = 0; i < 40 && seen_at(laser.lens_m + way * r_m, from) &&
                      seen_at(laser.lens_m + way * (r_m + step_m), to) && glm::length(to - from) > step_px_;
           ++i) {
        step_m *= std::clamp(0.9 * step_px_ / glm::length(to - from), 0.1, 0.9);
      }
      step_m = std::min(step_m, end_m - r_m);
      const double middle_m = r_m + step_m / 2;
      r_m = end_m - (r_m + step_m) < 1e-9 ? end_m : r_m + step_m;
      const double sigma_m = sigma_at(laser, middle_m);
      const glm::dvec3 place_m = laser.lens_m + way * middle_m;
      const double sigma_px = sigma_m / (pixel_ * std::max(glm::length(place_m - view_.position_m), kNearM));
      if (!near_picture(place_m, sigma_px)) continue;
      const auto nodes = normal_nodes(sigma_px);
      for (const auto& [wx, zx] : nodes) {
        for (const auto& [wy, zy] : nodes) {
          const glm::dvec3 bit_m = place_m + sigma_m * (zx * across + zy * beside);
          const glm::dvec3 away = bit_m - view_.position_m;
          const double t_m = glm::length(away);
          const auto hit = judge_hit(scene_, {view_.position_m, away / t_m});
          if (hit && hit->t_m < t_m) continue;
          const double g = scene_.haze.anisotropy;
          const double cosine = -glm::dot(way, away) / t_m;
          const double phase = (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
          const double light = scene_.haze.scattering_per_m * phase * step_m * wx * wy / (t_m * t_m) *
                               std::exp(-extinction_per_m() * (t_m + middle_m));
          put(bit_m, flux_lm * light);
        }
      }
    }
  }

  void add_spot(const JudgeLaser& laser, const glm::dvec3& way, const glm::dvec3& across, const glm::dvec3& beside,
                double end_m, const glm::dvec3& flux_lm) {
    const glm::dvec3 middle_m = laser.lens_m + way * end_m;
    const double sigma_m = sigma_at(laser, end_m);
    const double sigma_px = 4 * sigma_m / (pixel_ * std::max(glm::length(middle_m - view_.position_m), kNearM));
    const auto nodes = normal_nodes(sigma_px);
    for (const auto& [wx, zx] : nodes) {
      for (const auto& [wy, zy] : nodes) {
        const glm::dvec3 there = way * end_m + sigma_m * (zx * across + zy * beside);
        const glm::dvec3 ray = glm::normalize(there);
        const auto hit = judge_hit(scene_, {laser.lens_m, ray});
        if (!hit) continue;
        const glm::dvec3 bit_m = laser.lens_m + ray * hit->t_m;
        const glm::dvec3 away = bit_m - view_.position_m;
        const double t_m = glm::length(away);
        const auto shown = judge_hit(scene_, {view_.position_m, away / t_m});
        const double facing = -glm::dot(hit->normal, away) / t_m;
        if ((shown && shown->t_m < t_m - 1e-6) || !(facing > 0)) continue;
        const double light =
            wx * wy * facing / (std::numbers::pi * t_m * t_m) * std::exp(-extinction_per_m() * (t_m + hit->t_m));
        put(bit_m, flux_lm * hit->albedo * light);
      }
    }
  }

  [[nodiscard]] bool near_picture(const glm::dvec3& place_m, double sigma_px) const {
    glm::dvec2 px;
    if (!seen_at(place_m, px)) return sigma_px > 1;
    const double margin = kReachPx + 6 * sigma_px * 3;
    return px.x > -margin && px.y > -margin && px.x < width_ + margin && px.y < height_ + margin;
  }

  // light: over the solid angle in which it is seen.
  void put(const glm::dvec3& place_m, const glm::dvec3& light) {
    glm::dvec2 px;
    if (!seen_at(place_m, px)) return;
    const glm::dvec3 away = place_m - view_.position_m;
    const double cosine = glm::dot(away, view_.forward) / glm::length(away);
    const double solid_angle = pixel_ * pixel_ * cosine * cosine * cosine;
    const int x0 = std::max(static_cast<int>(std::floor(px.x)) - kReachPx, 0);
    const int y0 = std::max(static_cast<int>(std::floor(px.y)) - kReachPx, 0);
    const int x1 = std::min(static_cast<int>(std::floor(px.x)) + kReachPx, width_ - 1);
    const int y1 = std::min(static_cast<int>(std::floor(px.y)) + kReachPx, height_ - 1);
    std::array<double, 2 * kReachPx + 1> across{};
    constexpr double kSquare = 2 * kPixelSigma * kPixelSigma;
    for (int x = x0; x <= x1; ++x) {
      const double away_px = x + 0.5 - px.x;
      across[static_cast<std::size_t>(x - x0)] = std::exp(-away_px * away_px / kSquare);
    }
    const glm::dvec3 scaled = light / (solid_angle * std::numbers::pi * kSquare);
    for (int y = y0; y <= y1; ++y) {
      const double away_px = y + 0.5 - px.y;
      const double down = std::exp(-away_px * away_px / kSquare);
      for (int x = x0; x <= x1; ++x) {
        const double weight = down * across[static_cast<std::size_t>(x - x0)];
        const auto at =
            3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
        for (int c = 0; c < 3; ++c) rgb_[at + static_cast<std::size_t>(c)] += scaled[c] * weight;
      }
    }
  }

  const JudgeScene& scene_;
  const View& view_;
  int width_, height_;
  double step_px_;
  double pixel_;  // at a depth of 1
  std::vector<double> rgb_;
};

// The frame of a figure whose row is at a place in the table of defaults; null: there is none.
const fixtures::LaserFrame* frame_at(const fixtures::CompiledRig& compiled, std::uint32_t laser,
                                     const std::vector<const fixtures::LaserFigure*>& figures, std::uint32_t row) {
  for (std::size_t f = 0; f < figures.size(); ++f) {
    const std::size_t figure = laser + fixtures::kLaserFigureRows + fixtures::kLaserFigureSize * f;
    const auto first = static_cast<std::uint32_t>(compiled.defaults[figure + fixtures::kFigureFrame]);
    const std::uint32_t number = (row - first) / fixtures::kLaserFrameSize;
    if (row >= first && number < figures[f]->frames.size()) return &figures[f]->frames[number];
  }
  return nullptr;
}

// The moves of a frame of which an exposure sees the part from `begun` on, `passes` of it.
std::vector<JudgeMove> moves_of(const fixtures::LaserFrame& frame, double begun, double passes,
                                const std::function<glm::dvec2(const glm::dvec2&)>& angles_of) {
  std::vector<JudgeMove> moves;
  const auto count = static_cast<double>(frame.size());
  const bool whole = passes < 0 || passes >= 0.999999;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const glm::dvec2 from = frame[i == 0 ? frame.size() - 1 : i - 1].at;
    const glm::dvec2 way = frame[i].at - from;
    const double begin = static_cast<double>(i) / count;
    if (passes == 0) {  // the scanner stands still
      const double there = (begun - begin) * count;
      const glm::dvec2 at = angles_of(from + way * there);
      if (there >= 0 && there < 1) moves.push_back({at, at, 1, frame[i].rgb});
      continue;
    }
    for (int turn = 0; turn < (whole ? 1 : 2); ++turn) {
      const double low = whole ? begin : std::max(begin, begun - turn);
      const double high = whole ? begin + 1 / count : std::min(begin + 1 / count, begun - turn + passes);
      if (!(high > low)) continue;
      moves.push_back({angles_of(from + way * ((low - begin) * count)),
                       angles_of(from + way * ((high - begin) * count)), (high - low) / (whole ? 1 : passes),
                       frame[i].rgb});
    }
  }
  return moves;
}

}  // namespace

Result<std::vector<JudgeLaser>> judged_lasers(const fixtures::Rig& rig, fixtures::f64::Walker& walker, double range_m) {
  std::vector<JudgeLaser> judged;
  const fixtures::CompiledRig& compiled = walker.rig;
  for (std::size_t head = 0; head < compiled.heads.size(); ++head) {
    const fixtures::HeadRow& row = compiled.heads[head];
    if (row.laser == fixtures::kNoAddress) continue;
    const fixtures::PatchedFixture& fixture = rig.fixtures[row.fixture];
    const fixtures::FixtureType& type = fixtures::type_of(rig, fixture);
    const auto geometry = static_cast<std::size_t>(compiled.sources[row.type].geometry);
    const auto& laser =
        type.lasers[static_cast<std::size_t>(fixtures::mode_of(rig, fixture).geometries[geometry].laser)];
    FL_ASSIGN(const auto figures, fixtures::figures_of(laser));
    const auto& state = walker.laser_states[row.laser];
    const fixtures::LaserFrame* const frame = frame_at(compiled, compiled.types[row.type].laser, figures, state.frame);
    if (frame == nullptr) continue;
    const auto pose = walker.pose(head);
    JudgeLaser one;
    one.lens_m = pose.lens_m;
    one.right = pose.x_axis;
    one.up = -pose.y_axis;
    one.axis = pose.axis;
    one.sigma_m = (state.thickness_m > 0 ? state.thickness_m : laser.diameter_m) / 4;
    one.slope = laser.divergence_mrad * 1e-3 / 4;
    one.range_m = state.length_m > 0 ? std::min(state.length_m, range_m) : range_m;
    const auto& light = walker.states[head];
    one.flux_lm = glm::dvec3(light.red, light.green, light.blue) * fixtures::laser_flux_lm(laser);
    const glm::dvec2 half_rad = glm::radians(glm::dvec2(laser.scan_pan_deg, laser.scan_tilt_deg) / 2.0);
    const auto angles_of = [&](const glm::dvec2& place) {
      const glm::dvec2 at = place * glm::dvec2(state.size_x, state.size_y) * half_rad;
      const double c = std::cos(state.angle), s = std::sin(state.angle);
      const glm::dvec2 turned(c * at.x - s * at.y, s * at.x + c * at.y);
      return glm::clamp(turned + glm::dvec2(state.x, state.y) * half_rad, -half_rad, half_rad);
    };
    one.moves = moves_of(*frame, static_cast<double>(footlight::f64::turns_real(state.begun)), state.passes, angles_of);
    judged.push_back(std::move(one));
  }
  return judged;
}

std::vector<double> judge_lasers(const JudgeScene& scene, const std::vector<JudgeLaser>& lasers, const View& view,
                                 int width, int height, double step_px, const std::function<bool(double done)>& go_on) {
  LaserJudge judge(scene, view, width, height, step_px);
  for (std::size_t i = 0; i < lasers.size(); ++i) {
    const auto share = [&](double done) {
      return !go_on || go_on((static_cast<double>(i) + done) / static_cast<double>(lasers.size()));
    };
    if (!judge.add(lasers[i], share)) return {};
  }
  return judge.take();
}

}  // namespace footlight::render

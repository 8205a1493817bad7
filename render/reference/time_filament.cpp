// A tungsten filament under jumps, fades and chases, compared with textbook integrators and two libraries.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "render/reference/time_bench.h"
#include "render/reference/time_judges.h"
#include "render/reference/time_solvers.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

constexpr double kRatedK = 3200;
constexpr int kSeriesDegree = 20;  // of the judge's series
constexpr int kFineDegree = 28;
constexpr Wide kTolerance = 1e-17L;
constexpr Wide kFineTolerance = 1e-19L;

// The law of sim/shared/lamp.h.
FilamentLaw filament_law(double tau_s) {
  FilamentLaw law{
      .p = f64::kFilamentP, .r = f64::kFilamentR, .q = f64::kFilamentQ, .ambient = f64::kFilamentAmbientK / kRatedK};
  law.rate_per_s = 1 / (tau_s * (law.p + law.r));
  return law;
}

double light_of(double y) {
  const double kelvin = std::max(y, 1e-3) * kRatedK;
  return 1 / std::expm1(25'924 / kelvin);  // second radiation constant over 555 nm
}

// Limits a step to the ambient temperature, because powers of y need y > 0. This favours the methods that are compared.
double kept(const FilamentLaw& law, double y) { return std::max(y, law.ambient); }

double explicit_euler(const FilamentLaw& law, double y, double v, double h) {
  return kept(law, y + h * law.slope(y, v));
}
double rk4(const FilamentLaw& law, double y, double v, double h) {
  const double a = law.slope(y, v);
  const double b = law.slope(kept(law, y + h * a / 2), v);
  const double c = law.slope(kept(law, y + h * b / 2), v);
  const double d = law.slope(kept(law, y + h * c), v);
  return kept(law, y + h * (a + 2 * b + 2 * c + d) / 6);
}
double implicit_euler(const FilamentLaw& law, double y, double v, double h) {
  double next = y;
  for (int i = 0; i < 4; ++i) {  // Newton
    next = kept(law, next - (next - y - h * law.slope(next, v)) / (1 - h * law.slope_by_y(next, v)));
  }
  return next;
}
// Solves the linear part exactly, with the exponential of the derivative.
double exponential_rosenbrock(const FilamentLaw& law, double y, double v, double h) {
  const double z = h * law.slope_by_y(y, v);
  const double gain = std::abs(z) < 1e-8 ? 1 : std::expm1(z) / z;
  return kept(law, y + h * gain * law.slope(y, v));
}
// Two stages, L-stable for this gamma.
double ros2(const FilamentLaw& law, double y, double v, double h) {
  constexpr double kGamma = 1 - std::numbers::sqrt2 / 2;
  const double w = 1 / (1 - kGamma * h * law.slope_by_y(y, v));
  const double k1 = w * law.slope(y, v);
  const double k2 = w * (law.slope(kept(law, y + h * k1), v) - 2 * k1);
  return kept(law, y + h * (1.5 * k1 + 0.5 * k2));
}
// The trapezoidal rule to gamma h, then the backward difference formula of order two; three Newton steps each.
double tr_bdf2(const FilamentLaw& law, double y, double v, double h) {
  constexpr double kGamma = 2 - std::numbers::sqrt2;
  constexpr double kOld = (1 - kGamma) * (1 - kGamma) / (kGamma * (2 - kGamma));
  constexpr double kMiddle = 1 / (kGamma * (2 - kGamma));
  constexpr double kSlope = (1 - kGamma) / (2 - kGamma);
  const double slope = law.slope(y, v);
  double middle = y;
  for (int i = 0; i < 3; ++i) {
    const double miss = middle - y - kGamma * h / 2 * (slope + law.slope(middle, v));
    middle = kept(law, middle - miss / (1 - kGamma * h / 2 * law.slope_by_y(middle, v)));
  }
  double next = middle;
  for (int i = 0; i < 3; ++i) {
    const double miss = next - kMiddle * middle + kOld * y - kSlope * h * law.slope(next, v);
    next = kept(law, next - miss / (1 - kSlope * h * law.slope_by_y(next, v)));
  }
  return next;
}

std::vector<double> judged(const FilamentLaw& law, const Frames& show, int degree, Wide tolerance) {
  std::vector<double> values;
  Wide y = law.ambient;
  for (std::size_t i = 0; i < show.size(); ++i) {
    y = filament_judged(law, y, show.input[i], show.dt_s[i], degree, tolerance);
    values.push_back(static_cast<double>(y));
  }
  return values;
}

void add_filament_scene(const TimeReportOptions& options, std::span<const double> levels, double tau_ms, double fps,
                        TimeReport& report, JudgeError& own) {
  const Frames show = frames_of(options.seconds, fps, levels);
  const FilamentLaw law = filament_law(tau_ms * 1e-3);
  TimeScene scene{.model = "filament",
                  .unit = "K",
                  .tau_ms = tau_ms,
                  .fps = fps,
                  .seconds = options.seconds,
                  .judge = judged(law, show, kSeriesDegree, kTolerance),
                  .unit_scale = kRatedK};
  scene.seen = light_of;
  scene.miss = [](double value, double judge) { return light_of(value) - light_of(judge); };
  const std::vector<double> fine = judged(law, show, kFineDegree, kFineTolerance);
  double before = law.ambient;
  for (std::size_t i = 0; i < show.size(); ++i) {
    own.own = std::max(own.own, kRatedK * std::abs(fine[i] - scene.judge[i]));
    own.difference = std::max(
        own.difference, kRatedK * filament_flight_error(law, before, show.input[i], show.dt_s[i], scene.judge[i]));
    before = scene.judge[i];
  }
  TimeBench bench(options, report.rows);
  bench.add(scene, "universal curve f32", 1, [&] {
    const f32::FilamentType type{static_cast<float>(kRatedK), static_cast<float>(tau_ms * 1e-3)};
    return [&, type, filament = f32::filament_start(0)](std::size_t i) mutable {
      f32::filament_move(filament, type, static_cast<float>(show.input[i]), dt_of(show, i));
      return static_cast<double>(filament.kelvin) * (1 / kRatedK);
    };
  });
  bench.add(scene, "universal curve f64", 1, [&] {
    const f64::FilamentType type{kRatedK, tau_ms * 1e-3};
    return [&, type, filament = f64::filament_start(0)](std::size_t i) mutable {
      f64::filament_move(filament, type, show.input[i], dt_of(show, i));
      return filament.kelvin * (1 / kRatedK);
    };
  });

  using Method = double (*)(const FilamentLaw&, double, double, double);
  const std::pair<const char*, Method> rivals[] = {{"explicit Euler", explicit_euler},
                                                   {"RK4", rk4},
                                                   {"implicit Euler", implicit_euler},
                                                   {"exp. Rosenbrock-Euler", exponential_rosenbrock},
                                                   {"ROS2", ros2},
                                                   {"TR-BDF2", tr_bdf2}};
  for (const auto& [name, method] : rivals) {
    for (const int substeps : options.substeps) {
      bench.add(scene, name, substeps, [&, m = method] {
        return [&, m, y = law.ambient](std::size_t i) mutable {
          const double h = show.dt_s[i] / substeps;
          for (int s = 0; s < substeps; ++s) y = m(law, y, show.input[i], h);
          return y;
        };
      });
    }
  }
  for (const double tolerance : options.tolerances) {
    bench.add(scene, "Odeint Rosenbrock-4", tolerance, [&] {
      return [&, solver = FilamentRosenbrock4(law, tolerance), y = law.ambient](std::size_t i) mutable {
        return y = kept(law, solver.step(y, show.input[i], show.dt_s[i]));
      };
    });
    if (!has_cvode()) continue;
    bench.add(scene, "CVODE BDF", tolerance, [&] {
      return [&, solver = FilamentCvode(law, tolerance), y = law.ambient](std::size_t i) mutable {
        return y = kept(law, solver.step(y, show.input[i], show.dt_s[i]));
      };
    });
  }
}

}  // namespace

void report_filament(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> levels = flashes_of(options.seconds, options.seed);
  JudgeError own{.model = "filament",
                 .judge = "Taylor series of degree 20 to 1e-17, against degree 28 to 1e-19",
                 .second = "the time between temperatures by Gauss-Kronrod quadrature",
                 .unit = "K"};
  for (const double tau_ms : options.tau_ms) {
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      add_filament_scene(options, levels, tau_ms, fps, report, own);
    }
  }
  report.judges.push_back(own);
}

}  // namespace footlight::render

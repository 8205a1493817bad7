// Libraries that solve the filament's equation. Each is seen by one file only.
#pragma once

#include <memory>

#include "render/reference/time_judges.h"

namespace footlight::render {

// Boost.Odeint's Rosenbrock method of order 4 with its own step control, absolute and relative tolerance the same. The
// step is remembered from frame to frame.
class FilamentRosenbrock4 {
 public:
  FilamentRosenbrock4(const FilamentLaw& law, double tolerance);
  // y after dt_s at v; NaN where the library gives up.
  [[nodiscard]] double step(double y, double v, double dt_s);

 private:
  struct Solver;
  std::shared_ptr<Solver> solver_;
};

// SUNDIALS' CVODE: backward difference formulas of variable order with the exact slope, begun anew each frame, since
// the voltage jumps. Relative tolerance as given, absolute a hundredth of it. In builds with it only: has_cvode().
class FilamentCvode {
 public:
  FilamentCvode(const FilamentLaw& law, double tolerance);
  [[nodiscard]] double step(double y, double v, double dt_s);

 private:
  struct Solver;
  std::shared_ptr<Solver> solver_;
};

}  // namespace footlight::render

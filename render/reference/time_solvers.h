// Libraries that solve the filament's equation. Each is included by only one file.
#pragma once

#include <memory>

#include "render/reference/time_judges.h"

namespace footlight::render {

// Boost.Odeint's Rosenbrock method of order 4 with its own step control and equal absolute and relative tolerances. It
// keeps the step size from frame to frame.
class FilamentRosenbrock4 {
 public:
  FilamentRosenbrock4(const FilamentLaw& law, double tolerance);
  // Returns y after dt_s at v; NaN if the library fails.
  [[nodiscard]] double step(double y, double v, double dt_s);

 private:
  struct Solver;
  std::shared_ptr<Solver> solver_;
};

// CVODE of SUNDIALS: backward difference formulas of variable order with the exact derivative. It restarts each frame,
// because the voltage jumps. The relative tolerance is `tolerance`, the absolute one a hundredth of it. Without CVODE
// (has_cvode()) it returns NaN.
class FilamentCvode {
 public:
  FilamentCvode(const FilamentLaw& law, double tolerance);
  [[nodiscard]] double step(double y, double v, double dt_s);

 private:
  struct Solver;
  std::shared_ptr<Solver> solver_;
};

}  // namespace footlight::render

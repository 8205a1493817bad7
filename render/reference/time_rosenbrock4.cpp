// By default uBLAS checks every access, which would make this method six times as slow.
#ifndef BOOST_UBLAS_NDEBUG
#define BOOST_UBLAS_NDEBUG
#endif
#include "render/reference/time_solvers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <boost/numeric/odeint/stepper/rosenbrock4.hpp>
#include <boost/numeric/odeint/stepper/rosenbrock4_controller.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>

namespace footlight::render {
namespace {

namespace odeint = boost::numeric::odeint;
using Vector = boost::numeric::ublas::vector<double>;
using Matrix = boost::numeric::ublas::matrix<double>;

constexpr int kStepsMax = 100'000;

}  // namespace

struct FilamentRosenbrock4::Solver {
  FilamentLaw law;
  double h_s;  // the next step of the controller
  Vector y;
  odeint::rosenbrock4_controller<odeint::rosenbrock4<double>> stepper;
};

FilamentRosenbrock4::FilamentRosenbrock4(const FilamentLaw& law, double tolerance)
    : solver_(std::make_shared<Solver>(Solver{law, 1e-5, Vector(1), {tolerance, tolerance}})) {}

double FilamentRosenbrock4::step(double y, double v, double dt_s) {
  Solver& s = *solver_;
  const double floor = 0.3 * s.law.ambient;  // avoids powers of negative numbers
  const auto slope = [&](const Vector& at, Vector& out, double) { out[0] = s.law.slope(std::max(at[0], floor), v); };
  const auto slope_by_y = [&](const Vector& at, Matrix& out, double, Vector& by_time) {
    out(0, 0) = s.law.slope_by_y(std::max(at[0], floor), v);
    by_time[0] = 0;
  };
  const auto system = std::make_pair(slope, slope_by_y);
  s.y[0] = y;
  double t_s = 0;
  for (int steps = 0; steps < kStepsMax; ++steps) {
    const bool last = t_s + s.h_s >= dt_s;
    double h_s = last ? dt_s - t_s : s.h_s;
    const bool taken = s.stepper.try_step(system, s.y, t_s, h_s) == odeint::success;
    if (!std::isfinite(s.y[0]) || !(h_s > 0)) break;
    s.h_s = h_s;
    if (taken && last) return s.y[0];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace footlight::render

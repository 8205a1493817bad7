// The judges of time behaviour. Each is computed from the definition of its model, in long double or in integers, by a
// method that shares nothing with the closed forms in sim/shared/. The error of each judge is measured against a second
// judge or a second resolution.
#pragma once

#include <cstdint>
#include <vector>

#include "render/reference/wide.h"

namespace footlight::render {

// ---- A tungsten filament ----

// y = T / T_rated follows y' = rate (v^2 y^-r - y^p) y^-q at v volts (rated: 1), and never falls below `ambient`.
struct FilamentLaw {
  double rate_per_s = 0;  // rated power over heat capacity and temperature
  double p = 0;           // radiated power ~ y^p
  double r = 0;           // resistance ~ y^r
  double q = 0;           // heat capacity ~ y^q
  double ambient = 0;     // in y

  // y' in double and its derivative by y, for the methods that are compared.
  [[nodiscard]] double slope(double y, double v) const;
  [[nodiscard]] double slope_by_y(double y, double v) const;
};

// Returns y after dt_s, by Taylor series of y(t) in steps at which the last two terms are below tolerance times y.
[[nodiscard]] Wide filament_judged(const FilamentLaw& law, Wide y, Wide v, Wide dt_s, int degree, Wide tolerance);

// Returns the error of y1 as the temperature dt_s after y0, in y. It computes the time from y0 to y1 by Gauss-Kronrod
// quadrature of 1 / y' in double.
[[nodiscard]] double filament_flight_error(const FilamentLaw& law, double y0, double v, double dt_s, double y1);

// ---- A motor axis ----

// Follows the time-optimal control law from event to event. It accelerates towards the target while braking now would
// stop short of it, coasts at the speed limit, and brakes when braking now would stop on the target. Each event is
// found by bisection of time down to resolution_s.
class AxisJudge {
 public:
  AxisJudge(double start, double speed_max, double acceleration_max, double resolution_s);

  [[nodiscard]] double position() const { return static_cast<double>(x_); }
  void advance(double target, Wide dt_s);

 private:
  enum class Mode { kPush, kCoast, kBrake, kRest };

  [[nodiscard]] Wide stop_at(Wide x, Wide v) const;
  [[nodiscard]] bool happened(Wide x, Wide v) const;
  [[nodiscard]] Wide first(Wide left_s, Wide a) const;

  Wide x_;
  Wide v_ = 0;
  Wide target_;
  Wide v_max_;
  Wide a_max_;
  Wide resolution_s_;
  Wide side_ = 1;
  Mode mode_ = Mode::kRest;
};

// ---- Phases and flashes ----

// Returns the turns after ns nanoseconds at rate_hz, modulo 1: exact in 128-bit integers, then rounded once. rate_hz: a
// float from 2^-20 to 2^20; ns: 0 to 2^53.
[[nodiscard]] Wide turns_judged(float rate_hz, std::int64_t ns);
// The same in long double.
[[nodiscard]] Wide turns_judged_wide(float rate_hz, std::int64_t ns);

// Returns the share of from_ns..to_ns inside the flashes [i / hz, (i + duty) / hz]: the sum of the overlaps, in long
// double.
[[nodiscard]] double open_share_judged(float hz, double duty, std::int64_t from_ns, std::int64_t to_ns);
// The same from the open time up to each end, in 128-bit integers; duty in 1/65536.
[[nodiscard]] double open_share_judged_exactly(float hz, int duty_65536, std::int64_t from_ns, std::int64_t to_ns);

// ---- The air of a room ----

// A period of constant output of the machines and constant mixing with the room.
struct AirStretch {
  double inflow_per_m_s = 0;
  double mixing_hz = 0;
  std::uint64_t dt_ns = 0;
};
struct AirJudged {
  Wide scattering_per_m = 0;  // the part that has mixed and not been lost
  Wide total_per_m = 0;       // the part that has not been lost
};
// Returns the air after these periods, from clear air at the start. It integrates the probability that a droplet is
// still in the air and mixed, over the time of its release, by 8 Gauss nodes on panels that grow by half from the end
// of each period backwards. It shares nothing with the two relaxations of sim/shared/haze.h.
[[nodiscard]] AirJudged air_judged(const std::vector<AirStretch>& stretches, double tau_s);

// ---- Linear systems of two states ----

// x' = v, v' = -stiffness (x - u) - damping v with constant u. The matrix exponential by its Taylor series in long
// double: the step is halved until its norm is below 2^-halve_until, and the result is squared.
struct SpringJudge {
  Wide stiffness = 0;  // 1/s^2
  Wide damping = 0;    // 1/s
  Wide x = 0;
  Wide v = 0;
  int halve_until = 1;

  void advance(Wide u, Wide dt_s);
};

}  // namespace footlight::render

// The judges of time behaviour: each from the definition of its model, in long double or in integers, by a method that
// shares nothing with the closed forms in sim/shared/. Each has a second judge, or a second resolution, that says how
// wrong the first one is.
#pragma once

#include <cstdint>
#include <vector>

namespace footlight::render {

using Wide = long double;

// ---- A tungsten filament ----

// y = T / T_rated follows y' = rate (v^2 y^-r - y^p) y^-q at v volts of 1 rated, and never falls below `ambient`.
struct FilamentLaw {
  double rate_per_s = 0;  // rated power over heat capacity and temperature
  double p = 0;           // radiated power ~ y^p
  double r = 0;           // resistance ~ y^r
  double q = 0;           // heat capacity ~ y^q
  double ambient = 0;     // in y

  // y' in double, for the rivals, and its derivative by y.
  [[nodiscard]] double slope(double y, double v) const;
  [[nodiscard]] double slope_by_y(double y, double v) const;
};

// y after dt_s by Taylor series of y(t), in steps at which the last two terms are below tolerance times y.
[[nodiscard]] Wide filament_judged(const FilamentLaw& law, Wide y, Wide v, Wide dt_s, int degree, Wide tolerance);

// How far y1 is from where the filament is dt_s after y0, by the time that the way takes: Gauss-Kronrod quadrature of
// 1 / y' in double. In y.
[[nodiscard]] double filament_flight_error(const FilamentLaw& law, double y0, double v, double dt_s, double y1);

// ---- A motor axis ----

// Follows the time-optimal control law event by event: push towards the target while braking now would stop short of
// it, coast at the speed limit, brake from where braking now would stop on it. Each event is found by halving an
// interval of time down to resolution_s.
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

// Turns after ns nanoseconds at rate_hz, modulo 1: exactly, in 128-bit integers, then rounded once. rate_hz: a float
// from 2^-20 to 2^20; ns: 0 to 2^53.
[[nodiscard]] Wide turns_judged(float rate_hz, std::int64_t ns);
// The same in long double.
[[nodiscard]] Wide turns_judged_wide(float rate_hz, std::int64_t ns);

// Share of from_ns..to_ns that lies in the flashes [i / hz, (i + duty) / hz]: the sum of the overlaps, in long double.
[[nodiscard]] double open_share_judged(float hz, double duty, std::int64_t from_ns, std::int64_t to_ns);
// The same from the open time up to either end, in 128-bit integers; duty in 1/65536.
[[nodiscard]] double open_share_judged_exactly(float hz, int duty_65536, std::int64_t from_ns, std::int64_t to_ns);

// ---- The air of a room ----

// What came out of machines for a time, and how quickly it mixed with the room.
struct AirStretch {
  double inflow_per_m_s = 0;
  double mixing_hz = 0;
  std::uint64_t dt_ns = 0;
};
struct AirJudged {
  Wide scattering_per_m = 0;  // of what has mixed and not been lost
  Wide total_per_m = 0;       // of what has not been lost
};
// After these stretches, from clear air: of every droplet the chance that it is still there and mixed, integrated over
// when it came out, by Gauss's 8 nodes on panels that grow by half from the end of each stretch backwards. Shares
// nothing with the two relaxations of sim/shared/haze.h.
[[nodiscard]] AirJudged air_judged(const std::vector<AirStretch>& stretches, double tau_s);

// ---- Linear systems of two states ----

// x' = v, v' = -stiffness (x - u) - damping v with u held. The matrix exponential by its Taylor series in long double,
// after halving the step until its norm is below 2^-halve_until, then squaring.
struct SpringJudge {
  Wide stiffness = 0;  // 1/s^2
  Wide damping = 0;    // 1/s
  Wide x = 0;
  Wide v = 0;
  int halve_until = 1;

  void advance(Wide u, Wide dt_s);
};

}  // namespace footlight::render

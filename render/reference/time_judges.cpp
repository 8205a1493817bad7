#include "render/reference/time_judges.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <boost/math/quadrature/gauss_kronrod.hpp>

namespace footlight::render {
namespace {

constexpr int kDegreeMax = 40;

// Series coefficient k of y^alpha from those of y: w = y^alpha satisfies w' y = alpha w y'.
Wide power_term(const std::array<Wide, kDegreeMax + 1>& y, const std::array<Wide, kDegreeMax + 1>& w, Wide alpha,
                int k) {
  Wide sum = 0;
  for (int j = 1; j <= k; ++j) {
    sum += (alpha * j - (k - j)) * y[static_cast<std::size_t>(j)] * w[static_cast<std::size_t>(k - j)];
  }
  return sum / (k * y[0]);
}

// rate_hz = mantissa / 2^shift, exactly.
struct Rational {
  __int128 mantissa = 0;
  int shift = 0;
};
Rational rational_of(float rate_hz) {
  int exponent = 0;
  const float mantissa = std::frexp(rate_hz, &exponent);  // 24 bits
  return {static_cast<__int128>(std::ldexp(mantissa, 24)), 24 - exponent};
}

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

// Turns in units of 1 / (2^shift 1e9); per_turn units are one turn.
struct ExactTurns {
  __int128 count = 0;
  __int128 per_turn = 1;
};
ExactTurns exact_turns(float rate_hz, std::int64_t ns) {
  const Rational rate = rational_of(rate_hz);
  ExactTurns turns{rate.mantissa * ns, kNsPerSecond};
  if (rate.shift >= 0)
    turns.per_turn <<= rate.shift;
  else
    turns.count <<= -rate.shift;
  return turns;
}

}  // namespace

double FilamentLaw::slope(double y, double v) const {
  return rate_per_s * (v * v * std::pow(y, -r) - std::pow(y, p)) * std::pow(y, -q);
}

double FilamentLaw::slope_by_y(double y, double v) const {
  return rate_per_s * (-(r + q) * v * v * std::pow(y, -r - q - 1) - (p - q) * std::pow(y, p - q - 1));
}

Wide filament_judged(const FilamentLaw& law, Wide y, Wide v, Wide dt_s, int degree, Wide tolerance) {
  const Wide heat_power = -Wide(law.r) - Wide(law.q);
  const Wide cool_power = Wide(law.p) - Wide(law.q);
  std::array<Wide, kDegreeMax + 1> c{}, heat{}, cool{};
  for (Wide left_s = dt_s; left_s > 0;) {
    c[0] = y;
    heat[0] = std::pow(y, heat_power);
    cool[0] = std::pow(y, cool_power);
    for (int k = 0; k < degree; ++k) {
      const auto i = static_cast<std::size_t>(k);
      if (k > 0) {
        heat[i] = power_term(c, heat, heat_power, k);
        cool[i] = power_term(c, cool, cool_power, k);
      }
      c[i + 1] = Wide(law.rate_per_s) * (v * v * heat[i] - cool[i]) / (k + 1);
    }
    Wide h = left_s;
    for (const int k : {degree - 1, degree}) {
      const Wide term = std::fabs(c[static_cast<std::size_t>(k)]);
      if (term > 0) h = std::min(h, std::pow(tolerance * y / term, Wide(1) / k));
    }
    Wide sum = 0;
    for (int k = degree; k >= 0; --k) sum = sum * h + c[static_cast<std::size_t>(k)];
    y = sum;
    left_s = h < left_s ? left_s - h : 0;
  }
  return std::max(y, Wide(law.ambient));
}

double filament_flight_error(const FilamentLaw& law, double y0, double v, double dt_s, double y1) {
  const double m = law.p + law.r;
  const double rest = std::pow(v, 2 / m);  // steady state
  const bool at_ambient = y1 <= law.ambient;
  if (v > 0 && rest >= law.ambient && std::abs(y0 - rest) < 1e-13) return std::abs(y1 - rest);
  double flight_s = 0;
  double slope = law.slope(y1, v);
  if (rest < 1e-3) {
    // Cooling: the time is an integral over y.
    const auto seconds_by_y = [&](double y) { return -1 / law.slope(y, v); };
    flight_s =
        y0 > y1 ? boost::math::quadrature::gauss_kronrod<double, 15>::integrate(seconds_by_y, y1, y0, 8, 1e-13) : 0;
  } else {
    // Integrates over u = log |y - rest|, in which the integrand is smooth up to the steady state.
    const double side = y0 > rest ? 1 : -1;
    const double u0 = std::log(std::abs(y0 - rest));
    const double miss = std::abs(y1 - rest);
    if (miss < 1e-12) return miss;  // at the steady state: the rest bounds the error
    const auto seconds_by_u = [&](double u) {
      const double away = std::exp(u);
      const double y = rest + side * away;
      const double pull = std::abs(std::expm1(m * std::log1p(side * away / rest)));
      return away / (law.rate_per_s * std::pow(y, -law.r - law.q) * std::pow(rest, m) * pull);
    };
    flight_s =
        boost::math::quadrature::gauss_kronrod<double, 15>::integrate(seconds_by_u, std::log(miss), u0, 8, 1e-13);
  }
  if (at_ambient) return flight_s <= dt_s || y0 <= law.ambient ? 0 : (flight_s - dt_s) * std::abs(slope);
  return std::abs(flight_s - dt_s) * std::abs(slope);
}

AxisJudge::AxisJudge(double start, double speed_max, double acceleration_max, double resolution_s)
    : x_(start), target_(start), v_max_(speed_max), a_max_(acceleration_max), resolution_s_(resolution_s) {}

void AxisJudge::advance(double target, Wide dt_s) {
  if (Wide(target) != target_) {
    target_ = target;
    mode_ = Mode::kPush;
    side_ = stop_at(x_, v_) <= target_ ? 1 : -1;
  }
  Wide left_s = dt_s;
  while (left_s > 0 && mode_ != Mode::kRest) {
    const Wide a = mode_ == Mode::kPush ? side_ * a_max_ : mode_ == Mode::kCoast ? Wide(0) : -side_ * a_max_;
    const Wide event_s = first(left_s, a);
    x_ += (v_ + a * event_s / 2) * event_s;
    v_ += a * event_s;
    if (!happened(x_, v_)) break;  // the step ended first
    left_s -= event_s;
    if (mode_ == Mode::kBrake) {
      mode_ = Mode::kRest;
      v_ = 0;
    } else if (side_ * (stop_at(x_, v_) - target_) >= 0) {
      mode_ = Mode::kBrake;
    } else {
      mode_ = Mode::kCoast;
      v_ = side_ * v_max_;
    }
  }
}

Wide AxisJudge::stop_at(Wide x, Wide v) const { return x + v * std::fabs(v) / (2 * a_max_); }

// True if the mode has ended in this state. Once true, it stays true under the mode's own acceleration.
bool AxisJudge::happened(Wide x, Wide v) const {
  switch (mode_) {
    case Mode::kPush: return side_ * v >= v_max_ || side_ * (stop_at(x, v) - target_) >= 0;
    case Mode::kCoast: return side_ * (stop_at(x, v) - target_) >= 0;
    case Mode::kBrake: return side_ * v <= 0;
    case Mode::kRest: break;
  }
  return false;
}

// The first time in 0..left_s at which the mode has ended, or left_s.
Wide AxisJudge::first(Wide left_s, Wide a) const {
  const auto over = [&](Wide t) { return happened(x_ + (v_ + a * t / 2) * t, v_ + a * t); };
  if (over(0)) return 0;
  if (!over(left_s)) return left_s;
  Wide no = 0;
  Wide yes = left_s;
  while (yes - no > resolution_s_) {
    const Wide middle = (no + yes) / 2;
    if (!(middle > no && middle < yes)) break;
    (over(middle) ? yes : no) = middle;
  }
  return yes;
}

Wide turns_judged(float rate_hz, std::int64_t ns) {
  const ExactTurns turns = exact_turns(rate_hz, ns);
  return static_cast<Wide>(turns.count % turns.per_turn) / static_cast<Wide>(turns.per_turn);
}

Wide turns_judged_wide(float rate_hz, std::int64_t ns) {
  const Wide turns = Wide(rate_hz) * Wide(ns) / Wide(kNsPerSecond);
  return turns - std::floor(turns);
}

double open_share_judged(float hz, double duty, std::int64_t from_ns, std::int64_t to_ns) {
  const Wide from_s = Wide(from_ns) * 1e-9L;
  const Wide to_s = Wide(to_ns) * 1e-9L;
  Wide open_s = 0;
  for (Wide i = std::floor(from_s * Wide(hz)) - 1; i / Wide(hz) < to_s; i += 1) {
    const Wide on = std::max(i / Wide(hz), from_s);
    const Wide off = std::min((i + Wide(duty)) / Wide(hz), to_s);
    if (off > on) open_s += off - on;
  }
  return static_cast<double>(open_s / (to_s - from_s));
}

double open_share_judged_exactly(float hz, int duty_65536, std::int64_t from_ns, std::int64_t to_ns) {
  // Open time up to an end, in units of 1 / (per_turn 65536).
  const auto open_up_to = [&](const ExactTurns& turns) {
    const __int128 whole = turns.count / turns.per_turn;
    const __int128 part = (turns.count % turns.per_turn) * 65536;
    const __int128 duty = turns.per_turn * duty_65536;
    return whole * duty + std::min(part, duty);
  };
  const ExactTurns from = exact_turns(hz, from_ns);
  const ExactTurns to = exact_turns(hz, to_ns);
  return static_cast<double>(static_cast<Wide>(open_up_to(to) - open_up_to(from)) /
                             (static_cast<Wide>(to.count - from.count) * 65536));
}

void SpringJudge::advance(Wide u, Wide dt_s) {
  const Wide norm = dt_s * (1 + std::fabs(stiffness) + std::fabs(damping));
  int squarings = 0;
  Wide h = dt_s;
  for (Wide n = norm; n > std::ldexp(Wide(1), -halve_until); n /= 2) {
    h /= 2;
    ++squarings;
  }
  // E = exp(A h) - 1, to avoid cancellation when squaring: (1 + E)^2 - 1 = 2 E + E^2.
  using Matrix = std::array<Wide, 4>;
  const auto times = [](const Matrix& a, const Matrix& b) {
    return Matrix{a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2],
                  a[2] * b[1] + a[3] * b[3]};
  };
  const Matrix a{0, h, -stiffness * h, -damping * h};
  Matrix e{};
  Matrix term = a;
  for (int k = 2; k < 40; ++k) {
    for (std::size_t i = 0; i < 4; ++i) e[i] += term[i];
    term = times(term, a);
    for (Wide& t : term) t /= k;
  }
  for (int s = 0; s < squarings; ++s) {
    const Matrix square = times(e, e);
    for (std::size_t i = 0; i < 4; ++i) e[i] = 2 * e[i] + square[i];
  }
  const Wide away = x - u;
  x += e[0] * away + e[1] * v;
  v += e[2] * away + e[3] * v;
}

AirJudged air_judged(const std::vector<AirStretch>& stretches, double tau_s) {
  static constexpr Wide kNodes[] = {0.1834346424956498049L, 0.5255324099163289858L, 0.7966664774136267396L,
                                    0.9602898564975362317L};
  static constexpr Wide kWeights[] = {0.3626837833783619830L, 0.3137066458778872873L, 0.2223810344533744706L,
                                      0.1012285362903762592L};
  Wide end_s = 0;  // from the end of this period to the end of all
  Wide mixed = 0;  // integral of the mixing from there to the end of all
  AirJudged sum;
  for (std::size_t i = stretches.size(); i-- > 0;) {
    const AirStretch& stretch = stretches[i];
    const Wide length_s = static_cast<Wide>(stretch.dt_ns) * 1e-9L;
    const auto add = [&](Wide from, Wide to) {  // seconds before the end of this period
      for (int n = 0; n < 8; ++n) {
        const Wide s = (from + to) / 2 + (n % 2 == 0 ? 1 : -1) * kNodes[n / 2] * (to - from) / 2;
        const Wide weight = kWeights[n / 2] * (to - from) / 2 * static_cast<Wide>(stretch.inflow_per_m_s);
        const Wide there = weight * std::exp(-(end_s + s) / static_cast<Wide>(tau_s));
        sum.total_per_m += there;
        sum.scattering_per_m -= there * std::expm1(-(mixed + static_cast<Wide>(stretch.mixing_hz) * s));
      }
    };
    Wide from = 0;
    for (Wide to = 1e-7L; from < length_s && stretch.inflow_per_m_s > 0; to *= 1.5L) {
      add(from, std::min(to, length_s));
      from = to;
    }
    end_s += length_s;
    mixed += static_cast<Wide>(stretch.mixing_hz) * length_s;
  }
  return sum;
}

}  // namespace footlight::render

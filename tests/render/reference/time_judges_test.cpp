#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include <doctest/doctest.h>

#include "render/reference/time_judges.h"
#include "sim/shared/shared.h"

namespace {

using namespace footlight::render;

constexpr FilamentLaw kLaw{.rate_per_s = 5, .p = 4.86, .r = 1.215, .q = 0.15, .ambient = 293.0 / 3200};
constexpr std::int64_t kMonthNs = 2'592'000'000'000'000;

double judged(double y, double v, double dt_s) {
  return static_cast<double>(filament_judged(kLaw, y, v, dt_s, 20, 1e-17L));
}

}  // namespace

TEST_CASE("an unpowered filament cools by the closed form of its power law, down to the room's temperature") {
  const double e = kLaw.p - kLaw.q - 1;
  for (const double t_s : {0.01, 0.1, 1.0}) {
    const double closed = std::pow(1 + e * kLaw.rate_per_s * t_s, -1 / e);
    CHECK(judged(1, 0, t_s) == doctest::Approx(closed).epsilon(1e-15));
  }
  CHECK(judged(1, 0, 1e6) == kLaw.ambient);
}

TEST_CASE("a filament reaches the steady temperature of its voltage") {
  for (const double v : {0.1, 0.5, 1.0}) {
    const double rest = std::pow(v, 2 / (kLaw.p + kLaw.r));
    CHECK(judged(kLaw.ambient, v, 1000) == doctest::Approx(rest).epsilon(1e-15));
    CHECK(judged(1, v, 1000) == doctest::Approx(rest).epsilon(1e-15));
  }
}

TEST_CASE("the time of a filament's heating distinguishes a temperature that is wrong by 1e-6 from a right one") {
  for (const double v : {0.0, 0.2, 1.0}) {
    for (const double y0 : {0.1, 0.5, 0.95}) {
      for (const double dt_s : {0.001, 0.02}) {
        CAPTURE(v);
        CAPTURE(y0);
        CAPTURE(dt_s);
        const double y1 = judged(y0, v, dt_s);
        CHECK(filament_flight_error(kLaw, y0, v, dt_s, y1) < 1e-11);
        if (y1 > kLaw.ambient) {
          const double wrong = filament_flight_error(kLaw, y0, v, dt_s, y1 + 1e-6);
          CHECK(wrong == doctest::Approx(1e-6).epsilon(0.01));
        }
      }
    }
  }
}

TEST_CASE("the filament's judge does not depend on how time is divided") {
  const Wide whole = filament_judged(kLaw, 0.3L, 0.8L, 0.25L, 20, 1e-17L);
  const Wide half = filament_judged(kLaw, filament_judged(kLaw, 0.3L, 0.8L, 0.1L, 20, 1e-17L), 0.8L, 0.15L, 20, 1e-17L);
  CHECK(static_cast<double>(std::fabs(whole - half)) < 1e-15);
}

TEST_CASE("an axis from rest to rest takes twice the root of distance over acceleration, to a microsecond") {
  constexpr double kWay = 2;
  constexpr double kAcceleration = 8;
  const Wide time_s = 2 * std::sqrt(Wide(kWay) / kAcceleration);
  AxisJudge axis(0, 100, kAcceleration, 1e-17);
  axis.advance(kWay, time_s / 2);
  CHECK(axis.position() == doctest::Approx(kWay / 2).epsilon(1e-14));
  axis.advance(kWay, time_s / 2 - 1e-6L);
  CHECK(axis.position() < kWay);
  CHECK(axis.position() > kWay - 1e-11);
  axis.advance(kWay, 1);
  CHECK(axis.position() == doctest::Approx(kWay).epsilon(1e-15));
}

TEST_CASE("turns are exact after a month") {
  CHECK(static_cast<double>(turns_judged(0.5f, 1'000'000'000)) == 0.5);
  CHECK(static_cast<double>(turns_judged(10.0f, kMonthNs)) == 0);
  CHECK(static_cast<double>(turns_judged(10.0f, kMonthNs + 25'000'000)) == 0.25);
  CHECK(static_cast<double>(turns_judged(1e6f, kMonthNs + 125)) == 0.125);
  for (const float hz : {0.37f, 10.0f, 59.94f}) {
    const Wide exact = turns_judged(hz, kMonthNs + 12'345);
    CHECK(static_cast<double>(std::fabs(exact - turns_judged_wide(hz, kMonthNs + 12'345))) < 1e-9);
  }
}

TEST_CASE("the share of a frame that flashes fill is the same by overlaps and by integers") {
  CHECK(open_share_judged_exactly(25.0f, 32'768, 0, 40'000'000) == 0.5);
  CHECK(open_share_judged_exactly(25.0f, 32'768, 0, 20'000'000) == 1);
  CHECK(open_share_judged_exactly(25.0f, 32'768, 20'000'000, 40'000'000) == 0);
  CHECK(open_share_judged_exactly(25.0f, 16'384, 0, 30'000'000) == doctest::Approx(1.0 / 3).epsilon(1e-15));
  for (const float hz : {0.1f, 1.3f, 25.0f, 59.94f, 1000.0f}) {
    for (std::int64_t from_ns = 0; from_ns < 1'000'000'000; from_ns += 16'666'667) {
      const double one = open_share_judged(hz, 0.25, from_ns, from_ns + 16'666'667);
      CHECK(std::abs(one - open_share_judged_exactly(hz, 16'384, from_ns, from_ns + 16'666'667)) < 1e-12);
    }
  }
}

TEST_CASE("the matrix exponential equals the closed forms of a critically damped step and an undamped oscillation") {
  SpringJudge critical{.stiffness = 400, .damping = 40};
  critical.advance(1, 0.07L);
  CHECK(static_cast<double>(critical.x) == doctest::Approx(1 - (1 + 1.4) * std::exp(-1.4)).epsilon(1e-15));
  SpringJudge swing{.stiffness = 10'000, .damping = 0, .x = 1};
  swing.advance(0, 1.23L);
  CHECK(static_cast<double>(swing.x) == doctest::Approx(std::cos(123.0)).epsilon(1e-13));
  CHECK(static_cast<double>(swing.v) == doctest::Approx(-100 * std::sin(123.0)).epsilon(1e-13));
}

TEST_CASE("the judge of a room agrees with the closed forms of closed rooms and of stirred ones") {
  const std::vector<AirStretch> filling = {{2e-3, 1e9, 50'000'000'000}};  // mixes at once
  const double alone = 2e-3 * 120 * (1 - std::exp(-50.0 / 120));
  CHECK(static_cast<double>(air_judged(filling, 120).scattering_per_m) == doctest::Approx(alone).epsilon(1e-9));
  CHECK(static_cast<double>(air_judged(filling, 120).total_per_m) == doctest::Approx(alone).epsilon(1e-14));
  // In a closed room the mixed share is 1 - (1 - e^-mt) / mt.
  const std::vector<AirStretch> closed = {{1e-3, 0.02, 20'000'000'000}, {1e-3, 0.02, 30'000'000'000}};
  const double mixed = 1e-3 * 50 * (1 - (1 - std::exp(-1.0)) / 1.0);
  CHECK(static_cast<double>(air_judged(closed, 1e15).scattering_per_m) == doctest::Approx(mixed).epsilon(1e-13));
  CHECK(air_judged({}, 120).total_per_m == 0);
}

TEST_CASE("a room agrees with the integrals over its droplets, from 1 ns to 1e6 s and from fast to slow mixing") {
  double worst = 0, worst_f = 0;
  for (const double tau_s : {1e-3, 0.5, 120.0, 600.0, 1e6}) {
    for (const double mixing_hz : {0.0, 1e-6, 1 / 60.0, 0.1, 50.0}) {
      for (const std::uint64_t dt_ns : {std::uint64_t{1}, std::uint64_t{1'000'000}, std::uint64_t{22'727'273},
                                        std::uint64_t{60'000'000'000}, std::uint64_t{1'000'000'000'000'000}}) {
        const std::vector<AirStretch> show = {
            {4e-3, mixing_hz, dt_ns}, {4e-4, mixing_hz / 3, dt_ns / 3 + 1}, {0, mixing_hz, dt_ns / 2 + 1}};
        footlight::f64::RoomAir air = footlight::f64::room_start();
        footlight::f32::RoomAir single = footlight::f32::room_start();
        for (const AirStretch& each : show) {
          const glm::uvec2 dt(static_cast<std::uint32_t>(each.dt_ns), static_cast<std::uint32_t>(each.dt_ns >> 32));
          air = room_step(air, tau_s, each.inflow_per_m_s, each.mixing_hz, dt);
          single = room_step(single, static_cast<float>(tau_s), static_cast<float>(each.inflow_per_m_s),
                             static_cast<float>(each.mixing_hz), dt);
        }
        const AirJudged right = air_judged(show, tau_s);
        CAPTURE(tau_s);
        CAPTURE(mixing_hz);
        CAPTURE(dt_ns);
        // Relative to everything in the room, or to an invisible amount if nothing is left.
        const auto all = static_cast<double>(std::max(right.total_per_m, footlight::render::Wide{1e-12L}));
        const auto scattering = static_cast<double>(right.scattering_per_m);
        const double error = std::abs(room_scattering(air) - scattering) / all;
        const double error_f = std::abs(static_cast<double>(room_scattering(single)) - scattering) / all;
        CHECK(error < 1e-14);
        CHECK(error_f < 5e-6);
        worst = std::max(worst, error);
        worst_f = std::max(worst_f, error_f);
      }
    }
  }
  MESSAGE("largest difference beside all droplets: ", worst, " in double, ", worst_f, " in float");
}

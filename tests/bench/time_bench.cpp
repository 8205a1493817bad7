// Steps a second on one core of each model in sim/shared, in float as on the GPU. Figures are in docs/numerics.md.
//
// Each benchmark walks over a rig of 4096 fixtures, so that states come from the cache as they do in a rig. "Changing"
// inputs change at each step, "holding" ones stay.
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "sim/shared/shared.h"

namespace footlight {
namespace {

constexpr std::size_t kFixtures = 4096;
constexpr glm::uvec2 kFrameNs{16'666'667, 0};

// Shares from 0 to 1 that differ from step to step.
struct Inputs {
  std::vector<float> values = std::vector<float>(65536);
  std::size_t at = 0;
  Inputs() {
    std::mt19937 random(1);
    for (float& value : values) value = static_cast<float>(random() % 65536) / 65535.0f;
  }
  float next() { return values[at++ & 65535]; }
};

template <class State, class Step>
void run(benchmark::State& bench, const State& start, Step step) {
  std::vector<State> states(kFixtures, start);
  Inputs inputs;
  for (auto _ : bench) {
    for (State& state : states) step(state, inputs);
    benchmark::DoNotOptimize(states.data());
    benchmark::ClobberMemory();
  }
  bench.SetItemsProcessed(bench.iterations() * static_cast<std::int64_t>(kFixtures));
}

f32::MotorLimits pan_limits() { return f32::motor_limits(540, 2.45f, 0.4f); }

void motor_rest(benchmark::State& bench) {
  const auto limits = pan_limits();
  run(bench, f32::motor_start(3), [&](f32::Motor& m, Inputs&) { m = f32::motor_step(m, limits, 3, kFrameNs); });
}
void motor_holding(benchmark::State& bench) {  // on its way: a target so far that it never arrives
  const auto limits = f32::motor_limits(540, 1866, 0.4f);
  run(bench, f32::motor_start(0), [&](f32::Motor& m, Inputs&) { m = f32::motor_step(m, limits, 1e6f, kFrameNs); });
}
void motor_changing(benchmark::State& bench) {
  const auto limits = pan_limits();
  run(bench, f32::motor_start(0),
      [&](f32::Motor& m, Inputs& in) { m = f32::motor_step(m, limits, 540 * in.next(), kFrameNs); });
}
struct SoftMotor {
  f32::Motor motor = f32::motor_start(0);
  f32::Flex flex = f32::flex_start(0);
};
void soft_motor_changing(benchmark::State& bench, float rate, float damping) {
  const auto limits = pan_limits();
  const f32::FlexLimits soft{rate, damping};
  run(bench, SoftMotor(), [&](SoftMotor& m, Inputs& in) {
    const f32::Motor before = m.motor;
    m.motor = f32::motor_step(m.motor, limits, 540 * in.next(), kFrameNs);
    m.flex = f32::flex_step(m.flex, soft, before, m.motor, limits);
  });
}
void motor_jerk(benchmark::State& bench) { soft_motor_changing(bench, 40, 1); }
void motor_belt(benchmark::State& bench) { soft_motor_changing(bench, 157, 0.05f); }

struct Spinner {
  f32::Spin spin = f32::spin_start({0, 0});
  float rate_hz = 0;
};
void spin(benchmark::State& bench) {
  run(bench, Spinner(), [](Spinner& s, Inputs& in) {
    if (s.rate_hz == 0) s.rate_hz = 10 * in.next() + 0.1f;  // each its own
    spin_move(s.spin, 2, s.rate_hz, kFrameNs);
  });
}

f32::ShutterParams strobe_params(std::uint32_t kind, float rate_hz) {
  f32::ShutterParams params{};
  params.kind = kind;
  params.rate_hz = rate_hz;
  params.duty = 0.3f;
  params.seed = 5;
  return params;
}
struct Shuttered {
  f32::Shutter shutter = f32::shutter_begin();
  float rate_hz = 0;
  float light = 0;
};
void shutter(benchmark::State& bench, std::uint32_t kind) {
  run(bench, Shuttered(), [&](Shuttered& s, Inputs& in) {
    if (s.rate_hz == 0) s.rate_hz = 25 * in.next() + 0.1f;
    s.light = shutter_step(s.shutter, strobe_params(kind, s.rate_hz), kFrameNs);
  });
}
void shutter_open(benchmark::State& bench) { shutter(bench, f32::kShutterOpen); }
void shutter_strobe(benchmark::State& bench) { shutter(bench, f32::kShutterStrobe); }
void shutter_random_pulse(benchmark::State& bench) { shutter(bench, f32::kShutterRandomPulse); }

void smooth(benchmark::State& bench) {
  run(bench, f32::smooth_start(0),
      [](f32::Smooth& s, Inputs& in) { s = f32::smooth_step(s, 0.02f, in.next(), kFrameNs); });
}
void filament(benchmark::State& bench) {
  const f32::FilamentType type{3200, 0.034f};
  run(bench, f32::filament_start(300),
      [&](f32::Filament& f, Inputs& in) { f32::filament_move(f, type, in.next(), kFrameNs); });
}
struct Bulb {
  f32::Filament filament = f32::filament_start(300);
  float light = 0;
};
void filament_with_light(benchmark::State& bench) {
  const f32::FilamentType type{3200, 0.034f};
  run(bench, Bulb(), [&](Bulb& b, Inputs& in) {
    f32::filament_move(b.filament, type, in.next(), kFrameNs);
    b.light = f32::filament_light(b.filament.kelvin, type);
  });
}
struct Diode {
  f32::Led led = f32::led_start(0);
  float light = 0;
};
void led(benchmark::State& bench) {
  const f32::LedType type{0.003f, 180, 0.15f};
  run(bench, Diode(), [&](Diode& d, Inputs& in) { d.light = led_step(d.led, type, in.next(), kFrameNs); });
}
struct Arc {
  f32::Discharge lamp = f32::discharge_start();
  float light = 0;
};
void discharge(benchmark::State& bench) {
  const f32::DischargeType type{1.5f, 40, 100, 0.2f, 0.1f};
  run(bench, Arc(), [&](Arc& a, Inputs&) { a.light = discharge_step(a.lamp, type, 1, kFrameNs); });
}

// A profile: pan, tilt, zoom and focus, a strobe, a gobo that turns, a dimmer with its law and an LED driver. Half of
// the heads strobe. Holding, nothing changes; fading, pan, tilt and dimmer go a little further at each step, as a desk
// fades; jumping, they get unrelated values at each step, which no show does and no branch foretells.
enum class Show { kHolds, kFades, kJumps };
struct Head {
  f32::Motor pan = f32::motor_start(0), tilt = f32::motor_start(0), zoom = f32::motor_start(0),
             focus = f32::motor_start(0);
  f32::Shutter shutter = f32::shutter_begin();
  f32::Spin gobo = f32::spin_start({0, 0});
  f32::Led led = f32::led_start(0);
  float rate_hz = 0;  // each its own
  float light = 0;
  float fade = 0;       // -1 to 1, of which the sign is dropped: up and down again
  float fade_step = 0;  // each its own
  bool strobes = false;
};
void head(benchmark::State& bench, Show show) {
  const auto limits = pan_limits();
  const f32::LedType type{0.003f, 0, 0};
  std::uint32_t made = 0;
  const bool moving = show != Show::kHolds;
  run(bench, Head(), [&](Head& h, Inputs& in) {
    h.fade = h.fade > 1 ? h.fade - 2 : h.fade + h.fade_step;
    const float target = show == Show::kFades ? std::abs(h.fade) : show == Show::kJumps ? in.next() : 0;
    if (h.rate_hz == 0) {
      h.fade = 2 * in.next() - 1;
      h.fade_step = 0.01f * in.next();  // there and back in 3 s and more
      h.rate_hz = 10 * in.next() + 0.1f;
      h.strobes = (made++ & 1u) != 0;
    }
    h.pan = f32::motor_step(h.pan, limits, moving ? 540 * target : 3, kFrameNs);
    h.tilt = f32::motor_step(h.tilt, limits, moving ? 270 * target : 3, kFrameNs);
    h.zoom = f32::motor_step(h.zoom, limits, 30, kFrameNs);
    h.focus = f32::motor_step(h.focus, limits, 0.5f, kFrameNs);
    spin_move(h.gobo, 2, h.rate_hz, kFrameNs);
    h.light = led_step(h.led, type, f32::law_light(f32::kLawSquare, moving ? target : 0.7f), kFrameNs) *
              shutter_step(h.shutter, strobe_params(h.strobes ? f32::kShutterStrobe : f32::kShutterOpen, h.rate_hz),
                           kFrameNs);
  });
}
void head_holding(benchmark::State& bench) { head(bench, Show::kHolds); }
void head_fading(benchmark::State& bench) { head(bench, Show::kFades); }
void head_jumping(benchmark::State& bench) { head(bench, Show::kJumps); }

BENCHMARK(motor_rest);
BENCHMARK(motor_holding);
BENCHMARK(motor_changing);
BENCHMARK(motor_jerk);
BENCHMARK(motor_belt);
BENCHMARK(spin);
BENCHMARK(shutter_open);
BENCHMARK(shutter_strobe);
BENCHMARK(shutter_random_pulse);
BENCHMARK(smooth);
BENCHMARK(filament);
BENCHMARK(filament_with_light);
BENCHMARK(led);
BENCHMARK(discharge);
BENCHMARK(head_holding);
BENCHMARK(head_fading);
BENCHMARK(head_jumping);

}  // namespace
}  // namespace footlight

// The same step in float and in double, from random states, to find their largest differences.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "render/reference/time_bench.h"
#include "render/reference/time_report.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

// Random inputs that are exact floats, and their text.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t model) : seed_(seed * 64 + model) {}

  void next_state() {
    names_.clear();
    values_.clear();
  }
  float between(const char* name, double low, double high) { return keep(name, low + share() * (high - low)); }
  // Log-uniform: every decade is equally likely.
  float decades(const char* name, double low, double high) { return keep(name, low * std::pow(high / low, share())); }
  // A level: 5 of 11 are 0, 1/4, 1/2, 3/4 or 1, the others are random values of 16 bits.
  float level(const char* name) {
    const double coarse = std::floor(share() * 11) / 10;
    return keep(name, coarse < 0.45 ? coarse * 2.5 : std::floor(share() * 65536) / 65535);
  }
  std::uint32_t below(const char* name, std::uint32_t count) {
    return static_cast<std::uint32_t>(keep(name, std::floor(share() * count)));
  }
  std::int64_t step_ns() { return std::llround(1e9 * static_cast<double>(decades("dt_s", 1e-5, 60))); }

  [[nodiscard]] std::string text() const {
    std::string text;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      text += fmt::format("{}{}={:.9g}", i > 0 ? " " : "", names_[i], values_[i]);
    }
    return text;
  }

 private:
  double share() { return share_of(time_hash(seed_, index_++)); }
  float keep(const char* name, double value) {
    const auto exact = static_cast<float>(value);
    names_.push_back(name);
    values_.push_back(static_cast<double>(exact));
    return exact;
  }

  std::uint64_t seed_;
  std::uint64_t index_ = 0;
  std::vector<const char*> names_;
  std::vector<double> values_;
};

struct Pair {
  double f32 = 0;
  double f64 = 0;
};

struct Model {
  const char* name;
  const char* unit;
  Pair (*step)(Draw& draw);
};

double wide(float value) { return static_cast<double>(value); }
glm::uvec2 words(std::int64_t ns) {
  return {static_cast<std::uint32_t>(ns), static_cast<std::uint32_t>(static_cast<std::uint64_t>(ns) >> 32)};
}

Pair motor(Draw& draw) {  // the range is 1, so the error is a share of it
  const float position = draw.between("position", 0, 1);
  const float speed_max = draw.decades("speed_max", 0.01, 10);
  const float speed = draw.between("speed_over_max", -1, 1) * speed_max;
  const float acceleration = draw.decades("acceleration_over_max", 0.1, 1000) * speed_max;
  const float target = draw.level("target");
  const float dt_s = draw.decades("dt_s", 1e-4, 60);
  return {wide(f32::axis_step({position, speed}, target, speed_max, acceleration, dt_s).position),
          f64::axis_step({wide(position), wide(speed)}, wide(target), wide(speed_max), wide(acceleration), wide(dt_s))
              .position};
}

Pair belt(Draw& draw) {
  const float position = draw.between("position", 0, 1);
  const float rate = draw.decades("rate", 1, 1000);
  const float speed = draw.between("speed_over_rate", -1, 1) * rate;
  const float damping = draw.between("damping", 0.01, 1);
  const float target = draw.level("target");
  const float dt_s = draw.decades("dt_s", 1e-4, 60);
  return {
      wide(f32::flex_stretch({position, speed}, {rate, damping}, {target, 0}, 0, dt_s).position),
      f64::flex_stretch({wide(position), wide(speed)}, {wide(rate), wide(damping)}, {wide(target), 0}, 0, wide(dt_s))
          .position};
}

Pair smoothing(Draw& draw) {
  const float from = draw.level("from");
  const float target = draw.level("target");
  const float tau_s = draw.decades("tau_s", 1e-3, 10);
  const std::int64_t dt_ns = draw.step_ns();
  return {wide(f32::smooth_step(f32::smooth_start(from), tau_s, target, words(dt_ns)).now.position),
          f64::smooth_step(f64::smooth_start(wide(from)), wide(tau_s), wide(target), words(dt_ns)).now.position};
}

Pair filament(Draw& draw) {
  const float kelvin = draw.between("kelvin", 293.15, 3200);
  const float tau_s = draw.decades("tau_s", 0.003, 0.35);
  const float volt = draw.level("volt");
  const float t_s = draw.decades("dt_s", 1e-5, 60);
  return {wide(f32::filament_after(kelvin, {3200, tau_s}, volt, t_s)),
          f64::filament_after(wide(kelvin), {3200, wide(tau_s)}, wide(volt), wide(t_s))};
}

Pair filament_light(Draw& draw) {
  const float kelvin = draw.between("kelvin", 293.15, 3300);
  return {wide(f32::filament_light(kelvin, {3200, 0.03f})), f64::filament_light(wide(kelvin), {3200, 0.03})};
}

Pair led(Draw& draw) {
  const float from = draw.level("from");
  const float target = draw.level("target");
  const float rise_s = draw.decades("rise_s", 1e-3, 5e-3);
  const float heat_s = draw.decades("heat_s", 10, 1000);
  const float droop = draw.between("droop", 0, 0.3);
  const std::int64_t dt_ns = draw.step_ns();
  f32::Led narrow = f32::led_start(from);
  f64::Led other = f64::led_start(wide(from));
  return {wide(f32::led_step(narrow, {rise_s, heat_s, droop}, target, words(dt_ns))),
          f64::led_step(other, {wide(rise_s), wide(heat_s), wide(droop)}, wide(target), words(dt_ns))};
}

Pair mains(Draw& draw) {
  const float share = draw.level("share");
  const float hz = draw.between("hz", 99, 121);
  const float start = draw.between("phase", 0, 1);
  const std::int64_t dt_ns = draw.step_ns();
  return {wide(f32::mains_mean(f32::turns_from(start), f32::turns_advance(hz, words(dt_ns)), share)),
          f64::mains_mean(f64::turns_from(wide(start)), f64::turns_advance(wide(hz), words(dt_ns)), wide(share))};
}

Pair shutter(Draw& draw) {
  f32::ShutterParams narrow{};
  narrow.kind = draw.below("kind", f32::kShutterKindCount);
  narrow.rate_hz = draw.decades("rate_hz", 0.1, 1000);
  narrow.duty = draw.between("duty", 0, 1);
  narrow.offset = draw.between("offset", 0, 1);
  narrow.low = draw.between("low", 0, 0.5);
  narrow.travel_s = draw.below("blades", 2) != 0 ? draw.between("travel_s", 0, 0.02) : 0.0f;
  narrow.seed = draw.below("seed", 1000);
  const auto before_ns = std::llround(1e9 * wide(draw.decades("before_s", 1e-3, 2'592'000)));
  const std::int64_t dt_ns = draw.step_ns();
  f64::ShutterParams other{};
  other.kind = narrow.kind;
  other.rate_hz = wide(narrow.rate_hz);
  other.duty = wide(narrow.duty);
  other.offset = wide(narrow.offset);
  other.low = wide(narrow.low);
  other.travel_s = wide(narrow.travel_s);
  other.seed = narrow.seed;
  f32::Shutter a = f32::shutter_begin();
  f64::Shutter b = f64::shutter_begin();
  f32::shutter_step(a, narrow, words(before_ns));
  f64::shutter_step(b, other, words(before_ns));
  return {wide(f32::shutter_step(a, narrow, words(dt_ns))), f64::shutter_step(b, other, words(dt_ns))};
}

Pair turns(Draw& draw) {
  const float rate_hz = draw.decades("rate_hz", 0.01, 1000);
  const auto dt_ns = std::llround(1e9 * wide(draw.decades("dt_s", 1e-3, 2'592'000)));
  const glm::uvec2 a = f32::turns_step(f32::Turns(0, 0), rate_hz, words(dt_ns));
  const glm::uvec2 b = f64::turns_step(f64::Turns(0, 0), wide(rate_hz), words(dt_ns));
  const double exact = f64::turns_real(b);
  return {exact + f64::turns_way(b, a), exact};
}

Pair dimmer(Draw& draw) {
  const std::uint32_t law = draw.below("law", f32::kLawTable);
  const float level = draw.level("level");
  return {wide(f32::law_light(law, level)), f64::law_light(law, wide(level))};
}

constexpr Model kModels[] = {
    {"motor", "range", motor},
    {"belt", "range", belt},
    {"smoothing", "full", smoothing},
    {"filament", "K", filament},
    {"filament light", "full", filament_light},
    {"led", "full", led},
    {"mains", "full", mains},
    {"shutter", "share", shutter},
    {"turns", "turn", turns},
    {"dimmer law", "full", dimmer},
};

}  // namespace

std::vector<Disagreement> worst_disagreements(int states, std::uint64_t seed) {
  std::vector<Disagreement> all;
  std::uint64_t number = 0;
  for (const Model& model : kModels) {
    Draw draw(seed, number++);
    std::vector<Disagreement> worst;
    for (int i = 0; i < states; ++i) {
      draw.next_state();
      const Pair pair = model.step(draw);
      double error = std::abs(pair.f32 - pair.f64);
      if (!std::isfinite(error)) error = std::numeric_limits<double>::infinity();
      if (worst.size() == kWorstCount && error <= worst.back().error) continue;
      if (worst.size() == kWorstCount) worst.pop_back();
      const auto at = std::upper_bound(worst.begin(), worst.end(), error,
                                       [](double e, const Disagreement& d) { return e > d.error; });
      worst.insert(at, {model.name, pair.f32, pair.f64, error, model.unit, draw.text()});
    }
    all.insert(all.end(), worst.begin(), worst.end());
  }
  return all;
}

std::string json_lines_of(const std::vector<Disagreement>& worst) {
  std::string text;
  for (const Disagreement& d : worst) {
    const nlohmann::ordered_json object = {{"model", d.model}, {"f32", d.f32},   {"f64", d.f64},
                                           {"error", d.error}, {"unit", d.unit}, {"input", d.input}};
    text += object.dump() + "\n";
  }
  return text;
}

}  // namespace footlight::render

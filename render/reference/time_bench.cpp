#include "render/reference/time_bench.h"

#include <time.h>

#include <algorithm>
#include <limits>

#include "sim/core/random.h"

namespace footlight::render {
namespace {

constexpr double kEscapeShare = 0.1;  // of the judge's range; a method further outside has diverged
constexpr double kUselessRelL2 = 0.999;

double as_float(double value) { return static_cast<double>(static_cast<float>(value)); }

}  // namespace

std::uint64_t time_hash(std::uint64_t seed, std::uint64_t index) {
  return mixed_bits(seed * kMixStep + index * 0xd1b54a32d192ed03u);
}

double share_of(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

std::size_t inputs_needed(double seconds) {
  return static_cast<std::size_t>(seconds * 1e9 / static_cast<double>(kLevelsPeriodNs)) + 2;
}

Frames frames_of(double seconds, double fps, std::span<const double> inputs) {
  Frames show;
  const auto count = static_cast<std::int64_t>(seconds * fps);
  for (std::int64_t i = 0; i <= count; ++i) {
    show.start_ns.push_back(static_cast<std::int64_t>(std::llround(static_cast<double>(i) * 1e9 / fps)));
  }
  for (std::size_t i = 0; i + 1 < show.start_ns.size(); ++i) {
    show.dt_s.push_back(static_cast<double>(show.start_ns[i + 1] - show.start_ns[i]) * 1e-9);
    show.input.push_back(inputs[static_cast<std::size_t>(show.start_ns[i] / kLevelsPeriodNs)]);
  }
  return show;
}

std::vector<double> moves_of(double seconds, std::uint64_t seed) {
  std::vector<double> levels;
  double level = 0.5;
  for (std::size_t i = 0; i < inputs_needed(seconds); ++i) {
    constexpr double kChance[3] = {0.03, 0.3, 1.0};
    const double chance = kChance[time_hash(seed, 3 * (i / 44)) % 3];
    if (share_of(time_hash(seed, 3 * i + 1)) < chance) {
      level = as_float(static_cast<double>(time_hash(seed, 3 * i + 2) & 0xffff) / 65535);
    }
    levels.push_back(level);
  }
  return levels;
}

std::vector<double> flashes_of(double seconds, std::uint64_t seed) {
  std::vector<double> levels;
  for (std::size_t i = 0; i < inputs_needed(seconds); ++i) {
    double level = 1;
    switch (i / 44 % 4) {
      case 1: level = 0; break;
      case 2: level = static_cast<double>(i % 44) / 44; break;
      case 3: level = (i / 4) % 2 == 1 ? static_cast<double>(time_hash(seed, i / 4) & 0xffff) / 65535 : 0.1; break;
      default: break;
    }
    levels.push_back(as_float(level));
  }
  return levels;
}

double thread_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

NsPerFrame percentiles_of(std::vector<double> ns) {
  if (ns.empty()) return {};
  std::sort(ns.begin(), ns.end());
  const auto at = [&](double share) {
    return ns[static_cast<std::size_t>(std::lround(share * static_cast<double>(ns.size() - 1)))];
  };
  return {at(0.1), at(0.5), at(0.9)};
}

TimeRow time_row_of(const TimeScene& scene, const std::string& method, double knob, std::span<const double> values) {
  TimeRow row;
  row.model = scene.model;
  row.method = method;
  row.knob = knob;
  row.tau_ms = scene.tau_ms;
  row.fps = scene.fps;
  row.seconds = scene.seconds;
  row.unit = scene.unit;
  double low = scene.judge.front();
  double high = low;
  for (const auto* right : {&scene.judge, &scene.span}) {
    for (const double value : *right) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  const double slack = kEscapeShare * (high - low);
  bool finite = true;
  bool escaped = false;
  double wrong = 0;
  double right = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values[i];
    finite = finite && std::isfinite(value);
    escaped = escaped || !(value >= low - slack && value <= high + slack);
    const double error = std::abs(value - scene.judge[i]);
    if (!(error * scene.unit_scale <= row.error_max)) row.error_max = error * scene.unit_scale;  // NaN stays
    const double light = scene.seen(scene.judge[i]);
    const double miss = scene.miss(value, scene.judge[i]);
    wrong += miss * miss;
    right += light * light;
  }
  row.rel_l2 = right > 0 ? std::sqrt(wrong / right) : std::sqrt(wrong);
  if (!finite || !std::isfinite(row.rel_l2)) {
    row.error_max = std::numeric_limits<double>::infinity();
    row.rel_l2 = std::numeric_limits<double>::infinity();
    row.outcome = TimeOutcome::kNonFinite;
  } else if (escaped) {
    row.outcome = TimeOutcome::kDiverged;
  } else if (row.rel_l2 >= kUselessRelL2) {
    row.outcome = TimeOutcome::kUseless;
  }
  return row;
}

}  // namespace footlight::render

// A strobe: the share of each frame in which its flashes are on.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/reference/time_bench.h"
#include "render/reference/time_judges.h"
#include "sim/shared/shared.h"

namespace footlight::render {
namespace {

constexpr int kDuty65536 = 32768;
constexpr double kDuty = kDuty65536 / 65536.0;
constexpr std::int64_t kDayNs = 86'400'000'000'000;

}  // namespace

void report_strobe(const TimeReportOptions& options, TimeReport& report) {
  const std::vector<double> no_levels(inputs_needed(options.seconds), 0);
  JudgeError own{.model = "strobe",
                 .judge = "overlaps of flashes and frame in long double",
                 .own = 0,
                 .second = "open time to either end in 128-bit integers",
                 .unit = "share"};
  TimeBench bench(options, report.rows);
  for (const double strobe_hz : options.strobe_hz) {
    const auto hz = static_cast<float>(strobe_hz);
    for (const double fps : options.fps) {
      if (has_ended(options)) break;
      const Frames show = frames_of(options.seconds, fps, no_levels);
      TimeScene scene{.model = "strobe",
                      .unit = "share",
                      .tau_ms = 1000 / strobe_hz,
                      .fps = fps,
                      .seconds = options.seconds,
                      .span = {0, 1}};
      TimeScene next_day = scene;
      next_day.seconds += static_cast<double>(kDayNs) * 1e-9;
      for (std::size_t i = 0; i < show.size(); ++i) {
        const std::int64_t from_ns = show.start_ns[i];
        const std::int64_t to_ns = show.start_ns[i + 1];
        scene.judge.push_back(open_share_judged(hz, kDuty, from_ns, to_ns));
        next_day.judge.push_back(open_share_judged_exactly(hz, kDuty65536, kDayNs + from_ns, kDayNs + to_ns));
        own.difference = std::max(own.difference,
                                  std::abs(scene.judge[i] - open_share_judged_exactly(hz, kDuty65536, from_ns, to_ns)));
      }
      const auto integral_f32 = [&](f32::Turns after_ns) {
        f32::ShutterParams params{};
        params.kind = f32::kShutterStrobe;
        params.rate_hz = hz;
        params.duty = static_cast<float>(kDuty);
        f32::Shutter shutter = f32::shutter_begin();
        if (after_ns != f32::Turns(0, 0)) f32::shutter_step(shutter, params, after_ns);
        return [&, params, shutter](std::size_t i) mutable {
          return static_cast<double>(f32::shutter_step(shutter, params, dt_of(show, i)));
        };
      };
      bench.add(scene, "exposure integral f32", 1, [&] { return integral_f32({0, 0}); });
      const auto integral_f64 = [&](f64::Turns after_ns) {
        f64::ShutterParams params{};
        params.kind = f64::kShutterStrobe;
        params.rate_hz = static_cast<double>(hz);
        params.duty = kDuty;
        f64::Shutter shutter = f64::shutter_begin();
        if (after_ns != f64::Turns(0, 0)) f64::shutter_step(shutter, params, after_ns);
        return
            [&, params, shutter](std::size_t i) mutable { return f64::shutter_step(shutter, params, dt_of(show, i)); };
      };
      bench.add(scene, "exposure integral f64", 1, [&] { return integral_f64({0, 0}); });
      // The sign of a sine, at this many times per frame.
      for (const int samples : options.substeps) {
        bench.add(scene, "point samples", samples, [&] {
          return [&, samples](std::size_t i) {
            int open = 0;
            for (int s = 0; s < samples; ++s) {
              const double t_s = static_cast<double>(show.start_ns[i]) * 1e-9 + (s + 0.5) / samples * show.dt_s[i];
              open += std::sin(2 * std::numbers::pi * static_cast<double>(hz) * t_s) > 0 ? 1 : 0;
            }
            return static_cast<double>(open) / samples;
          };
        });
      }
      // One day after the start: this program, and a shader that multiplies float seconds by the rate.
      const glm::uvec2 day(static_cast<std::uint32_t>(kDayNs), static_cast<std::uint32_t>(kDayNs >> 32));
      bench.add(next_day, "exposure integral f32", 1, [&] { return integral_f32(day); });
      bench.add(next_day, "exposure integral f64", 1, [&] { return integral_f64(day); });
      bench.add(next_day, "point sample, float seconds", 1, [&] {
        return [&](std::size_t i) {
          const auto t_s = static_cast<float>(static_cast<double>(kDayNs + show.start_ns[i]) * 1e-9);
          return std::sin(2 * std::numbers::pi_v<float> * hz * t_s) > 0 ? 1.0 : 0.0;
        };
      });
    }
  }
  own.own = 0x1p-53;
  report.judges.push_back(own);
}

}  // namespace footlight::render

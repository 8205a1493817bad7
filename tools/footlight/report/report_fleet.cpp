#include "tools/footlight/report/report_fleet.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "fixtures/builtin/builtin.h"
#include "fixtures/simulate/walker.h"
#include "render/frame.h"
#include "tools/footlight/report/picture_report.h"

namespace footlight::tools {
namespace {

constexpr std::int64_t kFrameNs = 16'666'667;
constexpr int kJudgedMax = 1'000;
constexpr int kJudgedSteps = 240;
constexpr int kStepsPerChange = 2;        // of the levels
constexpr std::uint32_t kOneSlotIn = 16;  // each slot is held for half a second on average, as in a busy show

Result<fixtures::Rig> fleet_rig(int count) {
  const fixtures::FixtureType* type = fixtures::find_builtin_type("generic/profile");
  FL_CHECK(type != nullptr);
  fixtures::Rig rig;
  rig.name = "fleet";
  rig.haze.scattering_per_m = 0;  // only the steps matter
  rig.types.push_back(*type);
  rig.cameras.emplace_back();
  const int slots = type->modes.front().slot_count;
  const int per_universe = kSlotCountMax / slots;
  for (int i = 0; i < count; ++i) {
    fixtures::PatchedFixture fixture;
    fixture.name = fmt::format("Head {}", i + 1);
    fixture.universe = 1 + i / per_universe;
    fixture.address = 1 + i % per_universe * slots;
    fixture.position_m = {i % 1000, i / 1000, 6};
    rig.fixtures.push_back(std::move(fixture));
  }
  return rig;
}

// One slot in `every` changes at random, every second step.
class Levels {
 public:
  Levels(std::size_t bytes, std::uint32_t every) : bytes_(bytes), every_(every) {}
  std::span<const std::uint8_t> next() {
    if (step_++ % kStepsPerChange == 0) {
      for (std::uint8_t& byte : bytes_) {
        if ((random_() >> 8) % every_ == 0) byte = static_cast<std::uint8_t>(random_() >> 20);
      }
    }
    return bytes_;
  }

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint32_t every_;
  std::minstd_rand random_{7};
  int step_ = 0;
};

render::FrameSettings small_picture() {
  render::FrameSettings settings;
  settings.width = settings.height = 64;
  settings.bodies = false;
  return settings;
}

Status time_steps(render::vk::Device& device, const FleetOptions& options, FleetReport& report) {
  FL_ASSIGN(const fixtures::Rig rig, fleet_rig(options.fixtures));
  FL_ASSIGN(const fixtures::CompiledRig compiled, fixtures::compile(rig));
  FL_ASSIGN(const auto frame, render::Frame::create(device, rig, compiled, small_picture()));
  const render::View view = render::view_of(rig.cameras.front());
  report.state_bytes = sizeof(fixtures::f32::Walker::HeadState) * compiled.heads.size() +
                       sizeof(fixtures::f32::Walker::OpticsState) * compiled.optics_count +
                       sizeof(fixtures::f32::Motor) * compiled.motor_count +
                       sizeof(fixtures::f32::Spin) * compiled.spin_count +
                       sizeof(fixtures::f32::Shutter) * compiled.strobe_count;
  report.table_bytes = sizeof(fixtures::HeadRow) * compiled.heads.size();
  Levels levels(compiled.universes.size() * kSlotCountMax, kOneSlotIn);
  std::vector<double> times_ms;
  std::vector<double> levels_ms;
  for (int run = 0; run < options.runs + 3; ++run) {
    frame->step(levels.next(), kFrameNs);
    FL_TRY(frame->draw(view, 0));
    FL_ASSIGN(const auto times, frame->read_times());
    for (const auto& pass : times) {
      if (run < 3) continue;
      if (pass.name == "step") times_ms.push_back(pass.gpu_ms);
      if (pass.name == "levels") levels_ms.push_back(pass.gpu_ms);
    }
  }
  if (times_ms.empty()) return fail(ErrorCode::kUnsupported, "{}: has no GPU timestamps", device.name());
  report.gpu_ms_p10 = percentile(times_ms, 0.1);
  report.gpu_ms_p50 = percentile(times_ms, 0.5);
  report.gpu_ms_p90 = percentile(times_ms, 0.9);
  report.levels_ms = percentile(levels_ms, 0.5);

  const auto time_cpu = [&](auto stepper) {
    std::vector<double> ns;
    for (int run = 0; run < options.runs + 3; ++run) {
      const auto now = levels.next();
      const auto start = std::chrono::steady_clock::now();
      stepper->step(now, kFrameNs);
      const double taken = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
      if (run >= 3) ns.push_back(taken / options.fixtures);
    }
    return percentile(ns, 0.5);
  };
  report.walker_ns = time_cpu(std::make_unique<fixtures::f32::Walker>(compiled));
  return {};
}

Status judge(render::vk::Device& device, const FleetOptions& options, FleetReport& report) {
  report.judged_fixtures = std::min(options.fixtures, kJudgedMax);
  report.judged_steps = kJudgedSteps;
  FL_ASSIGN(const fixtures::Rig rig, fleet_rig(report.judged_fixtures));
  FL_ASSIGN(const fixtures::CompiledRig compiled, fixtures::compile(rig));
  FL_ASSIGN(const auto frame, render::Frame::create(device, rig, compiled, small_picture()));
  fixtures::f32::Walker in_float(compiled);
  fixtures::f64::Walker in_double(compiled);
  Levels levels(compiled.universes.size() * kSlotCountMax, kOneSlotIn);
  const char* const names[] = {"pan_rad", "tilt_rad", "zoom_rad", "red", "green", "blue", "gobo_angle_rad"};
  const auto values_of = [&](std::size_t head, const auto& states, const auto& optics) {
    const auto& state = states[head];
    const std::uint32_t own = compiled.heads[head].optics;
    const double gobo_rad = own == fixtures::kNoAddress ? 0.0 : static_cast<double>(optics[own].angle_1);
    return std::array<double, 7>{state.pan, state.tilt, state.zoom, state.red, state.green, state.blue, gobo_rad};
  };
  std::array<FleetWorst, 7> worst;
  for (int step = 0; step < kJudgedSteps; ++step) {
    const auto now = levels.next();
    frame->step(now, kFrameNs);
    FL_TRY(frame->run_steps());
    in_float.step(now, kFrameNs);
    in_double.step(now, kFrameNs);
    FL_ASSIGN(const auto states, frame->read_states());
    FL_ASSIGN(const auto optics, frame->read_optics());
    for (std::size_t i = 0; i < states.size(); ++i) {
      const auto gpu = values_of(i, states, optics);
      const auto judge = values_of(i, in_double.states, in_double.optics_states);
      const auto cpu = values_of(i, in_float.states, in_float.optics_states);
      for (std::size_t v = 0; v < worst.size(); ++v) {
        // Compares angles of a spin modulo one turn, because rounding can move the wrap to a neighbouring step.
        const auto apart = [&](double a, double b) {
          return v == 6 ? std::abs(std::remainder(a - b, 2 * std::numbers::pi)) : std::abs(a - b);
        };
        if (!(apart(gpu[v], judge[v]) <= apart(worst[v].gpu, worst[v].cpu)))
          worst[v] = {names[v], static_cast<int>(i), step, gpu[v], judge[v], cpu[v]};
      }
    }
  }
  for (const FleetWorst& one : worst) {
    if (!one.value.empty()) report.worst.push_back(one);
  }
  std::stable_sort(report.worst.begin(), report.worst.end(), [](const FleetWorst& a, const FleetWorst& b) {
    return std::abs(a.gpu - a.cpu) > std::abs(b.gpu - b.cpu);
  });
  return {};
}

}  // namespace

Result<FleetReport> make_fleet_report(render::vk::Device& device, const FleetOptions& options) {
  if (options.fixtures < 1 || options.fixtures > 1'000'000 || options.runs < 3) {
    return fail(ErrorCode::kBadInput, "{} fixtures in {} runs: expected 1 to 1000000 in 3 or more", options.fixtures,
                options.runs);
  }
  FleetReport report;
  report.device = device.name();
  FL_TRY(time_steps(device, options, report));
  FL_TRY(judge(device, options, report));
  return report;
}

std::string text_of(const FleetReport& report, const FleetOptions& options) {
  const double per_fixture_ns = report.gpu_ms_p50 * 1e6 / options.fixtures;
  std::string text = fmt::format(
      "{} moving heads (generic/profile, 16 bit), one step of 1/60 s, on {}\n"
      "  GPU     {:.4f} ms, p10 {:.4f}, p90 {:.4f}, {} runs after 3 warm-up runs: {:.2f} ns per fixture{}\n"
      "  levels  {:.4f} ms to upload\n"
      "  CPU     {:.1f} ns per fixture in float on one core: {:.1f} million fixtures per second\n"
      "  memory  {} bytes of state per fixture, {} of tables\n"
      "GPU in float against the CPU in double, {} fixtures, {} steps, one slot in 16 changes at random every 2 "
      "steps:\n",
      options.fixtures, report.device, report.gpu_ms_p50, report.gpu_ms_p10, report.gpu_ms_p90, options.runs,
      per_fixture_ns, report.gpu_ms_p90 > 1.15 * report.gpu_ms_p10 ? " (unstable)" : "", report.levels_ms,
      report.walker_ns, 1e3 / report.walker_ns, report.state_bytes / static_cast<std::uint64_t>(options.fixtures),
      report.table_bytes / static_cast<std::uint64_t>(options.fixtures), report.judged_fixtures, report.judged_steps);
  for (const FleetWorst& one : report.worst) {
    text +=
        fmt::format("  {:<15} {:.2e} at fixture {}, step {}: {:.9g}, in double {:.9g}, in float on the CPU {:.9g}\n",
                    one.value, std::abs(one.gpu - one.cpu), one.fixture + 1, one.step, one.gpu, one.cpu, one.float_cpu);
  }
  return text;
}

std::string json_of(const FleetReport& report, const FleetOptions& options) {
  std::string text = fmt::format(
      R"({{"event":"fleet","fixtures":{},"device":"{}","gpu_ms_p10":{:.5f},"gpu_ms_p50":{:.5f},"gpu_ms_p90":{:.5f},)"
      R"("levels_ms":{:.5f},)"
      R"("walker_ns_per_fixture":{:.2f},"state_bytes":{},"table_bytes":{}}})"
      "\n",
      options.fixtures, report.device, report.gpu_ms_p10, report.gpu_ms_p50, report.gpu_ms_p90, report.levels_ms,
      report.walker_ns, report.state_bytes, report.table_bytes);
  for (const FleetWorst& one : report.worst) {
    text += fmt::format(
        R"({{"event":"fleet-worst","value":"{}","fixture":{},"step":{},"gpu":{:.9g},"double":{:.17g},"float":{:.9g}}})"
        "\n",
        one.value, one.fixture + 1, one.step, one.gpu, one.cpu, one.float_cpu);
  }
  return text;
}

}  // namespace footlight::tools

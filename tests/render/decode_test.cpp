// Raw levels to fixture states on the GPU, against the walker in float and in double.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "fixtures/walker.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using State = fixtures::f32::Walker::FixtureState;
using JudgeState = fixtures::f64::Walker::FixtureState;
using footlight::testing::HeadlessVulkan;

bool equal_bits(float a, float b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

struct Differences {
  double position_rad = 0;      // pan, tilt, zoom
  double speed_rad_s = 0;
  double light = 0;             // red, green, blue
  std::int64_t phases = 0;      // how many phases and gobos differ at all
  std::int64_t bits = 0;        // how many floats are not equal to the bit
  std::int64_t compared = 0;
  void print(const char* what) const {
    std::fprintf(stderr, "%s: position %.3g rad, speed %.3g rad/s, light %.3g, phases %lld, bits %lld of %lld\n", what,
                 position_rad, speed_rad_s, light, static_cast<long long>(phases), static_cast<long long>(bits),
                 static_cast<long long>(compared));
  }
};

template <class Other>
void compare(const std::vector<State>& gpu, const std::vector<Other>& cpu, Differences& d) {
  REQUIRE(gpu.size() == cpu.size());
  const auto difference = [](double a, double b) {
    REQUIRE(std::isfinite(a));
    return std::abs(a - b);
  };
  for (std::size_t i = 0; i < gpu.size(); ++i) {
    const State& a = gpu[i];
    const Other& b = cpu[i];
    const float floats[] = {a.pan.position, a.tilt.position, a.zoom.position, a.pan.speed, a.tilt.speed, a.zoom.speed,
                            a.red, a.green, a.blue, a.exposure_s};
    const decltype(b.red) others[] = {b.pan.position, b.tilt.position, b.zoom.position, b.pan.speed, b.tilt.speed,
                                      b.zoom.speed, b.red, b.green, b.blue, b.exposure_s};
    for (std::size_t k = 0; k < 10; ++k) {
      double& worst = k < 3 ? d.position_rad : k < 6 ? d.speed_rad_s : d.light;
      worst = std::max(worst, difference(floats[k], others[k]));
      d.bits += !equal_bits(floats[k], static_cast<float>(others[k]));
      ++d.compared;
    }
    d.phases += a.strobe_phase != b.strobe_phase;
    d.phases += a.gobo_phase != b.gobo_phase;
    d.phases += a.gobo != b.gobo;
    d.phases += a.started != b.started;
  }
}

void randomise(std::vector<std::uint8_t>& levels, Random& random) {
  for (auto& level : levels) level = static_cast<std::uint8_t>(random.next());
}

// As if no step had been.
void forget(vk::Device& device, Frame& frame) {
  must(device.run_once([&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, frame.resources().states.handle, 0, VK_WHOLE_SIZE, 0);
  }));
}

// What a step of 0 s gives has no arithmetic that a compiler could contract or reorder on lavapipe; other drivers may
// round mix() otherwise, by 2^-23 of the larger end, and the largest end is 270 degrees.
constexpr double kDecodeMax = 1e-6;
// To double: tables hold floats, 2^-24 of 4.7 rad, and mix() rounds twice.
constexpr double kDecodeJudgeMax = 2e-6;
// Motors, over 400 steps: measured 1.6e-6 rad and 5.0e-6 rad/s to the walker in float on lavapipe, where one in 60
// floats is not equal to the bit (the driver's square root and quotients), 4.2e-6 rad and 1.2e-5 rad/s to double.
// Errors do not add up for long, since every arrival is exact; four times the measured ones are allowed.
constexpr double kMotionMax = 1.7e-5;     // rad
constexpr double kMotionSpeedMax = 5e-5;  // rad/s

TEST_CASE("random levels give the states of the walker, over the demo rig and every built-in mode") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (Scene scene : {demo_scene(1, true), all_modes_scene()}) {
    const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
    Random random(7);
    Differences to_float;
    Differences to_double;
    for (int round = 0; round < 100; ++round) {
      randomise(scene.levels, random);
      fixtures::f32::Walker walker(scene.compiled);
      fixtures::f64::Walker judge(scene.compiled);
      walker.step(scene.levels, 0);
      judge.step(scene.levels, 0);
      forget(vulkan.device(), *frame);
      frame->step(scene.levels, 0);
      must(frame->run_steps());
      const auto states = must(frame->read_states());
      compare(states, walker.states, to_float);
      compare(states, judge.states, to_double);
    }
    to_float.print("decode, to the walker in float");
    to_double.print("decode, to the walker in double");
    if (vulkan.device().is_software()) CHECK(to_float.bits == 0);
    CHECK(to_float.position_rad <= kDecodeMax);
    CHECK(to_float.speed_rad_s == 0);
    CHECK(to_float.light <= kDecodeMax);
    CHECK(to_float.phases == 0);
    CHECK(to_double.position_rad <= kDecodeJudgeMax);
    CHECK(to_double.light <= kDecodeJudgeMax);
    CHECK(to_double.phases == 0);
  }
}

TEST_CASE("motors, strobes and gobos follow the walker over steps of every length, phases to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (Scene scene : {demo_scene(2, true), all_modes_scene()}) {
    const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
    fixtures::f32::Walker walker(scene.compiled);
    fixtures::f64::Walker judge(scene.compiled);
    Random random(8);
    Differences to_float;
    Differences to_double;
    int moving = 0;
    int strobing = 0;
    const std::int64_t lengths_ns[] = {0, 1, kMs, 22'727'272, 40 * kMs, 200 * kMs, 60'000 * kMs, 5'000'000'000'123};
    for (int round = 0; round < 400; ++round) {
      if (random.below(8) == 0) randomise(scene.levels, random);
      const std::int64_t dt_ns = lengths_ns[random.below(round % 40 == 0 ? std::size(lengths_ns) : 6)];
      const bool new_exposure = random.below(3) != 0;
      frame->step(scene.levels, dt_ns, new_exposure);
      walker.step(scene.levels, dt_ns, new_exposure);
      judge.step(scene.levels, dt_ns, new_exposure);
      if (random.below(3) != 0) continue;  // several steps in one command buffer
      must(frame->run_steps());
      const auto states = must(frame->read_states());
      compare(states, walker.states, to_float);
      compare(states, judge.states, to_double);
      for (const State& state : walker.states) {
        moving += state.pan.speed != 0 || state.tilt.speed != 0 || state.zoom.speed != 0;
        strobing += state.strobe_phase != fixtures::f32::Turns(0, 0);
      }
    }
    to_float.print("motion, to the walker in float");
    to_double.print("motion, to the walker in double");
    // Levels at random strobe most fixtures, and heads with new targets move.
    CHECK(moving > 50);
    CHECK(strobing > 50);
    CHECK(to_float.position_rad <= kMotionMax);
    CHECK(to_float.speed_rad_s <= kMotionSpeedMax);
    CHECK(to_float.light <= kDecodeMax);
    CHECK(to_float.phases == 0);
    CHECK(to_double.position_rad <= kMotionMax);
    CHECK(to_double.speed_rad_s <= kMotionSpeedMax);
    // Light and phases are not compared to double: a float holds the fraction of a strobe's hertz to 6e-8, so that
    // after an hour the two can differ in whether the shutter is open.
  }
}

TEST_CASE("a time step that is negative is none") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = demo_scene(3, false);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  frame->step(scene.levels, 0);
  must(frame->run_steps());
  const auto before = must(frame->read_states());
  for (auto& level : scene.levels) level = static_cast<std::uint8_t>(level + 40);
  frame->step(scene.levels, -1'000'000'000);
  must(frame->run_steps());
  const auto after = must(frame->read_states());
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (scene.compiled.types[scene.compiled.fixtures[i].type].pan_speed_max > 0) {
      CHECK(after[i].pan.position == before[i].pan.position);
    }
    CHECK(after[i].strobe_phase == before[i].strobe_phase);
  }
}

}  // namespace
}  // namespace footlight::render

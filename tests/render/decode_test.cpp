// Fixture states from levels on the GPU, compared with the walker in float and in double.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <type_traits>

#include "fixtures/builtin/builtin.h"
#include "fixtures/simulate/vrsl_compat.h"
#include "fixtures/simulate/walker.h"
#include "tests/fixtures/compile/macro_wash.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

bool equal_bits(float a, float b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

struct Differences {
  double position = 0;      // rad, of joints, zoom, gobos and motors
  double speed = 0;         // of motors, rad/s
  double light = 0;         // red, green, blue, and the states of lamps
  double kelvin = 0;        // of filaments
  std::int64_t phases = 0;  // how many phases of spins, strobes and gobos differ
  std::int64_t bits = 0;    // how many floats differ in any bit
  std::int64_t compared = 0;
  void print(const char* what) const {
    std::fprintf(stderr,
                 "%s: position %.3g rad, speed %.3g rad/s, light %.3g, %.3g K, phases %lld, "
                 "bits %lld of %lld\n",
                 what, position, speed, light, kelvin, static_cast<long long>(phases), static_cast<long long>(bits),
                 static_cast<long long>(compared));
  }
  template <class Other>
  void add(double& worst, float a, Other b) {
    REQUIRE(std::isfinite(a));
    worst = std::max(worst, std::abs(static_cast<double>(a) - static_cast<double>(b)));
    bits += !equal_bits(a, static_cast<float>(b));
    ++compared;
  }
};

template <class Walker>
void compare(Frame& frame, const Walker& walker, Differences& d) {
  const auto states = must(frame.read_states());
  const auto motors = must(frame.read_motors());
  const auto spins = must(frame.read_spins());
  const auto shutters = must(frame.read_shutters());
  REQUIRE(states.size() == walker.states.size());
  REQUIRE(motors.size() == walker.motors.size());
  REQUIRE(spins.size() == walker.spins.size());
  REQUIRE(shutters.size() == walker.shutters.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    const auto& a = states[i];
    const auto& b = walker.states[i];
    d.add(d.position, a.pan, b.pan);
    d.add(d.position, a.tilt, b.tilt);
    d.add(d.position, a.turn, b.turn);
    d.add(d.position, a.zoom, b.zoom);
    d.add(d.light, a.red, b.red);
    d.add(d.light, a.green, b.green);
    d.add(d.light, a.blue, b.blue);
    d.add(d.light, a.exposure_s, b.exposure_s);
    d.phases += a.beams != b.beams;
    d.phases += a.started != b.started;
  }
  const auto optics = must(frame.read_optics());
  REQUIRE(optics.size() == walker.optics_states.size());
  for (std::size_t i = 0; i < optics.size(); ++i) {
    const auto& a = optics[i];
    const auto& b = walker.optics_states[i];
    d.phases += a.image_1 != b.image_1 || a.image_2 != b.image_2 || a.prism != b.prism || a.prism_2 != b.prism_2;
    d.add(d.light, a.iris, b.iris);
    d.add(d.light, a.frost, b.frost);
    for (int blade = 0; blade < 4; ++blade) {
      d.add(d.light, a.blade_a[blade], b.blade_a[blade]);
      d.add(d.light, a.blade_b[blade], b.blade_b[blade]);
      d.add(d.position, a.blade_angle[blade], b.blade_angle[blade]);
    }
    // Angles of spins are not compared with double, as phases are not: after an hour the rounding of the rate matters.
    if constexpr (std::is_same_v<Walker, fixtures::f32::Walker>) {
      d.add(d.position, a.angle_1, b.angle_1);
      d.add(d.position, a.angle_2, b.angle_2);
      d.add(d.position, a.prism_angle, b.prism_angle);
      d.add(d.position, a.prism_2_angle, b.prism_2_angle);
    }
  }
  for (std::size_t i = 0; i < motors.size(); ++i) {
    d.add(d.position, motors[i].now.position, walker.motors[i].now.position);
    d.add(d.speed, motors[i].now.speed, walker.motors[i].now.speed);
  }
  const auto filaments = must(frame.read_tungsten_states());
  REQUIRE(filaments.size() == walker.tungsten_states.size());
  for (std::size_t i = 0; i < filaments.size(); ++i)
    d.add(d.kelvin, filaments[i].kelvin, walker.tungsten_states[i].kelvin);
  const auto leds = must(frame.read_led_states());
  REQUIRE(leds.size() == walker.led_states.size());
  for (std::size_t i = 0; i < leds.size(); ++i) {
    d.add(d.light, leds[i].level, walker.led_states[i].level);
    d.add(d.light, leds[i].heat, walker.led_states[i].heat);
  }
  const auto discharges = must(frame.read_discharge_states());
  REQUIRE(discharges.size() == walker.discharge_states.size());
  for (std::size_t i = 0; i < discharges.size(); ++i) {
    d.add(d.light, discharges[i].warm, walker.discharge_states[i].warm);
    d.phases +=
        discharges[i].lit != walker.discharge_states[i].lit || discharges[i].power != walker.discharge_states[i].power;
  }
  const auto smooths = must(frame.read_smooths());
  REQUIRE(smooths.size() == walker.smooths.size());
  for (std::size_t i = 0; i < smooths.size(); ++i) {
    d.add(d.position, smooths[i].now.position, walker.smooths[i].now.position);
    d.add(d.speed, smooths[i].now.speed, walker.smooths[i].now.speed);
  }
  const auto dowsers = must(frame.read_dowsers());
  REQUIRE(dowsers.size() == walker.dowsers.size());
  for (std::size_t i = 0; i < dowsers.size(); ++i) d.add(d.light, dowsers[i].level, walker.dowsers[i].level);
  for (std::size_t i = 0; i < spins.size(); ++i) d.phases += spins[i].phase != walker.spins[i].phase;
  for (std::size_t i = 0; i < shutters.size(); ++i) {
    d.phases += shutters[i].phase != walker.shutters[i].phase;
    d.phases += shutters[i].period != walker.shutters[i].period;
  }
}

void randomise(std::vector<std::uint8_t>& levels, Random& random) {
  for (auto& level : levels) level = static_cast<std::uint8_t>(random.next());
}

// Colours between two slots of a wheel are the driver's acos, up to 5e-6 from the walker's. So the built-in types with
// such a wheel keep their own.
void keep_colors(Scene& scene) {
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    const auto type = static_cast<std::size_t>(scene.rig.fixtures[i].type);
    const std::string& id = scene.rig.types[type].id;
    if (id == "generic/scanner" || id == "generic/followspot") scene.set(i, "Color1", 0);
  }
}

// Resets the states to those before the first step.
void reset_states(vk::Device& device, Frame& frame) {
  must(device.run_once([&](VkCommandBuffer commands) { forget_states(commands, frame.resources()); }));
}

// A step of 0 s has no arithmetic that a compiler could contract or reorder on lavapipe. Other drivers may round mix()
// differently, by 2^-23 of the larger end, and the largest end is 270 degrees.
constexpr double kDecodeMax = 1e-6;
// Against double: tables contain floats, 2^-24 of 4.7 rad, and mix() rounds twice.
constexpr double kDecodeJudgeMax = 2e-6;
// Motors, over 400 steps. Measured on lavapipe: 1.6e-6 rad and 5.0e-6 rad/s against the walker in float, where one in
// 60 floats differs in a bit (square root and quotients of the driver), 4.2e-6 rad and 1.2e-5 rad/s against double.
// Errors do not accumulate, because every arrival is exact. The bounds are four times the measured values.
constexpr double kMotionMax = 1.7e-5;     // rad
constexpr double kMotionSpeedMax = 5e-5;  // rad/s

// Lamps, over 300 steps. Measured on lavapipe: 0.0029 K and 7.9e-6 of full light against the walker in float, 0.0024 K
// and 5.9e-6 against double. The bounds are four times that.
constexpr double kLampKelvinMax = 0.012;
constexpr double kLampLightMax = 3.2e-5;

TEST_CASE("random levels give the walker's states on the GPU, for the demo rig and every built-in mode") {
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
      reset_states(vulkan.device(), *frame);
      frame->step(scene.levels, 0);
      must(frame->run_steps());
      compare(*frame, walker, to_float);
      compare(*frame, judge, to_double);
    }
    to_float.print("decode, to the walker in float");
    to_double.print("decode, to the walker in double");
    if (vulkan.device().is_software()) CHECK(to_float.bits == 0);
    CHECK(to_float.position <= kDecodeMax);
    CHECK(to_float.speed == 0);
    CHECK(to_float.light <= kDecodeMax);
    CHECK(to_float.phases == 0);
    CHECK(to_double.position <= kDecodeJudgeMax);
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
      if (random.below(8) == 0) {
        randomise(scene.levels, random);
        keep_colors(scene);
      }
      const std::int64_t dt_ns = lengths_ns[random.below(round % 40 == 0 ? std::size(lengths_ns) : 6)];
      const bool new_exposure = random.below(3) != 0;
      frame->step(scene.levels, dt_ns, new_exposure);
      walker.step(scene.levels, dt_ns, new_exposure);
      judge.step(scene.levels, dt_ns, new_exposure);
      if (random.below(3) != 0) continue;  // several steps in one command buffer
      must(frame->run_steps());
      compare(*frame, walker, to_float);
      compare(*frame, judge, to_double);
      for (const auto& motor : walker.motors) moving += motor.now.speed != 0;
      for (const auto& shutter : walker.shutters) strobing += shutter.phase != fixtures::f32::Turns(0, 0);
    }
    to_float.print("motion, to the walker in float");
    to_double.print("motion, to the walker in double");
    // Random levels strobe most fixtures, and heads with new targets move.
    CHECK(moving > 50);
    CHECK(strobing > 50);
    CHECK(to_float.position <= kMotionMax);
    CHECK(to_float.speed <= kMotionSpeedMax);
    // On GPUs that round quotients differently, such as an H100, a strobe's rate differs in its last digit.
    if (vulkan.device().is_software()) {
      CHECK(to_float.light <= kDecodeMax);
      CHECK(to_float.phases == 0);
    }
    CHECK(to_double.position <= kMotionMax);
    CHECK(to_double.speed <= kMotionSpeedMax);
    // Light and phases are not compared with double: a float holds the fraction of a strobe's rate to 6e-8 Hz, so after
    // an hour the shutter can be open in one and closed in the other.
  }
}

TEST_CASE("lamps of every kind, dimmers of every law and smoothed heads follow the walker over steps of every length") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = time_scene();
  REQUIRE(scene.compiled.needs.tungsten);
  REQUIRE(scene.compiled.needs.led);
  REQUIRE(scene.compiled.needs.discharge);
  REQUIRE(scene.compiled.needs.dowser);
  REQUIRE(scene.compiled.needs.flex);
  REQUIRE(scene.compiled.needs.smooth);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  fixtures::f32::Walker walker(scene.compiled);
  fixtures::f64::Walker judge(scene.compiled);
  Random random(9);
  Differences to_float;
  Differences to_double;
  int warm = 0;
  const std::int64_t lengths_ns[] = {0, kMs, 22'727'272, 40 * kMs, 200 * kMs, 60'000 * kMs};
  for (int round = 0; round < 300; ++round) {
    if (random.below(6) == 0) randomise(scene.levels, random);
    const std::int64_t dt_ns = lengths_ns[random.below(round % 20 == 0 ? std::size(lengths_ns) : 5)];
    frame->step(scene.levels, dt_ns);
    walker.step(scene.levels, dt_ns);
    judge.step(scene.levels, dt_ns);
    if (random.below(2) != 0) continue;
    must(frame->run_steps());
    compare(*frame, walker, to_float);
    compare(*frame, judge, to_double);
    for (const auto& filament : walker.tungsten_states) warm += filament.kelvin > 1500 && filament.kelvin < 3000;
  }
  to_float.print("lamps, to the walker in float");
  to_double.print("lamps, to the walker in double");
  CHECK(warm > 20);
  CHECK(to_float.kelvin <= kLampKelvinMax);
  CHECK(to_float.light <= kLampLightMax);
  CHECK(to_float.position <= kMotionMax);
  CHECK(to_double.position <= kMotionMax);
  CHECK(to_double.kelvin <= kLampKelvinMax);
  CHECK(to_double.light <= kLampLightMax);
  CHECK(to_float.phases == 0);
}

// Irises with and without a motor, frosts, wheels with random slots and one that shakes, each together with the other
// functions of its channel.
Scene optics_effects_scene() {
  using fixtures::ChannelFunction;
  fixtures::FixtureType type;
  type.name = type.id = "test/dials";
  type.beams.push_back({});
  fixtures::Wheel wheel;
  wheel.name = "W";
  for (const char* image : {"", "builtin:dots", "builtin:bars", "builtin:star", "builtin:dots"}) {
    fixtures::WheelSlot slot;
    slot.name = image;
    slot.image = image;
    wheel.slots.push_back(slot);
  }
  type.wheels = {wheel};
  fixtures::Mode mode;
  mode.name = "m";
  mode.geometries = fixtures::simple_geometries(0, 0);
  const auto function = [](const char* attribute, std::uint32_t from, std::uint32_t to, double a, double b) {
    ChannelFunction one;
    one.name = one.attribute = attribute;
    one.dmx_from = from;
    one.dmx_to = to;
    one.physical_from = a;
    one.physical_to = b;
    const std::string_view name(attribute);
    if (name.starts_with("Gobo") || name.starts_with("Anim") || name.starts_with("Color")) one.wheel = 0;
    if (name == "IrisPulseOpen" || name == "IrisStrobe") {
      one.details = {{fixtures::DetailKind::kDutyCycle, 0.3, 0.6, fixtures::kNoIndex},
                     {fixtures::DetailKind::kTimeOffset, 0.8, 0.8, fixtures::kNoIndex}};
    }
    if (name == "Gobo1" || name == "Color1" || name == "AnimationWheel1SelectShake") {
      one.sets = {{"a", from, (from + to) / 2, a, b, 2}, {"b", (from + to) / 2 + 1, to, a, b, 4}};
    }
    return one;
  };
  const std::vector<std::vector<ChannelFunction>> channels = {
      {function("Iris", 0, 60, 1, 0.2), function("IrisPulse", 61, 100, 0.3, 7),
       function("IrisPulseOpen", 101, 140, 1, 9), function("IrisPulseClose", 141, 180, 0, 5),
       function("IrisRandomPulse", 181, 220, 0.2, 5), function("IrisStrobe", 221, 230, 0.2, 5),
       function("IrisStrobeRandom", 231, 255, 0.3, 12)},
      {function("Frost1", 0, 99, 0, 1), function("Frost1PulseOpen", 100, 255, 0.2, 6)},
      {function("Frost2Ramp", 0, 255, 0, 2)},
      {function("Gobo1", 0, 99, 0, 0), function("Gobo1WheelRandom", 100, 255, 0.2, 3)},
      {function("Color1", 0, 99, 0, 0), function("Color1WheelRandom", 100, 255, 0.2, 3)},
      {function("AnimationWheel1SelectShake", 0, 149, 1, 4), function("AnimationWheel1Random", 150, 255, 0.4, 3)},
      {function("Focus1", 0, 255, 0, 1)},
      {function("Focus1Adjust", 0, 255, 0, 1)}};
  for (const auto& functions : channels) {
    fixtures::Channel channel;
    channel.name = functions.front().attribute;
    channel.geometry = fixtures::kSimpleHead;
    channel.slot_offsets = {mode.slot_count++};
    channel.functions = functions;
    mode.channels.push_back(channel);
  }
  type.modes.push_back(mode);
  fixtures::FixtureType at_once = type;
  at_once.id = "test/dials-at-once";
  for (fixtures::Channel& channel : at_once.modes[0].channels) {
    for (ChannelFunction& each : channel.functions) each.instant = true;
  }
  Scene scene;
  scene.rig.name = "dials";
  scene.rig.types = {type, at_once};
  for (int i = 0; i < 40; ++i) {
    fixtures::PatchedFixture fixture;
    fixture.name = std::to_string(i);
    fixture.type = i % 2;
    fixture.address = static_cast<Address>(1 + 8 * i);
    scene.rig.fixtures.push_back(fixture);
  }
  scene.rig.cameras.emplace_back();
  scene.compiled = must(fixtures::compile(scene.rig));
  scene.camera = scene.rig.cameras.front();
  scene.levels.assign(scene.compiled.universes.size() * kSlotCountMax, 0);
  return scene;
}

TEST_CASE("pulses, random slots, shakes and trims follow the walker over steps of every length, phases to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = optics_effects_scene();
  REQUIRE(scene.compiled.needs.pulses);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  fixtures::f32::Walker walker(scene.compiled);
  Random random(11);
  Differences to_float;
  int between = 0;
  const std::int64_t lengths_ns[] = {0, kMs, 22'727'272, 40 * kMs, 200 * kMs, 60'000 * kMs};
  for (int round = 0; round < 300; ++round) {
    if (random.below(6) == 0) randomise(scene.levels, random);
    const std::int64_t dt_ns = lengths_ns[random.below(round % 20 == 0 ? std::size(lengths_ns) : 5)];
    frame->step(scene.levels, dt_ns);
    walker.step(scene.levels, dt_ns);
    if (random.below(2) != 0) continue;
    must(frame->run_steps());
    compare(*frame, walker, to_float);
    const auto optics = must(frame->read_optics());
    for (std::size_t i = 0; i < optics.size(); ++i) {
      to_float.phases += optics[i].animation != walker.optics_states[i].animation;
      to_float.add(to_float.position, optics[i].animation_angle, walker.optics_states[i].animation_angle);
      to_float.add(to_float.light, optics[i].focus, walker.optics_states[i].focus);
      between += optics[i].iris > 0.3f && optics[i].iris < 0.9f;
    }
  }
  to_float.print("dials, to the walker in float");
  CHECK(between > 500);
  CHECK(to_float.position <= kMotionMax);
  CHECK(to_float.speed <= kMotionSpeedMax);
  CHECK(to_float.light <= kMotionMax);  // irises with a motor
  CHECK(to_float.phases == 0);
}

// One fixture for each level: a dimmer law, a kind of pulse, kelvins and metres, over the whole range of a channel.
Scene constants_scene() {
  fixtures::FixtureType type;
  type.name = type.id = "test/constants";
  type.beams.push_back({});
  type.beams[0].lamp = fixtures::LampType::kIdeal;
  fixtures::Mode mode;
  mode.name = "m";
  mode.geometries = fixtures::simple_geometries(0, 0);
  const struct {
    const char* attribute;
    double from, to;
  } rows[] = {{"DimmerCurve", 1, 1}, {"IrisPulse", 1, 1}, {"CTC", 2800, 8000}, {"Focus1Distance", 2, 20}};
  for (const auto& row : rows) {
    fixtures::ChannelFunction function;
    function.name = function.attribute = row.attribute;
    if (function.attribute == "DimmerCurve") function.name = "Inverse square law";
    function.physical_from = row.from;
    function.physical_to = row.to;
    function.instant = true;
    fixtures::Channel channel;
    channel.name = row.attribute;
    channel.geometry = fixtures::kSimpleHead;
    channel.slot_offsets = {mode.slot_count++};
    channel.functions = {function};
    mode.channels.push_back(channel);
  }
  fixtures::ChannelFunction dimmer;
  dimmer.name = dimmer.attribute = "Dimmer";
  dimmer.physical_from = dimmer.physical_to = 0.25;
  mode.channels.push_back(mode.channels[0]);
  mode.channels.back().slot_offsets = {mode.slot_count++};
  mode.channels.back().functions = {dimmer};
  type.modes.push_back(mode);
  Scene scene;
  scene.rig.name = "constants";
  scene.rig.types = {type};
  for (int level = 0; level < 256; ++level) {
    fixtures::PatchedFixture fixture;
    fixture.name = std::to_string(level);
    fixture.universe = 1 + level / 100;
    fixture.address = static_cast<Address>(1 + 5 * (level % 100));
    scene.rig.fixtures.push_back(fixture);
  }
  scene.rig.cameras.emplace_back();
  scene.compiled = must(fixtures::compile(scene.rig));
  scene.camera = scene.rig.cameras.front();
  scene.levels.assign(scene.compiled.universes.size() * kSlotCountMax, 0);
  for (int level = 0; level < 256; ++level) {
    for (int slot = 0; slot < 5; ++slot)
      scene.levels[static_cast<std::size_t>(512 * (level / 100) + 5 * (level % 100) + slot)] =
          static_cast<std::uint8_t>(level);
  }
  return scene;
}

TEST_CASE(
    "dimmer laws, kinds of pulses, kelvins and metres on the GPU equal the walker's at every level of their range") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = constants_scene();
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  fixtures::f32::Walker walker(scene.compiled);
  Differences to_float;
  for (const std::int64_t dt_ns : {std::int64_t{0}, 250 * kMs}) {
    frame->step(scene.levels, dt_ns);
    walker.step(scene.levels, dt_ns);
  }
  must(frame->run_steps());
  compare(*frame, walker, to_float);
  const auto optics = must(frame->read_optics());
  const auto states = must(frame->read_states());
  for (std::size_t i = 0; i < optics.size(); ++i) {
    CAPTURE(i);
    to_float.phases += !equal_bits(optics[i].focus, walker.optics_states[i].focus);
    const double metres = 2 + 18 * static_cast<double>(i) / 255;
    CHECK(1 / static_cast<double>(optics[i].focus) == doctest::Approx(metres).epsilon(1e-6));
    // A quarter of a second into a triangle of 1 Hz of an iris that closes completely.
    CHECK(static_cast<double>(optics[i].iris) == doctest::Approx(0.5).epsilon(1e-5));
    CHECK(states[i].green > 0.1f);
  }
  to_float.print("constants, to the walker in float");
  CHECK(to_float.light <= kDecodeMax);
  CHECK(to_float.phases == 0);
}

TEST_CASE("macros and programs of colours follow the walker over steps of every length, phases to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene;
  scene.rig.types = {fixtures::macro_wash()};
  for (int i = 0; i < 40; ++i) {
    fixtures::PatchedFixture fixture;
    fixture.name = std::to_string(i);
    fixture.address = static_cast<Address>(1 + 5 * i);
    scene.rig.fixtures.push_back(fixture);
  }
  scene.rig.cameras.emplace_back();
  scene.compile();
  REQUIRE(scene.compiled.needs.macro);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  fixtures::f32::Walker walker(scene.compiled);
  Random random(11);
  Differences to_float;
  int colored = 0;
  for (int round = 0; round < 200; ++round) {
    if (random.below(4) == 0) randomise(scene.levels, random);
    const std::int64_t dt_ns = random.below(2) == 0 ? 22'727'272 : static_cast<std::int64_t>(random.below(700)) * kMs;
    frame->step(scene.levels, dt_ns);
    walker.step(scene.levels, dt_ns);
    must(frame->run_steps());
    compare(*frame, walker, to_float);
    for (const auto& state : walker.states) colored += state.red > 0.2f && state.green > 0.2f && state.blue < 0.01f;
  }
  to_float.print("macros, to the walker in float");
  CHECK(colored > 20);
  CHECK(to_float.light <= kDecodeMax);
  CHECK(to_float.phases == 0);
}

// One fixture of each VRSL type that has light, in its first mode; each takes one row of the grid or more.
fixtures::Rig vrsl_rig() {
  fixtures::Rig rig;
  rig.name = "VRSL";
  rig.types = fixtures::vrsl_types();
  std::erase_if(rig.types, [](const fixtures::FixtureType& type) { return type.id == "vrsl/masters"; });
  rig.vrsl.emplace();
  Address address = 1;
  for (std::size_t t = 0; t < rig.types.size(); ++t) {
    fixtures::PatchedFixture fixture;
    fixture.name = rig.types[t].id;
    fixture.type = static_cast<int>(t);
    fixture.address = address;
    fixture.position_m = {static_cast<double>(t) - 5, 3, 5};
    rig.fixtures.push_back(fixture);
    address += (rig.types[t].modes[0].slot_count + 12) / 13 * 13;
  }
  rig.boxes.push_back({"Floor", {-9, -6, -0.1}, {9, 9, 0}, glm::dvec3(0.2)});
  rig.cameras.emplace_back();
  return rig;
}

TEST_CASE("a VRSL show gives the walker's states and, replayed, the same picture") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const fixtures::Rig written = vrsl_rig();
  Scene scene;
  scene.rig = vrsl_shown(written);
  scene.compiled = must(fixtures::compile(scene.rig));
  scene.camera = scene.rig.cameras.front();
  scene.levels.assign(scene.compiled.universes.size() * kSlotCountMax, 0);
  std::vector<ScreenImage> pictures;
  for (int time = 0; time < 2; ++time) {
    const auto frame = make_frame(vulkan.device(), scene, judged_settings(96, 64));
    fixtures::f32::Walker walker(scene.compiled);
    fixtures::VrslReplay replay(written, scene.compiled);
    Random random(9);
    Differences to_float;
    for (int look = 0; look < 20; ++look) {
      randomise(scene.levels, random);
      replay.step(scene.levels, 300 * kMs, true,
                  [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                    frame->step(levels, dt_ns, new_exposure);
                    walker.step(levels, dt_ns, new_exposure);
                  });
      must(frame->run_steps());
      compare(*frame, walker, to_float);
    }
    to_float.print("VRSL's replay, to the walker in float");
    CHECK(to_float.position <= 2e-6);  // over 1,440 degrees
    CHECK(to_float.light <= kDecodeMax);
    CHECK(to_float.phases == 0);
    must(frame->draw(view_of(scene.camera), scene.camera.exposure_ev));
    pictures.push_back(must(frame->read_screen()));
  }
  CHECK(pictures[0].rgba == pictures[1].rgba);
  const auto bright = [](std::uint8_t byte) { return byte > 128 && byte < 255; };
  CHECK(std::any_of(pictures[0].rgba.begin(), pictures[0].rgba.end(), bright));
}

TEST_CASE("a negative time step has no effect") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = demo_scene(3, false);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(8, 8));
  frame->step(scene.levels, 0);
  must(frame->run_steps());
  const auto before = must(frame->read_motors());
  REQUIRE(!before.empty());
  for (auto& level : scene.levels) level = static_cast<std::uint8_t>(level + 40);
  frame->step(scene.levels, -1'000'000'000);
  must(frame->run_steps());
  const auto after = must(frame->read_motors());
  for (std::size_t i = 0; i < after.size(); ++i) CHECK(after[i].now.position == before[i].now.position);
}

}  // namespace
}  // namespace footlight::render

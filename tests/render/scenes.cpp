#include "tests/render/scenes.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "fixtures/builtin/builtin.h"
#include "fixtures/gobos/gobo.h"
#include "fixtures/photometry/attach.h"
#include "fixtures/simulate/encode.h"

namespace footlight::render::testing {
namespace {

using namespace fixtures;

constexpr int kLampSlots = 6;

Channel channel(std::vector<int> slots, const char* attribute, double from, double to, std::uint32_t default_value) {
  Channel c;
  ChannelFunction function{"all", attribute, 0, slots.size() == 2 ? 65535u : 255u, from, to};
  function.instant = true;
  c.functions.push_back(function);
  c.byte_count = static_cast<int>(slots.size());
  c.geometry = kSimpleHead;
  c.slot_offsets = std::move(slots);
  c.default_value = default_value;
  return c;
}

FixtureType lamp_type(double lens_radius_m, int profile_power) {
  FixtureType type;
  type.name = "Lamp";
  type.id = "test/lamp";
  Mode mode;
  mode.name = "6 slots";
  mode.slot_count = kLampSlots;
  mode.geometries = simple_geometries(0, 0);
  mode.channels = {channel({0}, "Dimmer", 0, 1, 255), channel({1}, "ColorAdd_R", 0, 1, 255),
                   channel({2}, "ColorAdd_G", 0, 1, 255), channel({3}, "ColorAdd_B", 0, 1, 255),
                   channel({4, 5}, "Zoom", 0, 60, 20000)};
  type.modes.push_back(std::move(mode));
  Beam beam;
  beam.radius_m = lens_radius_m;
  beam.profile_power = profile_power;
  beam.color_temperature_k = 0;
  type.beams.push_back(beam);
  type.body = BodyModel::kPar;
  return type;
}

}  // namespace

std::span<std::uint8_t> Scene::slots(std::size_t fixture) {
  const auto at = std::find(compiled.universes.begin(), compiled.universes.end(), rig.fixtures[fixture].universe);
  REQUIRE(at != compiled.universes.end());
  return {&levels[static_cast<std::size_t>(at - compiled.universes.begin()) * kSlotCountMax], kSlotCountMax};
}

void Scene::set(std::size_t fixture, std::string_view attribute, double value) {
  REQUIRE(encode_attribute(rig, rig.fixtures[fixture], attribute, value, slots(fixture)));
}

void Scene::compile() {
  compiled = must(fixtures::compile(rig));
  levels.assign(compiled.universes.size() * kSlotCountMax, 0);
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) encode_defaults(rig, rig.fixtures[i], slots(i));
  if (!rig.cameras.empty()) camera = rig.cameras.front();
}

namespace {

// A stage of boxes, which the judge knows: it has no triangles.
std::vector<StageBox> stage_of_boxes() {
  std::vector<StageBox> boxes = {{"Stage floor", {-7, -4, -0.03}, {7, 5, 0}, {0.10, 0.10, 0.11}},
                                 {"House floor", {-16, -24, -1}, {16, 8, -0.03}, {0.08, 0.08, 0.08}},
                                 {"Back wall", {-9, 5, -0.03}, {9, 5.2, 8.5}, {0.13, 0.13, 0.14}},
                                 {"Left riser", {-3.6, 1, 0}, {-1, 2.8, 0.5}, {0.16, 0.16, 0.17}},
                                 {"Right riser", {1, 1, 0}, {3.6, 2.8, 0.5}, {0.16, 0.16, 0.17}},
                                 {"Desk", {-0.8, -0.5, 0}, {0.8, 0.1, 1}, {0.20, 0.20, 0.21}}};
  for (const double y : {3.25, 0.05, -5.55}) {
    boxes.push_back({"Truss", {-6.8, y, 6.05}, {6.8, y + 0.3, 6.35}, {0.35, 0.35, 0.36}});
  }
  for (const double x : {-6.8, 6.55}) {
    for (const double y : {-1.55, 1.25}) {
      boxes.push_back({"Tower", {x, y, -0.03}, {x + 0.25, y + 0.25, 6.05}, {0.30, 0.30, 0.31}});
    }
  }
  return boxes;
}

}  // namespace

Scene demo_scene(std::uint64_t seed, bool with_gobos) {
  Scene scene;
  scene.rig = demo_rig();
  scene.rig.scenery.clear();
  scene.rig.boxes = stage_of_boxes();
  scene.compile();
  Random random(seed);
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    const PatchedFixture& fixture = scene.rig.fixtures[i];
    const std::string& type = scene.rig.types[static_cast<std::size_t>(fixture.type)].id;
    scene.set(i, "Dimmer", random.between(0.4, 1));
    if (type != "generic/profile") {
      for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(i, color, random.between(0.1, 1));
    }
    if (type == "generic/par") continue;
    scene.set(i, "Pan", random.between(-180, 180));
    scene.set(i, "Tilt", random.between(-60, 60));
    scene.set(i, "Zoom", random.between(6, 30));
    if (type == "generic/profile") {
      scene.set(i, "Gobo1", with_gobos ? static_cast<double>(2 + i % 8) : 1.0);
      scene.set(i, "Gobo1PosRotate", 0);
    }
  }
  return scene;
}

Scene all_modes_scene() {
  Scene scene;
  scene.rig.types = builtin_types();
  Address address = 1;
  for (std::size_t t = 0; t < scene.rig.types.size(); ++t) {
    for (std::size_t m = 0; m < scene.rig.types[t].modes.size(); ++m) {
      PatchedFixture fixture;
      fixture.name = scene.rig.types[t].id + " " + std::to_string(m);
      fixture.type = static_cast<int>(t);
      fixture.mode = static_cast<int>(m);
      fixture.address = address;
      fixture.position_m = {static_cast<double>(scene.rig.fixtures.size()), 0, 5};
      if (!scene.rig.types[t].mirror_balls.empty()) fixture.lamps = {"none"};  // their rows: mirrors_test.cpp
      scene.rig.fixtures.push_back(fixture);
      address += scene.rig.types[t].modes[m].slot_count;
    }
  }
  scene.rig.cameras.emplace_back();
  scene.compile();
  return scene;
}

Scene time_scene() {
  Scene scene;
  scene.rig.name = "time";
  scene.rig.haze = {0.02, 0.001, 0.4, 30};
  scene.rig.cameras.push_back({"foh", {0, -14, 3}, {0, 0, 3}, 55, 4});
  const auto add = [&](DimmerLaw law, LampType lamp, const LampModel& model) {
    FixtureType type = lamp_type(0.1, 1);
    Mode& mode = type.modes[0];
    mode.channels = {channel({0, 1}, "Dimmer", 0, 1, 65535), channel({2}, "LampControl", 0, 1, 0)};
    ChannelFunction& control = mode.channels[1].functions[0];
    control.sets = {{"Lamp on", 100, 149, 1, 1, 0}, {"Lamp off", 200, 209, 0, 0, 0}};
    if (lamp == LampType::kLed) {
      for (const auto& [slot, name] :
           {std::pair(3, "ColorAdd_R"), std::pair(4, "ColorAdd_G"), std::pair(5, "ColorAdd_B")})
        mode.channels.push_back(channel({slot}, name, 0, 1, 255));
    }
    type.id = "test/time " + std::to_string(scene.rig.types.size());
    type.dimmer_law = law;
    for (int i = 0; i <= 16; ++i) type.dimmer_table.push_back(std::sqrt(i / 16.0) * i / 16.0);
    type.beams[0].lamp = lamp;
    type.beams[0].model = model;
    type.beams[0].color_temperature_k = lamp == LampType::kHalogen ? 3200 : 6000;
    PatchedFixture fixture;
    fixture.name = type.id;
    fixture.type = static_cast<int>(scene.rig.types.size());
    fixture.address = 1 + kLampSlots * fixture.type;
    fixture.position_m = {2.0 * fixture.type - 7, 0, 5};
    scene.rig.types.push_back(std::move(type));
    scene.rig.fixtures.push_back(fixture);
  };
  LampModel small, phase_cut, pwm, led, arc;
  small.time_constant_s = 0.003;
  phase_cut.supply = LampSupply::kPhaseCut;
  pwm.supply = LampSupply::kPwm;
  led.droop = 0.1;
  led.heat_s = 20;
  arc.ignite_s = 0.5;
  arc.run_up_s = 2;
  arc.cool_s = 1;
  arc.dowser_s = 0.15;
  add(DimmerLaw::kSquare, LampType::kIdeal, {});
  add(DimmerLaw::kLinear, LampType::kHalogen, {});
  add(DimmerLaw::kS, LampType::kHalogen, small);
  add(DimmerLaw::kInverseSquare, LampType::kHalogen, phase_cut);
  add(DimmerLaw::kTable, LampType::kHalogen, pwm);
  add(DimmerLaw::kSquare, LampType::kLed, led);
  add(DimmerLaw::kLinear, LampType::kDischarge, arc);
  // Heads with smoothing, with a belt, and with a speed channel.
  for (const AxisFlex& flex : {AxisFlex{"Pan", 0.1, 0, 0}, AxisFlex{"Pan", 0, 9, 0.05}, AxisFlex{}}) {
    add(DimmerLaw::kLinear, LampType::kIdeal, {});
    FixtureType& type = scene.rig.types.back();
    if (!flex.attribute.empty()) type.flexes = {flex};
    type.smoothing = {{"Dimmer", 0.05}, {"Color", 0.2}};
    type.shutter_travel_s = 0.03;
    Mode& mode = type.modes[0];
    mode.channels = {channel({0}, "Pan", -270, 270, 128),       channel({1}, "Dimmer", 0, 1, 255),
                     channel({2}, "PositionMSpeed", 1, 0.1, 0), channel({3}, "PanTiltMode", 0, 1, 0),
                     channel({4}, "Shutter1Strobe", 1, 20, 0),  channel({5}, "ColorAdd_W", 0, 1, 255)};
    mode.channels[0].geometry = kSimpleYoke;
    mode.channels[0].functions[0].instant = false;
    mode.channels[3].functions[0].sets = {{"Vector", 0, 127, 0, 0, 0}, {"Tracking", 128, 255, 1, 1, 0}};
    ChannelFunction shut{"shut", "Shutter1", 128, 255, 1, 0};
    mode.channels[4].functions[0].dmx_to = 127;
    mode.channels[4].functions.push_back(shut);
  }
  scene.compile();
  return scene;
}

Scene lamps_scene(std::uint64_t seed, int count) {
  Scene scene;
  scene.rig.name = "lamps";
  scene.rig.haze = {0.02, 0.001, 0.4, 30};
  scene.rig.ambient_lx = 0;
  scene.rig.types = {lamp_type(0.02, 1), lamp_type(0.1, 1), lamp_type(0.15, 2)};
  scene.rig.cameras.push_back({"foh", {0, -14, 3}, {0, 0, 3}, 55, 4});
  Random random(seed);
  constexpr int kPerUniverse = kSlotCountMax / kLampSlots;
  for (int i = 0; i < count; ++i) {
    PatchedFixture lamp;
    lamp.name = "Lamp " + std::to_string(i + 1);
    lamp.type = static_cast<int>(random.below(3));
    lamp.universe = 1 + i / kPerUniverse;
    lamp.address = 1 + i % kPerUniverse * kLampSlots;
    lamp.position_m = {random.between(-8, 8), random.between(-6, 8), random.between(0, 7)};
    lamp.rotation_deg = {random.between(-180, 180), random.between(-180, 180), random.between(-180, 180)};
    scene.rig.fixtures.push_back(lamp);
  }
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) {
    for (const auto color : {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"}) scene.set(i, color, random.between(0.2, 1));
    const std::size_t kind = i % 4;
    scene.set(i, "Zoom", kind == 0 ? 0.1 : kind == 1 ? 0.0 : kind == 2 ? random.between(1, 20) : 60.0);
  }
  return scene;
}

Scene lamps_above_boxes(Random& random) {
  Scene scene = lamps_scene(25, 200);
  for (auto& fixture : scene.rig.fixtures) {
    fixture.position_m.z = random.between(6, 10);
    fixture.rotation_deg = {random.between(-30, 30), random.between(-30, 30), 0};
  }
  scene.rig.boxes.push_back({"floor", {-20, -20, -0.2}, {20, 20, 0}, glm::dvec3(0.3)});
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 low(random.between(-6, 6), random.between(-5, 6), random.between(0, 5));
    scene.rig.boxes.push_back({"box", low, low + glm::dvec3(0.6, 0.2, 0.8), glm::dvec3(0.4)});
  }
  return scene;
}

Scene optics_scene(bool with_focus, bool stacked) {
  FixtureType type = lamp_type(0.06, 4);
  type.id = "test/optics";
  Mode& mode = type.modes.front();
  Wheel gobos;
  gobos.name = "Gobos";
  for (const char* image : {"", "builtin:dots", "builtin:bars", "builtin:star"}) {
    WheelSlot slot;
    slot.name = image;
    slot.open = slot.name.empty();
    slot.image = image;
    gobos.slots.push_back(slot);
  }
  Wheel prism;
  prism.name = "Prism";
  prism.slots.resize(2);
  prism.slots[0].open = true;
  for (int i = 0; i < 3; ++i) {
    PrismFacet facet;
    const double angle = 2 * std::numbers::pi * i / 3;
    facet.transform[0][0] = facet.transform[1][1] = 0.7;
    facet.transform[2][0] = std::cos(angle);
    facet.transform[2][1] = std::sin(angle);
    if (stacked) {
      constexpr fixtures::ColorXyY kTints[] = {{0.55, 0.35, 30}, {0.3, 0.5, 60}, {0.2, 0.15, 10}};
      facet.color = kTints[i];
      const double turn = 72 * kDegree * i;
      facet.transform[0] = {0.7 * std::cos(turn), 0.7 * std::sin(turn), 0};
      facet.transform[1] = {-0.7 * std::sin(turn), 0.7 * std::cos(turn), 0};
    }
    prism.slots[1].facets.push_back(facet);
  }
  Wheel second = prism;
  PrismFacet mirrored, turned;
  mirrored.transform = glm::dmat3(-0.8, 0, 0, 0, 0.8, 0, -0.6, 0.1, 1);
  turned.transform =
      glm::dmat3(1.1 * std::cos(0.5), 1.1 * std::sin(0.5), 0, -1.1 * std::sin(0.5), 1.1 * std::cos(0.5), 0, 0.7, 0, 1);
  second.slots[1].facets = {mirrored, turned};
  type.wheels = {gobos, prism, second};
  const auto add = [&](const char* attribute, double from, double to, double at) {
    const int slot = mode.slot_count;
    const auto raw = static_cast<std::uint32_t>(std::lround(65535 * (at - from) / (to - from)));
    mode.channels.push_back(channel({slot, slot + 1}, attribute, from, to, raw));
    mode.slot_count += 2;
  };
  add("Gobo1WheelIndex", 0, 360, 0);
  mode.channels.back().functions.front().wheel = 0;
  add("Gobo1Pos", 0, 360, 0);
  add("Iris", 0, 1, 1);
  add("Frost1", 0, 1, 0);
  if (with_focus) add("Focus1", 0, 1, 1);
  add("AnimationWheel1", 0, 1, 0);
  add("AnimationWheel1Pos", 0, 360, 0);
  for (int blade = 1; blade <= 4; ++blade) {
    for (const char* part : {"A", "Rot"}) {
      const std::string name = "Blade" + std::to_string(blade) + part;
      add(name.c_str(), part[0] == 'A' ? 0 : -45, part[0] == 'A' ? 1 : 45, 0);
    }
  }
  add("Prism1", 0, 1, 0);
  ChannelFunction& prisms = mode.channels.back().functions.front();
  prisms.wheel = 1;
  prisms.sets = {{"open", 0, 32767, 0, 1, 1}, {"in", 32768, 65535, 0, 1, 2}};
  if (stacked) {
    const std::vector<fixtures::ChannelSet> sets = prisms.sets;
    add("Prism2", 0, 1, 0);
    mode.channels.back().functions.front().wheel = 2;
    mode.channels.back().functions.front().sets = sets;
    add("Prism1Pos", 0, 360, 0);
    add("Prism2Pos", 0, 360, 0);
    add("Frost2", 0, 1, 0);
  }
  REQUIRE(problems(type).empty());

  Scene scene;
  scene.rig.name = "optics";
  scene.rig.haze = {0.02, 0.001, 0.4, 30};
  scene.rig.ambient_lx = 0;
  scene.rig.types = {type};
  scene.rig.boxes = {{"wall", {-6, 8, 0}, {6, 8.2, 6}, glm::dvec3(0.5)}};
  scene.rig.cameras.push_back({"side", {5, -3, 3.5}, {0, 5, 3}, 50, 6});
  PatchedFixture lamp;
  lamp.name = "Lamp";
  lamp.position_m = {0, 0, 3};
  lamp.rotation_deg = {90, 0, 0};
  scene.rig.fixtures.push_back(lamp);
  scene.compile();
  scene.set(0, "Zoom", 24);
  return scene;
}

Scene gates_scene(int count) {
  Scene scene = optics_scene(false);
  FixtureType& type = scene.rig.types[0];
  Mode& mode = type.modes[0];
  type.wheels.push_back(type.wheels[0]);
  type.wheels.back().name = "Gobos 2";
  for (const char* attribute : {"Gobo2WheelIndex", "Gobo2Pos"}) {
    mode.channels.push_back(channel({mode.slot_count, mode.slot_count + 1}, attribute, 0, 360, 0));
    mode.slot_count += 2;
  }
  mode.channels[mode.channels.size() - 2].functions.front().wheel = static_cast<int>(type.wheels.size()) - 1;
  REQUIRE(problems(type).empty());
  const PatchedFixture first = scene.rig.fixtures[0];
  for (int i = 1; i < count; ++i) {
    PatchedFixture lamp = first;
    lamp.name = fmt::format("Lamp {}", i + 1);
    lamp.address = first.address + i * mode.slot_count;
    lamp.position_m.x += i;
    scene.rig.fixtures.push_back(lamp);
  }
  scene.compile();
  for (std::size_t i = 0; i < scene.rig.fixtures.size(); ++i) scene.set(i, "Zoom", 24);
  return scene;
}

std::string flood_ies(double away_deg, double width_deg) {
  constexpr double kRad = std::numbers::pi / 180;
  std::string text = "IESNA:LM-63-2002\n[LUMINAIRE] Flood\nTILT=NONE\n1 -1 1 19 13 1 2 0 0 0\n1 1 100\n";
  for (int polar = 0; polar <= 90; polar += 5) text += fmt::format("{} ", polar);
  text += "\n";
  for (int around = 0; around <= 360; around += 30) text += fmt::format("{} ", around);
  text += "\n";
  for (int around = 0; around <= 360; around += 30) {
    for (int polar = 0; polar <= 90; polar += 5) {
      const double up = std::sin(polar * kRad) * std::sin(around * kRad);
      const double along = std::cos(polar * kRad);
      const double cosine = up * std::sin(away_deg * kRad) + along * std::cos(away_deg * kRad);
      const double off = std::acos(std::clamp(cosine, -1.0, 1.0)) / (width_deg * kRad / 2);
      text += fmt::format("{:.2f} ", 20'000 * (std::exp(-off * off) + 0.05 * along));
    }
    text += "\n";
  }
  return text;
}

Scene measured_scene(double away_deg, double width_deg, double zoom_deg) {
  Scene scene;
  scene.rig.name = "measured";
  scene.rig.haze = {0.02, 0.001, 0.4, 30};
  scene.rig.ambient_lx = 0;
  FixtureType type = lamp_type(0.1, 1);
  type.id = "test/flood";
  const std::string text = flood_ies(away_deg, width_deg);
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  Diagnostics diagnostics;
  must(attach_photometry(type, "flood.ies", {first, first + text.size()}, diagnostics));
  FixtureType fixed = type;
  fixed.id = "test/flood-fixed";
  fixed.modes[0].channels.pop_back();  // the zoom
  REQUIRE(problems(type).empty());
  scene.rig.types = {fixed, type};
  scene.rig.boxes = {{"wall", {-6, 4, 0}, {6, 4.2, 6}, glm::dvec3(0.5)},
                     {"floor", {-6, -6, -0.2}, {6, 4, 0}, glm::dvec3(0.2)}};
  scene.rig.cameras.push_back({"side", {4, -5, 2.5}, {0, 3, 2}, 60, 6});
  for (int i = 0; i < 2; ++i) {
    PatchedFixture lamp;
    lamp.name = fmt::format("Flood {}", i + 1);
    lamp.type = i;
    lamp.address = 1 + kLampSlots * i;
    lamp.position_m = {4.0 * i - 2, 0, 3};
    lamp.rotation_deg = {90, 35.0 * i, 0};
    scene.rig.fixtures.push_back(lamp);
  }
  scene.compile();
  scene.set(1, "ColorAdd_G", 0.5);
  scene.set(1, "Zoom", zoom_deg);
  return scene;
}

Scene rectangle_scene(double aspect, double beam_deg, int profile_power) {
  Scene scene = optics_scene(false);
  Beam& beam = scene.rig.types[0].beams[0];
  beam.type = BeamType::kRectangle;
  beam.rectangle_ratio = aspect;
  beam.beam_angle_deg = beam_deg;
  beam.field_angle_deg = beam_deg;
  beam.profile_power = profile_power;
  Mode& mode = scene.rig.types[0].modes[0];
  std::erase_if(mode.channels, [](const Channel& each) { return each.functions[0].attribute == "Zoom"; });
  scene.compile();
  return scene;
}

void dim_lamps(Scene& scene, const std::vector<bool>& lit) {
  REQUIRE(lit.size() == scene.rig.fixtures.size());
  for (std::size_t i = 0; i < lit.size(); ++i) {
    const auto slot = static_cast<std::size_t>(slot_of_address(scene.rig.fixtures[i].address) + kLampDimmerSlot);
    scene.slots(i)[slot] = lit[i] ? 255 : 0;
  }
}

GoboTransmission gobos_of_judge(const Scene& scene) {
  std::vector<int> gobos;
  for (const fixtures::ImageSource& image : scene.compiled.images) {
    for (int gobo = 1; gobo <= fixtures::kGoboCount; ++gobo) {
      if (image.name == std::string(fixtures::kBuiltinImage) + fixtures::gobo_name(gobo)) gobos.push_back(gobo);
    }
  }
  return [gobos](int layer, double x, double y) {
    return fixtures::gobo_transmission(gobos.at(static_cast<std::size_t>(layer - 1)), x, y, kGoboEdge);
  };
}

FrameSettings judged_settings(int width, int height) {
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  settings.bodies = false;
  settings.dark_lm = 0;
  settings.widen_thin = false;
  settings.edge_samples = 0;
  settings.glare = 0;
  settings.tile_error = 0;
  return settings;
}

std::unique_ptr<Frame> make_frame(vk::Device& device, const Scene& scene, const FrameSettings& settings) {
  return must(Frame::create(device, scene.rig, scene.compiled, settings));
}

RadianceImage draw(Frame& frame, const Scene& scene) {
  frame.step(scene.levels, 0);
  must(frame.draw(view_of(scene.camera), scene.camera.exposure_ev));
  return must(frame.read_radiance());
}

RadianceImage draw_new(vk::Device& device, const Scene& scene, const FrameSettings& settings) {
  return draw(*make_frame(device, scene, settings), scene);
}

}  // namespace footlight::render::testing

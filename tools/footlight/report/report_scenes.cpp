#include "tools/footlight/report/report_scenes.h"

#include <cmath>
#include <numbers>

#include "fixtures/files/import/archive.h"
#include "fixtures/gobos/gobo.h"
#include "fixtures/photometry/attach.h"
#include "fixtures/simulate/encode.h"
#include "sim/core/random.h"

namespace footlight::tools {
namespace {

using namespace fixtures;

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kSlots = 10;
constexpr int kGoboSlot = 6;
constexpr double kGoldenShare = 0.6180339887498949;
constexpr int kGoboLevels = 28;  // of each slot of the gobo wheel

// A channel of `bytes` bytes from slot `first` with one function that is linear over the whole range.
Channel channel(int first, int bytes, const char* attribute, double from, double to) {
  Channel c;
  for (int i = 0; i < bytes; ++i) c.slot_offsets.push_back(first + i);
  ChannelFunction function;
  function.name = "all";
  function.dmx_to = fixtures::raw_max(bytes);
  function.attribute = attribute;
  function.instant = true;
  function.physical_from = from;
  function.physical_to = to;
  c.functions.push_back(std::move(function));
  c.byte_count = bytes;
  c.geometry = kSimpleHead;
  return c;
}

// Gobo 1 to 8 of wheel 1 or 2, and which way up it is.
void add_gobos(FixtureType& type, Mode& mode, int number) {
  Wheel wheel;
  wheel.name = fmt::format("Gobos {}", number);
  const int first_slot = kGoboSlot + 2 * (number - 1);
  Channel choice = channel(first_slot, 1, fmt::format("Gobo{}", number).c_str(), 0, 8);
  ChannelFunction& function = choice.functions.front();
  function.wheel = number - 1;
  for (int gobo = 0; gobo <= kGoboCount; ++gobo) {
    WheelSlot slot;
    slot.name = gobo_name(gobo);
    slot.open = gobo == 0;
    if (gobo > 0) slot.image = std::string(kBuiltinImage) + slot.name;
    wheel.slots.push_back(slot);
    const auto first = static_cast<std::uint32_t>(gobo * kGoboLevels);
    function.sets.push_back({slot.name, first, first + kGoboLevels - 1, 0, 0, gobo + 1});
  }
  type.wheels.push_back(wheel);
  mode.channels.push_back(choice);
  mode.channels.push_back(channel(first_slot + 1, 1, fmt::format("Gobo{}Pos", number).c_str(), 0, 360));
}

FixtureType beam_type(double lens_radius_m, int gobos) {
  FixtureType type;
  type.manufacturer = "Footlight";
  type.name = "Report beam";
  type.id = fmt::format("report/beam-{:.0f}mm", lens_radius_m * 1000);
  Mode mode;
  mode.name = "10 slots";
  mode.slot_count = kSlots;
  mode.channels = {channel(0, 2, "Zoom", 1, 52), channel(2, 1, "Dimmer", 0, 1), channel(3, 1, "ColorAdd_R", 0, 1),
                   channel(4, 1, "ColorAdd_G", 0, 1), channel(5, 1, "ColorAdd_B", 0, 1)};
  mode.geometries = simple_geometries(0.01, 0.01);
  for (int wheel = 1; wheel <= gobos; ++wheel) add_gobos(type, mode, wheel);
  type.modes.push_back(std::move(mode));
  Beam beam;
  beam.radius_m = lens_radius_m;
  beam.profile_power = 1;
  beam.color_temperature_k = 0;
  type.beams.push_back(beam);
  type.body = BodyModel::kPar;
  return type;
}

void add_clutter(Rig& rig, int count) {
  SeededNumbers random(2);
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 size{random.between(0.3, 2), random.between(0.3, 2), random.between(0.3, 2)};
    const glm::dvec3 corner{random.between(-25, 25), random.between(-20, 20), 0};
    rig.boxes.push_back({fmt::format("box {}", i + 1), corner, corner + size, glm::dvec3(0.2)});
  }
}

}  // namespace

Result<Scene> make_beams_scene(int count, const std::string& photometry, double gobo_share, int clutter, int wheels) {
  if (count < 1 || count > 1'000'000) return fail(ErrorCode::kBadInput, "{} beams: expected 1 to 1000000", count);
  Scene scene;
  const int gobos = gobo_share > 0 ? wheels : 0;
  scene.name = fmt::format("beams:{}{}", count, gobos > 1 ? ", gates" : gobos > 0 ? ", gobos" : "");
  if (gobos > 0 && gobo_share < 1) scene.name += fmt::format(" in {:g} %", 100 * gobo_share);
  if (clutter > 0) scene.name += fmt::format(", {} boxes", clutter);
  Rig& rig = scene.rig;
  rig.name = scene.name;
  rig.haze = {0.01, 0.0, 0.5, 40};
  rig.ambient_lx = 0.5;
  rig.boxes.push_back({"floor", {-45, -45, -1}, {45, 25, 0}, glm::dvec3(0.2)});
  rig.boxes.push_back({"wall", {-45, 25, 0}, {45, 26, 30}, glm::dvec3(0.2)});
  add_clutter(rig, clutter);
  rig.cameras = {Camera{"foh", {0, -40, 8}, {0, 0, 6}, 50, 10}};
  constexpr int kLenses = 8;
  for (int i = 0; i < kLenses; ++i) rig.types.push_back(beam_type(0.05 + 0.07 * i / (kLenses - 1), gobos));

  if (!photometry.empty()) {
    scene.name += ", " + photometry;
    FL_ASSIGN(const Bytes bytes, read_whole_file(photometry, kPhotometryBytesMax));
    for (FixtureType& type : rig.types) {
      Diagnostics ignored;
      FL_TRY(attach_photometry(type, photometry, bytes, ignored));
      FL_ASSIGN(const Photometry measured, read_photometry_file(type.files, type.beams[0].photometry));
      // The zoom then sets the angle of the edge, as for the other beams.
      type.beams[0].beam_angle_deg = 2 / kDegree * measured_table(measured, Side::kFront, true).half_angle_rad;
    }
  }

  constexpr int kPerUniverse = kSlotCountMax / kSlots;
  SeededNumbers random(1);
  std::vector<double> half_angles_rad;
  std::vector<glm::dvec3> colors;
  std::vector<double> angles;  // of gobos, turns
  for (int i = 0; i < count; ++i) {
    const double kind = random.uniform();
    half_angles_rad.push_back(kDegree * (kind < 0.7   ? random.between(0.75, 2.5)
                                         : kind < 0.9 ? random.between(5, 10)
                                                      : random.between(12, 25)));
    PatchedFixture fixture;
    fixture.name = fmt::format("Beam {}", i + 1);
    fixture.type = static_cast<int>(random.uniform() * kLenses);
    fixture.universe = 1 + i / kPerUniverse;
    fixture.address = 1 + i % kPerUniverse * kSlots;
    fixture.position_m = {random.between(-25, 25), random.between(0, 20),
                          random.uniform() < 0.8 ? random.between(12, 16) : 0.3};
    const glm::dvec3 target{random.between(-30, 30), random.between(-25, 25),
                            random.uniform() < 0.5 ? 0.0 : random.between(0, 20)};
    const glm::dvec3 d = glm::normalize(target - fixture.position_m);
    const double across = std::hypot(d.x, d.y);
    fixture.rotation_deg = glm::dvec3(std::atan2(across, -d.z), 0, across > 0 ? std::atan2(-d.x, d.y) : 0.0) / kDegree;
    rig.fixtures.push_back(fixture);
    colors.emplace_back(random.uniform(), random.uniform(), random.uniform());
    angles.push_back(gobos > 0 ? random.uniform() : 0);
  }
  FL_ASSIGN(scene.compiled, compile(rig));
  scene.levels.assign(scene.compiled.universes.size() * kSlotCountMax, 0);
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const PatchedFixture& fixture = rig.fixtures[index];
    const std::span<std::uint8_t> slots(&scene.levels[std::size_t(fixture.universe - 1) * kSlotCountMax],
                                        kSlotCountMax);
    encode_attribute(rig, fixture, "Zoom", 2 * half_angles_rad[index] / kDegree, slots);
    encode_attribute(rig, fixture, "Dimmer", 1, slots);
    encode_attribute(rig, fixture, "ColorAdd_R", colors[index].x, slots);
    encode_attribute(rig, fixture, "ColorAdd_G", colors[index].y, slots);
    encode_attribute(rig, fixture, "ColorAdd_B", colors[index].z, slots);
    // Spread evenly over the beams, whatever the share.
    const bool has_gobo = gobos > 0 && std::fmod((i + 1) * kGoldenShare, 1.0) <= gobo_share;
    for (int wheel = 0; has_gobo && wheel < gobos; ++wheel) {
      slots[static_cast<std::size_t>(fixture.address - 1 + kGoboSlot + 2 * wheel)] =
          static_cast<std::uint8_t>((1 + (i + wheel) % kGoboCount) * kGoboLevels + kGoboLevels / 2);
    }
    if (has_gobo && gobos == 1) encode_attribute(rig, fixture, "Gobo1Pos", 360 * angles[index], slots);
  }
  scene.camera = rig.cameras.front();
  return scene;
}

}  // namespace footlight::tools

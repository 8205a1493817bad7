// Haze and fog machines in pictures: beams appear when a machine is opened, and nothing else changes.
#include <algorithm>
#include <cstdint>
#include <numeric>

#include "fixtures/simulate/machines.h"
#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr std::int64_t kSecondNs = 1'000'000'000;

// Lamps in clear air and, last, a hazer with a fan. The camera sees only beams.
Scene hazed_scene(bool with_hazer) {
  Scene scene = lamps_scene(12, 10);
  scene.rig.haze = {0, 0, 0.4, 30};
  scene.rig.room.plumes = false;
  if (with_hazer) {
    fixtures::FixtureType type;
    type.id = "test/hazer";
    type.modes.emplace_back();
    fixtures::Mode& mode = type.modes[0];
    mode.name = "all";
    mode.slot_count = 2;
    mode.geometries.emplace_back();
    mode.geometries[0].name = "Body";
    for (const char* attribute : {"Haze1", "Fan1"}) {
      fixtures::Channel channel;
      channel.name = attribute;
      channel.slot_offsets = {static_cast<int>(mode.channels.size())};
      channel.functions.emplace_back();
      channel.functions[0].name = channel.functions[0].attribute = attribute;
      mode.channels.push_back(channel);
    }
    fixtures::PatchedFixture hazer;
    hazer.name = "Hazer";
    hazer.type = static_cast<int>(scene.rig.types.size());
    hazer.universe = 99;
    scene.rig.types.push_back(type);
    scene.rig.fixtures.push_back(hazer);
  }
  const auto levels = scene.levels;
  scene.compile();
  std::copy(levels.begin(), levels.end(), scene.levels.begin());  // the universe of the hazer comes after the others
  return scene;
}

RadianceImage picture(Frame& frame, const Scene& scene) {
  must(frame.draw(view_of(scene.camera), 0));
  return must(frame.read_radiance());
}

double brightness(const RadianceImage& image) { return std::accumulate(image.rgb.begin(), image.rgb.end(), 0.0); }

FrameSettings small() {
  FrameSettings settings;
  settings.width = 64;
  settings.height = 36;
  settings.bodies = false;
  return settings;
}

TEST_CASE("beams appear while a hazer is open, stay when it is closed, and are gone after an hour") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = hazed_scene(true);
  const auto frame = make_frame(vulkan.device(), scene, small());
  const auto brightness_after = [&](double haze, std::int64_t dt_ns) {
    scene.set(scene.rig.fixtures.size() - 1, "Haze1", haze);
    frame->step(scene.levels, dt_ns);
    return brightness(picture(*frame, scene));
  };
  CHECK(brightness_after(0, 0) == 0);
  CHECK(brightness_after(0, 60 * kSecondNs) == 0);
  double before = 0;
  for (int i = 0; i < 6; ++i) {
    const double now = brightness_after(1, 10 * kSecondNs);
    CHECK(now > 1.2 * before);
    before = now;
  }
  CHECK(frame->machine_air()->scattering_per_m() > 1e-3);
  CHECK(brightness_after(0, 60 * kSecondNs) > 0.9 * before);  // haze near the machine is still mixing with the room
  CHECK(brightness_after(0, 3600 * kSecondNs) < 0.02 * before);
}

TEST_CASE("haze of a machine is drawn as equal haze of the rig, and two replays are equal, to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = hazed_scene(true);
  scene.set(scene.rig.fixtures.size() - 1, "Haze1", 0.7);
  scene.set(scene.rig.fixtures.size() - 1, "Fan1", 1);
  const auto whole = make_frame(vulkan.device(), scene, small());
  const auto pieces = make_frame(vulkan.device(), scene, small());
  whole->step(scene.levels, 40 * kSecondNs);
  for (int i = 0; i < 800; ++i) pieces->step(scene.levels, 50 * kMs, i == 0);
  const RadianceImage hazed = picture(*whole, scene);
  CHECK(whole->machine_air()->scattering_per_m() == pieces->machine_air()->scattering_per_m());
  CHECK(brightness(hazed) > 0);

  Scene room = hazed_scene(false);
  room.rig.haze.scattering_per_m = whole->machine_air()->scattering_per_m();
  const auto levels = room.levels;
  room.compile();
  room.levels = levels;
  const auto plain = make_frame(vulkan.device(), room, small());
  plain->step(room.levels, 40 * kSecondNs);
  CHECK(picture(*plain, room).rgb == hazed.rgb);
  CHECK(plain->machine_air() == nullptr);  // without machines there is no object and no cost
}

TEST_CASE("haze of machines is kept when the size changes, and clearing the air restores the start") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = hazed_scene(true);
  scene.set(scene.rig.fixtures.size() - 1, "Haze1", 1);
  const auto first = make_frame(vulkan.device(), scene, small());
  const auto second = make_frame(vulkan.device(), scene, small());
  first->step(scene.levels, 40 * kSecondNs);
  second->step(scene.levels, 40 * kSecondNs);
  FrameSettings larger = small();
  larger.width *= 2;
  must(second->change(larger));
  first->step(scene.levels, kSecondNs);
  second->step(scene.levels, kSecondNs);
  CHECK(first->machine_air()->scattering_per_m() > 0);
  CHECK(first->machine_air()->scattering_per_m() == second->machine_air()->scattering_per_m());
  second->forget_air();
  CHECK(second->machine_air()->scattering_per_m() == 0);
}

}  // namespace
}  // namespace footlight::render

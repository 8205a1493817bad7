// A GPU that stops during its work.
#include <string>

#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

TEST_CASE("a lost device is reported by each call, and a new one draws the same picture") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(80, true);
  const RadianceImage expected = draw_new(vulkan.device(), scene, judged_settings());
  for (const std::uint64_t submits : {std::uint64_t{0}, std::uint64_t{1}}) {
    const auto device = must(vk::Device::create({.validation = true, .name_contains = vulkan.device().name()}));
    const auto frame = make_frame(*device, scene, judged_settings());
    CHECK(!device->lost());
    device->lose_after(submits);
    frame->step(scene.levels, 0);
    Status status = frame->draw(view_of(scene.camera), 0);
    if (submits == 1) {
      CHECK(status);
      status = frame->read_radiance().map([](const RadianceImage&) {});
    }
    REQUIRE(!status);
    CHECK(status.error().code == ErrorCode::kDisconnected);
    CHECK((status.error().message.find("device lost") != std::string::npos));
    CHECK(device->lost());
    CHECK(!frame->draw(view_of(scene.camera), 0));
    CHECK(!frame->read_counts());
    CHECK(!Frame::create(*device, scene.rig, scene.compiled, judged_settings()));
    CHECK(device->validation_messages().empty());
  }
  const auto device = must(vk::Device::create({.validation = true, .name_contains = vulkan.device().name()}));
  CHECK(draw_new(*device, scene, judged_settings()).rgb == expected.rgb);
}

}  // namespace
}  // namespace footlight::render

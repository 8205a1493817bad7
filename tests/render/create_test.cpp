// Errors of creating devices and frames have a reason, and an empty rig gives a black picture.
#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/render/scenes.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Sets an environment variable and restores it.
class WithVariable {
 public:
  WithVariable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name); before != nullptr) before_ = before;
    setenv(name, value, 1);
  }
  ~WithVariable() {
    if (before_) {
      setenv(name_, before_->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  WithVariable(const WithVariable&) = delete;
  WithVariable& operator=(const WithVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST_CASE("without a driver the message names the package that contains one") {
  const WithVariable icd("VK_ICD_FILENAMES", "/nonexistent/no_driver.json");
  const WithVariable drivers("VK_DRIVER_FILES", "/nonexistent/no_driver.json");
  const auto device = vk::Device::create({});
  REQUIRE(!device);
  CHECK(device.error().code == ErrorCode::kUnsupported);
  CHECK(contains(device.error().message, "apt-get install mesa-vulkan-drivers"));
}

TEST_CASE("an unknown device name is refused with the names of all devices") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto device = vk::Device::create({.name_contains = "no such GPU"});
  REQUIRE(!device);
  CHECK(device.error().code == ErrorCode::kUnsupported);
  CHECK(contains(device.error().message, "no such GPU"));
  CHECK(contains(device.error().message, vulkan.device().name()));
}

TEST_CASE("a device can be chosen by a part of its name") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const std::string part = vulkan.device().name().substr(1, 4);
  const auto device = vk::Device::create({.validation = true, .name_contains = part});
  REQUIRE(device);
  CHECK(contains((*device)->name(), part));
  CHECK((*device)->validation_messages().empty());
}

TEST_CASE("validation messages of four threads at the same time are all kept") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const auto device = vk::Device::create({.validation = true});
  REQUIRE(device);
  const auto submit = reinterpret_cast<PFN_vkSubmitDebugUtilsMessageEXT>(
      vkGetInstanceProcAddr((*device)->instance, "vkSubmitDebugUtilsMessageEXT"));
  REQUIRE((submit != nullptr));
  constexpr std::size_t kThreads = 4;
  constexpr std::size_t kMessages = 10;
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < kThreads; ++i) {
      threads.emplace_back([&] {
        VkDebugUtilsMessengerCallbackDataEXT data{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT};
        data.pMessage = "made by a test";
        for (std::size_t m = 0; m < kMessages; ++m) {
          submit((*device)->instance, VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
                 VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT, &data);
        }
      });
    }
  }
  CHECK((*device)->validation_messages().size() == kThreads * kMessages);
}

TEST_CASE("invalid picture sizes are refused with the allowed range") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_scene(40, 1);
  const int too_large = static_cast<int>(vulkan.device().limits().maxImageDimension2D) + 1;
  for (const auto& [width, height] :
       {std::pair(0, 10), std::pair(10, 0), std::pair(-5, 10), std::pair(too_large, 10), std::pair(10, too_large)}) {
    const auto frame = Frame::create(vulkan.device(), scene.rig, scene.compiled, judged_settings(width, height));
    REQUIRE(!frame);
    CHECK(frame.error().code == ErrorCode::kBadInput);
    CHECK(contains(frame.error().message, std::to_string(width) + "x" + std::to_string(height)));
    CHECK(contains(frame.error().message, std::to_string(too_large - 1)));
  }
}

TEST_CASE("node counts without a quadrature rule are refused, any number of march steps is accepted") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_scene(41, 1);
  FrameSettings settings = judged_settings(8, 8);
  for (const std::uint32_t nodes : {0u, 9u, 1000u}) {
    settings.nodes = nodes;
    const auto frame = Frame::create(vulkan.device(), scene.rig, scene.compiled, settings);
    REQUIRE(!frame);
    CHECK(frame.error().code == ErrorCode::kBadInput);
    CHECK(contains(frame.error().message, std::to_string(nodes)));
    CHECK(contains(frame.error().message, "1 to 8"));
  }
  settings.nodes = 1;
  CHECK(Frame::create(vulkan.device(), scene.rig, scene.compiled, settings));
  settings.nodes = 1000;
  settings.method = BeamMethod::kMarch;
  CHECK(Frame::create(vulkan.device(), scene.rig, scene.compiled, settings));
  settings.nodes = 0;
  CHECK(!Frame::create(vulkan.device(), scene.rig, scene.compiled, settings));
}

TEST_CASE("an unreadable gobo is reported, and another one is used") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene = demo_scene(42, true);
  const auto light = [&](const fixtures::ImageSource& all) {
    for (fixtures::ImageSource& image : scene.compiled.images) image = all;
    const RadianceImage picture = draw_new(vulkan.device(), scene, judged_settings());
    return std::accumulate(picture.rgb.begin(), picture.rgb.end(), 0.0);
  };
  REQUIRE(!scene.compiled.images.empty());
  const double bars = light({nullptr, "builtin:bars"});
  const double gone = light({nullptr, "gone.svg"});
  CHECK(gone > 0.2 * bars);
  CHECK(gone < 2 * bars);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings());
  REQUIRE(frame->resources().rig.diagnostics.size() == scene.compiled.images.size());
  CHECK(frame->resources().rig.diagnostics[0].code == "image-file");
  CHECK(contains(frame->resources().rig.diagnostics[0].message, "gone.svg"));
}

TEST_CASE("an empty rig renders black without a pass") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Scene scene;
  scene.rig.cameras.emplace_back();
  scene.compile();
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(20, 10));
  CHECK(frame->plan().empty());
  CHECK(draw(*frame, scene).rgb == std::vector<float>(20 * 10 * 3, 0.0f));
  must(frame->run_steps());
  CHECK(must(frame->read_states()).empty());
  CHECK(must(frame->read_beams()).empty());
  std::vector<std::uint8_t> black(20 * 10 * 4, 0);
  for (std::size_t i = 3; i < black.size(); i += 4) black[i] = 255;
  CHECK(must(frame->read_screen()).rgba == black);
}

TEST_CASE("a frame that was never stepped is dark") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = lamps_scene(42, 70);
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(20, 10));
  must(frame->draw(view_of(scene.camera), 4));
  CHECK(must(frame->read_counts()).live_count == 0);
  CHECK(must(frame->read_radiance()).rgb == std::vector<float>(20 * 10 * 3, 0.0f));
}

TEST_CASE("a picture reports the time of each pass, in order") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Scene scene = demo_scene(43, true);
  FrameSettings settings;
  settings.width = 64;
  settings.height = 36;
  const auto frame = make_frame(vulkan.device(), scene, settings);
  CHECK(must(frame->read_times()).empty());  // nothing recorded
  (void)draw(*frame, scene);
  const auto times = must(frame->read_times());
  REQUIRE(times.size() == frame->plan().size() + 1);
  CHECK(times[0].name == "levels");
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (i > 0) CHECK(times[i].name == frame->plan()[i - 1].name);
    CHECK(times[i].gpu_ms >= 0);
    CHECK(times[i].gpu_ms < 60'000);
  }
}

TEST_CASE("a rig of more beams than lavapipe can add up has a warning, and one of few has none") {
  const HeadlessVulkan vulkan;
  if (!vulkan || !contains(vulkan.device().name(), "llvmpipe")) return;
  for (const int count : {10, 1100}) {
    const Scene scene = lamps_scene(31, count);
    const auto frame = make_frame(vulkan.device(), scene, judged_settings(16, 16));
    const auto& found = frame->resources().rig.diagnostics;
    CHECK(std::count_if(found.begin(), found.end(), [](const auto& one) { return one.code == "many-beams"; }) ==
          (count > 1024 ? 1 : 0));
  }
}

}  // namespace
}  // namespace footlight::render

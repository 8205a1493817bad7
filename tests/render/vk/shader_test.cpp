// Bindings read from the SPIR-V of shaders.
#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/frame.h"
#include "render/vk/demands.h"
#include "render/vk/shader.h"
#include "tests/support/must.h"

namespace footlight::render {
namespace {

using footlight::testing::must;
using vk::ShaderBinding;

constexpr VkDescriptorType kBuffer = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
constexpr VkDescriptorType kUniform = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
constexpr VkDescriptorType kImage = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
constexpr VkDescriptorType kSampled = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;

vk::ShaderInterface interface_of(const std::string& pass, std::size_t pipeline = 0) {
  for (const PassShaders& each : pass_shaders()) {
    if (each.name == pass) return must(vk::read_interfaces(each.pipelines.at(pipeline)));
  }
  FAIL("no pass " << pass);
  return {};
}

TEST_CASE("each pass stays within the descriptors that a device must have") {
  std::uint32_t most = 0;
  for (const PassShaders& pass : pass_shaders()) {
    INFO(pass.name);
    REQUIRE(!pass.pipelines.empty());
    for (const auto& stages : pass.pipelines) {
      const vk::ShaderInterface shader = must(vk::read_interfaces(stages));
      const std::uint32_t buffers = vk::count_of(shader, kBuffer);
      most = std::max(most, buffers);
      CHECK(!shader.bindings.empty());
      CHECK(buffers <= vk::kStorageBuffersMax);
      CHECK(vk::count_of(shader, kImage) <= vk::kStorageImagesMax);
      CHECK(vk::count_of(shader, kSampled) <= vk::kSamplersMax);
      CHECK(shader.push_bytes <= 128);  // the least that Vulkan guarantees
      for (const ShaderBinding& binding : shader.bindings) CHECK(binding.binding < FL_BINDING_COUNT);
    }
  }
  CHECK(most == 25);  // the value in render/vk/demands.h
}

TEST_CASE("a pipeline's interface has exactly the bindings that its shaders declare") {
  const vk::ShaderInterface tonemap = interface_of("tonemap", 2);  // behind the two of the meter
  CHECK(tonemap.bindings == std::vector<ShaderBinding>{{FL_BINDING_PARAMS, kUniform},
                                                       {FL_BINDING_RADIANCE, kImage},
                                                       {FL_BINDING_SCREEN, kImage},
                                                       {FL_BINDING_METER, kBuffer}});
  CHECK(tonemap.push_bytes == 36);
  CHECK(interface_of("tonemap", 0).push_bytes == 0);
  CHECK(interface_of("step").push_bytes == 12);
  for (const std::size_t with_gobos : {0u, 1u}) {
    const auto beams = interface_of("beams", with_gobos).bindings;
    const auto count = [&](const ShaderBinding& binding) { return std::count(beams.begin(), beams.end(), binding); };
    for (const std::uint32_t binding :
         std::initializer_list<std::uint32_t>{FL_BINDING_GOBOS, FL_BINDING_GOBO_WHOLE, FL_BINDING_GOBO_LINES,
                                              FL_BINDING_GOBO_BLURS, FL_BINDING_GATE_IMAGES}) {
      CHECK(count({binding, kSampled}) == static_cast<std::ptrdiff_t>(with_gobos));
    }
    CHECK(count({FL_BINDING_MOTORS, kBuffer}) == 0);
  }
}

TEST_CASE("the stages of a pipeline share a binding of one type") {
  const auto shaders = pass_shaders();
  const auto bodies = std::find_if(shaders.begin(), shaders.end(), [](const auto& p) { return p.name == "bodies"; });
  REQUIRE((bodies != shaders.end()));
  const vk::Spirv vertex = bodies->pipelines.at(0).at(0);
  const std::vector<vk::Spirv> twice{vertex, vertex};
  CHECK(must(vk::read_interfaces(twice)).bindings == must(vk::read_interface(vertex)).bindings);
}

TEST_CASE("truncated SPIR-V is refused or read, and never read past its end") {
  const vk::Spirv whole = pass_shaders().back().pipelines.at(0).at(0);
  const std::vector<std::uint32_t> words(whole.begin(), whole.end());
  for (std::size_t length = 0; length < words.size(); length += 7) {
    const std::vector<std::uint32_t> part(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(length));
    (void)vk::read_interface(part);
  }
  CHECK(!vk::read_interface(vk::Spirv{}));
  std::vector<std::uint32_t> other = words;
  other[0] = 0;
  CHECK(!vk::read_interface(other));
  other = words;
  other[5] &= 0xffff;  // an instruction with a length of 0 words
  CHECK(!vk::read_interface(other));
}

}  // namespace
}  // namespace footlight::render

// The interface of a shader, read from its SPIR-V: bindings and push constants. C++ does not repeat what the shader
// declares.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <vulkan/vulkan.h>

#include "sim/core/result.h"

namespace footlight::render::vk {

using Spirv = std::span<const std::uint32_t>;

struct ShaderBinding {
  std::uint32_t binding = 0;
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  bool operator==(const ShaderBinding&) const = default;
};

struct ShaderInterface {
  std::vector<ShaderBinding> bindings;  // ascending; all in descriptor set 0
  std::uint32_t push_bytes = 0;         // 0: the shader has no push constants
};

// Buffers, storage images and combined image samplers, one descriptor each; push constants of 32-bit scalars.
// kUnsupported for anything else, kBadInput for words that are no SPIR-V.
[[nodiscard]] Result<ShaderInterface> read_interface(Spirv spirv);
// The interface of a pipeline of several stages. A binding has the same type in all of them.
[[nodiscard]] Result<ShaderInterface> read_interfaces(std::span<const Spirv> stages);

// Descriptors of one type.
[[nodiscard]] std::uint32_t count_of(const ShaderInterface& shader, VkDescriptorType type);

}  // namespace footlight::render::vk

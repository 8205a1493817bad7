// Pipelines and the one descriptor set that they share. Move-only owners; the device must outlive them.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "render/vk/device.h"
#include "render/vk/memory.h"

namespace footlight::render::vk {

// Specialisation constants by id; booleans are 0 and 1.
struct SpecConstant {
  std::uint32_t id = 0;
  std::uint32_t value = 0;
  bool operator==(const SpecConstant&) const = default;
};

// One set with bindings 0..n-1, of which each has a fixed type. A binding that no pipeline in use reads may stay unset.
class BindingSet {
 public:
  BindingSet() = default;
  // types[i]: the type of binding i. push_bytes: size of the push constants of every pipeline.
  [[nodiscard]] static Result<BindingSet> create(Device& device, std::span<const VkDescriptorType> types,
                                                 std::uint32_t push_bytes);
  ~BindingSet();
  BindingSet(BindingSet&& other) noexcept { swap(other); }
  BindingSet& operator=(BindingSet&& other) noexcept {
    swap(other);
    return *this;
  }

  void set_buffer(std::uint32_t binding, const Buffer& buffer);
  // Storage images in VK_IMAGE_LAYOUT_GENERAL; sampled ones in `layout` with a clamped sampler of the set: nearest for
  // depth, linear for colour.
  void set_image(std::uint32_t binding, const Image& image, VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL);
  void bind(VkCommandBuffer commands) const;

  VkPipelineLayout layout = VK_NULL_HANDLE;

 private:
  void swap(BindingSet& other) {
    std::swap(layout, other.layout);
    std::swap(device_, other.device_);
    std::swap(set_layout_, other.set_layout_);
    std::swap(pool_, other.pool_);
    std::swap(set_, other.set_);
    std::swap(linear_, other.linear_);
    std::swap(nearest_, other.nearest_);
    std::swap(types_, other.types_);
  }
  Device* device_ = nullptr;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkSampler linear_ = VK_NULL_HANDLE;
  VkSampler nearest_ = VK_NULL_HANDLE;
  std::vector<VkDescriptorType> types_;
};

class Pipeline {
 public:
  Pipeline() = default;
  [[nodiscard]] static Result<Pipeline> compute(Device& device, const BindingSet& bindings,
                                                std::span<const std::uint32_t> spirv,
                                                std::span<const SpecConstant> constants);
  struct Raster {
    std::span<const std::uint32_t> vertex_spirv;
    std::span<const std::uint32_t> fragment_spirv;
    VkFormat color_format;
    VkFormat depth_format;
    std::uint32_t vertex_stride_bytes = 0;  // 0: no vertex buffer
    std::vector<VkVertexInputAttributeDescription> attributes;
  };
  // Reversed depth (greater wins), no face culled, viewport and scissor dynamic.
  [[nodiscard]] static Result<Pipeline> raster(Device& device, const BindingSet& bindings, const Raster& raster);
  ~Pipeline();
  Pipeline(Pipeline&& other) noexcept { swap(other); }
  Pipeline& operator=(Pipeline&& other) noexcept {
    swap(other);
    return *this;
  }

  void bind(VkCommandBuffer commands) const { vkCmdBindPipeline(commands, point_, handle); }
  VkPipeline handle = VK_NULL_HANDLE;

 private:
  void swap(Pipeline& other) {
    std::swap(handle, other.handle);
    std::swap(device_, other.device_);
    std::swap(point_, other.point_);
  }
  Device* device_ = nullptr;
  VkPipelineBindPoint point_ = VK_PIPELINE_BIND_POINT_COMPUTE;
};

}  // namespace footlight::render::vk

// Pipelines, and the descriptors that they read. Move-only owners; the device must outlive them.
//
// Binding numbers have one meaning in the whole frame. A pipeline's layout has only the bindings of its own shaders.
//
//   BindingTable table;                                     // what stands at each number; one a frame
//   table.set_buffer(FL_BINDING_PARAMS, params);
//   FL_ASSIGN(auto pipeline, device.pipelines().compute(spirv, constants));
//   FL_ASSIGN(auto set, BindingSet::create(device, *pipeline, table));
//   pipeline->bind(commands, set);
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "render/vk/device.h"
#include "render/vk/memory.h"
#include "render/vk/shader.h"

namespace footlight::render::vk {

// Specialisation constants by id; booleans are 0 and 1.
struct SpecConstant {
  std::uint32_t id = 0;
  std::uint32_t value = 0;
  bool operator==(const SpecConstant&) const = default;
};

// Which buffer or image each binding number means. Owns none of them: an entry is valid until its buffer or image dies.
class BindingTable {
 public:
  void set_buffer(std::uint32_t binding, const Buffer& buffer) { entries_[binding] = {.buffer = buffer.handle}; }
  // Storage images in VK_IMAGE_LAYOUT_GENERAL; sampled ones in `layout` with a clamped sampler: nearest for depth,
  // linear for colour.
  void set_image(std::uint32_t binding, const Image& image, VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL) {
    entries_[binding] = {.view = image.view, .depth = image.aspect == VK_IMAGE_ASPECT_DEPTH_BIT, .layout = layout};
  }

  struct Entry {
    VkBuffer buffer = VK_NULL_HANDLE;  // null: an image
    VkImageView view = VK_NULL_HANDLE;
    bool depth = false;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
  };
  // Null: nothing was set.
  [[nodiscard]] const Entry* find(std::uint32_t binding) const {
    const auto found = entries_.find(binding);
    return found == entries_.end() ? nullptr : &found->second;
  }

 private:
  std::map<std::uint32_t, Entry> entries_;
};

class Pipeline;

// The descriptors of one pipeline. Is made anew when a buffer or image of it is replaced.
class BindingSet {
 public:
  BindingSet() = default;
  // The table has an entry for each binding of the pipeline.
  [[nodiscard]] static Result<BindingSet> create(Device& device, const Pipeline& pipeline, const BindingTable& table);
  ~BindingSet();
  BindingSet(BindingSet&& other) noexcept { swap(other); }
  BindingSet& operator=(BindingSet&& other) noexcept {
    swap(other);
    return *this;
  }

  VkDescriptorSet handle = VK_NULL_HANDLE;

 private:
  void swap(BindingSet& other) {
    std::swap(handle, other.handle);
    std::swap(device_, other.device_);
    std::swap(pool_, other.pool_);
  }
  Device* device_ = nullptr;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
};

class Pipeline {
 public:
  Pipeline() = default;
  struct Raster {
    Spirv vertex_spirv;
    Spirv fragment_spirv;
    VkFormat color_format;
    VkFormat depth_format;                  // VK_FORMAT_UNDEFINED: no depth, and fragments add up in all four channels
    std::uint32_t vertex_stride_bytes = 0;  // 0: no vertex buffer
    std::vector<VkVertexInputAttributeDescription> attributes;
  };
  ~Pipeline();
  Pipeline(Pipeline&& other) noexcept { swap(other); }
  Pipeline& operator=(Pipeline&& other) noexcept {
    swap(other);
    return *this;
  }

  // The pipeline and its descriptors.
  void bind(VkCommandBuffer commands, const BindingSet& set) const;
  // Exactly the push constants that the shaders declare.
  void push(VkCommandBuffer commands, std::span<const std::byte> bytes) const;
  [[nodiscard]] const ShaderInterface& shader() const { return shader_; }

  VkPipeline handle = VK_NULL_HANDLE;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;

 private:
  friend class Pipelines;
  static Result<Pipeline> begin(Device& device, std::span<const Spirv> stages, VkPipelineBindPoint point);
  // What begin() has left out: the handle.
  Status compile(VkPipelineCache cache, Spirv spirv, std::span<const SpecConstant> constants);
  // With depth it is reversed (greater wins). No face culled, viewport and scissor dynamic.
  static Result<Pipeline> raster(Device& device, VkPipelineCache cache, const Raster& raster);
  void swap(Pipeline& other) {
    std::swap(handle, other.handle);
    std::swap(set_layout, other.set_layout);
    std::swap(layout, other.layout);
    std::swap(shader_, other.shader_);
    std::swap(device_, other.device_);
    std::swap(point_, other.point_);
  }
  ShaderInterface shader_;
  Device* device_ = nullptr;
  VkPipelineBindPoint point_ = VK_PIPELINE_BIND_POINT_COMPUTE;
};

// The pipelines of a device. A combination of shader and constants is compiled once, so that a knob that is moved back
// costs nothing. Those that no pass uses are dropped when there are more than kKeptMax.
//
// Threads: one at a time calls these functions. Pipelines are compiled by a few threads of their own, the longest
// shaders first. They begin with the first begin_compute() and end when nothing is left to compile.
class Pipelines {
 public:
  static constexpr std::size_t kKeptMax = 96;  // a frame, one that is compiled ahead, and the measured error
  static constexpr std::size_t kThreadsMax = 8;

  explicit Pipelines(Device& device) : device_(device) {}
  ~Pipelines() { stop(); }
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  // `spirv` is a constant of the program: its address is a part of the key.
  [[nodiscard]] Result<std::shared_ptr<const Pipeline>> compute(Spirv spirv, std::span<const SpecConstant> constants);
  // The same without waiting: the pipeline has its layouts at once, and may be bound after finish().
  [[nodiscard]] Result<std::shared_ptr<const Pipeline>> begin_compute(Spirv spirv,
                                                                      std::span<const SpecConstant> constants);
  // Waits until all pipelines are compiled. The first error since the last call of a pipeline that somebody holds, if
  // there was one; pipelines that failed are forgotten.
  Status finish();
  // Leaves those that are not begun, and waits for the others. Nothing that was left may be bound.
  void stop();
  // Whether finish() would not wait.
  [[nodiscard]] bool finished() const;
  // The shaders are the key: all rasters of the same shaders have the same formats and attributes.
  [[nodiscard]] Result<std::shared_ptr<const Pipeline>> raster(const Pipeline::Raster& raster);
  // How many have been compiled so far, or begun, and how many are kept.
  [[nodiscard]] std::size_t compiled() const { return compiled_; }
  [[nodiscard]] std::size_t kept() const { return pipelines_.size(); }

 private:
  using Key = std::vector<std::uint64_t>;
  struct Job {
    Key key;
    std::shared_ptr<Pipeline> pipeline;
    Spirv spirv;
    std::vector<SpecConstant> constants;
  };
  void make_room();
  void work();

  Device& device_;
  std::map<Key, std::shared_ptr<const Pipeline>> pipelines_;
  std::size_t compiled_ = 0;
  std::vector<std::thread> threads_;
  mutable std::mutex mutex_;
  std::condition_variable done_;
  std::vector<Job> jobs_;       // under mutex_, like all below: not yet begun
  std::size_t working_ = 0;     // threads that have not ended
  std::vector<std::pair<Key, Error>> failed_;
};

}  // namespace footlight::render::vk

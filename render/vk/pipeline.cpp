#include "render/vk/pipeline.h"

#include <algorithm>
#include <array>
#include <utility>

#include "render/vk/specialised.h"
#include "sim/core/check.h"
#include "sim/core/no_signals.h"

namespace footlight::render::vk {
namespace {

constexpr VkShaderStageFlags kAllStages =
    VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

Result<VkShaderModule> make_module(Device& device, Spirv spirv) {
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = spirv.size_bytes();
  info.pCode = spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  FL_TRY(check(vkCreateShaderModule(device.handle, &info, nullptr, &module), "vkCreateShaderModule"));
  return module;
}

bool is_buffer(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER || type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
}

}  // namespace

Result<BindingSet> BindingSet::create(Device& device, const Pipeline& pipeline, const BindingTable& table) {
  const std::vector<ShaderBinding>& bindings = pipeline.shader().bindings;
  BindingSet set;
  set.device_ = &device;
  if (bindings.empty()) return set;
  std::vector<VkDescriptorPoolSize> sizes;
  for (const ShaderBinding& binding : bindings) sizes.push_back({binding.type, 1});
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = 1;
  pool.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  pool.pPoolSizes = sizes.data();
  FL_TRY(check(vkCreateDescriptorPool(device.handle, &pool, nullptr, &set.pool_), "vkCreateDescriptorPool"));
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = set.pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &pipeline.set_layout;
  FL_TRY(check(vkAllocateDescriptorSets(device.handle, &allocate, &set.handle), "vkAllocateDescriptorSets"));

  std::vector<VkDescriptorBufferInfo> buffers(bindings.size());
  std::vector<VkDescriptorImageInfo> images(bindings.size());
  std::vector<VkWriteDescriptorSet> writes(bindings.size(), {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET});
  for (std::size_t i = 0; i < bindings.size(); ++i) {
    const BindingTable::Entry* entry = table.find(bindings[i].binding);
    FL_CHECK(entry != nullptr);
    writes[i].dstSet = set.handle;
    writes[i].dstBinding = bindings[i].binding;
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = bindings[i].type;
    if (is_buffer(bindings[i].type)) {
      FL_CHECK(entry->buffer != VK_NULL_HANDLE);
      buffers[i] = {entry->buffer, 0, VK_WHOLE_SIZE};
      writes[i].pBufferInfo = &buffers[i];
    } else {
      FL_CHECK(entry->view != VK_NULL_HANDLE);
      images[i] = {entry->depth ? device.nearest : device.linear, entry->view, entry->layout};
      writes[i].pImageInfo = &images[i];
    }
  }
  vkUpdateDescriptorSets(device.handle, static_cast<std::uint32_t>(writes.size()), writes.data(), 0, nullptr);
  return set;
}

BindingSet::~BindingSet() {
  if (device_ != nullptr) vkDestroyDescriptorPool(device_->handle, pool_, nullptr);
}

// The layouts that the shaders ask for.
Result<Pipeline> Pipeline::begin(Device& device, std::span<const Spirv> stages, VkPipelineBindPoint point) {
  Pipeline pipeline;
  pipeline.device_ = &device;
  pipeline.point_ = point;
  FL_ASSIGN(pipeline.shader_, read_interfaces(stages));
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (const ShaderBinding& binding : pipeline.shader_.bindings) {
    bindings.push_back({binding.binding, binding.type, 1, kAllStages, nullptr});
  }
  VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  layout.bindingCount = static_cast<std::uint32_t>(bindings.size());
  layout.pBindings = bindings.data();
  FL_TRY(check(vkCreateDescriptorSetLayout(device.handle, &layout, nullptr, &pipeline.set_layout),
               "vkCreateDescriptorSetLayout"));
  const VkPushConstantRange push{kAllStages, 0, pipeline.shader_.push_bytes};
  VkPipelineLayoutCreateInfo pipeline_layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  pipeline_layout.setLayoutCount = 1;
  pipeline_layout.pSetLayouts = &pipeline.set_layout;
  pipeline_layout.pushConstantRangeCount = push.size > 0 ? 1 : 0;
  pipeline_layout.pPushConstantRanges = &push;
  FL_TRY(check(vkCreatePipelineLayout(device.handle, &pipeline_layout, nullptr, &pipeline.layout),
               "vkCreatePipelineLayout"));
  return pipeline;
}

void Pipeline::bind(VkCommandBuffer commands, const BindingSet& set) const {
  vkCmdBindPipeline(commands, point_, handle);
  if (set.handle != VK_NULL_HANDLE) vkCmdBindDescriptorSets(commands, point_, layout, 0, 1, &set.handle, 0, nullptr);
}

void Pipeline::push(VkCommandBuffer commands, std::span<const std::byte> bytes) const {
  FL_CHECK_EQ(bytes.size(), shader_.push_bytes);
  if (bytes.empty()) return;
  vkCmdPushConstants(commands, layout, kAllStages, 0, static_cast<std::uint32_t>(bytes.size()), bytes.data());
}

Status Pipeline::compile(VkPipelineCache cache, Spirv spirv, std::span<const SpecConstant> constants) {
  std::vector<VkSpecializationMapEntry> entries;
  std::vector<std::uint32_t> values;
  for (const SpecConstant& constant : constants) {
    entries.push_back({constant.id, static_cast<std::uint32_t>(values.size() * 4), 4});
    values.push_back(constant.value);
  }
  const VkSpecializationInfo specialization{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                            values.size() * 4, values.data()};
  // Other drivers compile the whole shader, for which their times were measured.
  const std::vector<std::uint32_t> less =
      device_->is_software() ? specialised(spirv, constants) : std::vector<std::uint32_t>();
  FL_ASSIGN(const VkShaderModule module, make_module(*device_, less.empty() ? spirv : Spirv(less)));
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &specialization;
  VkPipelineShaderStageRequiredSubgroupSizeCreateInfo subgroup{
      VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO};
  subgroup.requiredSubgroupSize = compute_subgroup_size(device_->facts());
  if (can_require_subgroups(device_->facts())) info.stage.pNext = &subgroup;
  info.layout = layout;
  const VkResult result = vkCreateComputePipelines(device_->handle, cache, 1, &info, nullptr, &handle);
  vkDestroyShaderModule(device_->handle, module, nullptr);
  return check(result, "vkCreateComputePipelines");
}

Result<Pipeline> Pipeline::raster(Device& device, VkPipelineCache cache, const Raster& raster) {
  const std::array<Spirv, 2> shaders{raster.vertex_spirv, raster.fragment_spirv};
  FL_ASSIGN(Pipeline pipeline, begin(device, shaders, VK_PIPELINE_BIND_POINT_GRAPHICS));
  FL_ASSIGN(const VkShaderModule vertex, make_module(device, raster.vertex_spirv));
  FL_ASSIGN(const VkShaderModule fragment, make_module(device, raster.fragment_spirv));
  VkPipelineShaderStageCreateInfo stages[2] = {{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO},
                                               {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO}};
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[0].module = vertex;
  stages[0].pName = "main";
  stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  stages[1].module = fragment;
  stages[1].pName = "main";

  const VkVertexInputBindingDescription vertex_binding{0, raster.vertex_stride_bytes, VK_VERTEX_INPUT_RATE_VERTEX};
  VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  input.vertexBindingDescriptionCount = raster.vertex_stride_bytes > 0 ? 1 : 0;
  input.pVertexBindingDescriptions = &vertex_binding;
  input.vertexAttributeDescriptionCount = static_cast<std::uint32_t>(raster.attributes.size());
  input.pVertexAttributeDescriptions = raster.attributes.data();
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  VkPipelineRasterizationStateCreateInfo rasterization{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  rasterization.polygonMode = VK_POLYGON_MODE_FILL;
  rasterization.cullMode = VK_CULL_MODE_NONE;
  rasterization.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  rasterization.lineWidth = 1.0f;
  VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = VK_TRUE;
  depth.depthWriteEnable = VK_TRUE;
  depth.depthCompareOp = VK_COMPARE_OP_GREATER;
  VkPipelineColorBlendAttachmentState attachment{};
  attachment.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT;
  if (raster.depth_format == VK_FORMAT_UNDEFINED) {
    depth.depthTestEnable = depth.depthWriteEnable = VK_FALSE;
    attachment.colorWriteMask |= VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    attachment.blendEnable = VK_TRUE;
    attachment.srcColorBlendFactor = attachment.dstColorBlendFactor = VK_BLEND_FACTOR_ONE;
    attachment.srcAlphaBlendFactor = attachment.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  }
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = 1;
  blend.pAttachments = &attachment;
  const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = 2;
  dynamic.pDynamicStates = dynamic_states;
  VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachmentFormats = &raster.color_format;
  rendering.depthAttachmentFormat = raster.depth_format;

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
  info.stageCount = 2;
  info.pStages = stages;
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &rasterization;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = pipeline.layout;
  const VkResult result = vkCreateGraphicsPipelines(device.handle, cache, 1, &info, nullptr, &pipeline.handle);
  vkDestroyShaderModule(device.handle, vertex, nullptr);
  vkDestroyShaderModule(device.handle, fragment, nullptr);
  FL_TRY(check(result, "vkCreateGraphicsPipelines"));
  return pipeline;
}

Pipeline::~Pipeline() {
  if (device_ == nullptr) return;
  vkDestroyPipeline(device_->handle, handle, nullptr);
  vkDestroyPipelineLayout(device_->handle, layout, nullptr);
  vkDestroyDescriptorSetLayout(device_->handle, set_layout, nullptr);
}

void Pipelines::stop() {
  {
    const std::lock_guard lock(mutex_);
    jobs_.clear();
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void Pipelines::make_room() {
  if (pipelines_.size() < kKeptMax) return;
  std::erase_if(pipelines_, [](const auto& each) { return each.second.use_count() == 1; });
}

Result<std::shared_ptr<const Pipeline>> Pipelines::begin_compute(Spirv spirv, std::span<const SpecConstant> constants) {
  Key key{reinterpret_cast<std::uintptr_t>(spirv.data())};
  for (const SpecConstant& constant : constants) key.push_back(std::uint64_t{constant.id} << 32 | constant.value);
  if (const auto found = pipelines_.find(key); found != pipelines_.end()) return found->second;
  make_room();
  FL_ASSIGN(Pipeline begun, Pipeline::begin(device_, {&spirv, 1}, VK_PIPELINE_BIND_POINT_COMPUTE));
  const auto pipeline = std::make_shared<Pipeline>(std::move(begun));
  ++compiled_;
  pipelines_[key] = pipeline;
  const std::lock_guard lock(mutex_);
  jobs_.push_back({std::move(key), pipeline, spirv, {constants.begin(), constants.end()}});
  if (working_ == 0) {  // they have ended
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }
  const std::size_t threads = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, kThreadsMax);
  if (working_ < threads) {  // each has work: without it they end
    ++working_;
    const NoSignals no_signals;
    threads_.emplace_back([this] { work(); });
  }
  return pipeline;
}

// One thread: the longest shader first, so that none is begun late that takes as long as several others.
void Pipelines::work() {
  std::unique_lock lock(mutex_);
  while (!jobs_.empty()) {
    const auto next = std::max_element(jobs_.begin(), jobs_.end(), [](const Job& a, const Job& b) {
      return a.spirv.size() < b.spirv.size();
    });
    Job job = std::move(*next);
    jobs_.erase(next);
    lock.unlock();
    const Status compiled = job.pipeline->compile(device_.pipeline_cache, job.spirv, job.constants);
    job.pipeline.reset();
    lock.lock();
    if (compiled) continue;
    failed_.emplace_back(std::move(job.key), compiled.error());
  }
  --working_;
  done_.notify_all();
}

bool Pipelines::finished() const {
  const std::lock_guard lock(mutex_);
  return working_ == 0;
}

Status Pipelines::finish() {
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return working_ == 0; });
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  std::optional<Error> error;
  for (const auto& [key, reason] : std::exchange(failed_, {})) {
    const auto found = pipelines_.find(key);
    if (found == pipelines_.end()) continue;
    if (found->second.use_count() > 1 && !error) error = reason;
    pipelines_.erase(found);
  }
  if (error) return tl::unexpected<Error>(*error);
  return {};
}

Result<std::shared_ptr<const Pipeline>> Pipelines::compute(Spirv spirv, std::span<const SpecConstant> constants) {
  FL_ASSIGN(auto pipeline, begin_compute(spirv, constants));
  FL_TRY(finish());
  return pipeline;
}

Result<std::shared_ptr<const Pipeline>> Pipelines::raster(const Pipeline::Raster& raster) {
  const Key key{reinterpret_cast<std::uintptr_t>(raster.vertex_spirv.data()),
                reinterpret_cast<std::uintptr_t>(raster.fragment_spirv.data())};
  if (const auto found = pipelines_.find(key); found != pipelines_.end()) return found->second;
  make_room();
  FL_ASSIGN(Pipeline made, Pipeline::raster(device_, device_.pipeline_cache, raster));
  ++compiled_;
  return pipelines_[key] = std::make_shared<const Pipeline>(std::move(made));
}

}  // namespace footlight::render::vk

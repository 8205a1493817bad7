#include "render/vk/pipeline.h"

namespace footlight::render::vk {
namespace {

constexpr VkShaderStageFlags kAllStages =
    VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

Result<VkShaderModule> make_module(Device& device, std::span<const std::uint32_t> spirv) {
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = spirv.size_bytes();
  info.pCode = spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  FL_TRY(check(vkCreateShaderModule(device.handle, &info, nullptr, &module), "vkCreateShaderModule"));
  return module;
}

}  // namespace

Result<BindingSet> BindingSet::create(Device& device, std::span<const VkDescriptorType> types,
                                      std::uint32_t push_bytes) {
  BindingSet set;
  set.device_ = &device;
  set.types_.assign(types.begin(), types.end());

  VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  sampler.magFilter = VK_FILTER_LINEAR;
  sampler.minFilter = VK_FILTER_LINEAR;
  sampler.mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
  sampler.maxLod = VK_LOD_CLAMP_NONE;
  sampler.addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  sampler.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  FL_TRY(check(vkCreateSampler(device.handle, &sampler, nullptr, &set.linear_), "vkCreateSampler"));
  sampler.magFilter = VK_FILTER_NEAREST;
  sampler.minFilter = VK_FILTER_NEAREST;
  sampler.mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST;  // depth formats need not be filtered
  FL_TRY(check(vkCreateSampler(device.handle, &sampler, nullptr, &set.nearest_), "vkCreateSampler"));

  std::vector<VkDescriptorSetLayoutBinding> bindings;
  std::vector<VkDescriptorPoolSize> sizes;
  for (std::uint32_t i = 0; i < types.size(); ++i) {
    bindings.push_back({i, types[i], 1, kAllStages, nullptr});
    sizes.push_back({types[i], 1});
  }
  VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  layout.bindingCount = static_cast<std::uint32_t>(bindings.size());
  layout.pBindings = bindings.data();
  FL_TRY(check(vkCreateDescriptorSetLayout(device.handle, &layout, nullptr, &set.set_layout_),
               "vkCreateDescriptorSetLayout"));

  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = 1;
  pool.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  pool.pPoolSizes = sizes.data();
  FL_TRY(check(vkCreateDescriptorPool(device.handle, &pool, nullptr, &set.pool_), "vkCreateDescriptorPool"));
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = set.pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &set.set_layout_;
  FL_TRY(check(vkAllocateDescriptorSets(device.handle, &allocate, &set.set_), "vkAllocateDescriptorSets"));

  const VkPushConstantRange push{kAllStages, 0, push_bytes};
  VkPipelineLayoutCreateInfo pipeline_layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  pipeline_layout.setLayoutCount = 1;
  pipeline_layout.pSetLayouts = &set.set_layout_;
  pipeline_layout.pushConstantRangeCount = push_bytes > 0 ? 1 : 0;
  pipeline_layout.pPushConstantRanges = &push;
  FL_TRY(
      check(vkCreatePipelineLayout(device.handle, &pipeline_layout, nullptr, &set.layout), "vkCreatePipelineLayout"));
  return set;
}

BindingSet::~BindingSet() {
  if (device_ == nullptr) return;
  vkDestroyPipelineLayout(device_->handle, layout, nullptr);
  vkDestroyDescriptorPool(device_->handle, pool_, nullptr);
  vkDestroyDescriptorSetLayout(device_->handle, set_layout_, nullptr);
  vkDestroySampler(device_->handle, linear_, nullptr);
  vkDestroySampler(device_->handle, nearest_, nullptr);
}

void BindingSet::set_buffer(std::uint32_t binding, const Buffer& buffer) {
  const VkDescriptorBufferInfo info{buffer.handle, 0, VK_WHOLE_SIZE};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.dstBinding = binding;
  write.descriptorCount = 1;
  write.descriptorType = types_[binding];
  write.pBufferInfo = &info;
  vkUpdateDescriptorSets(device_->handle, 1, &write, 0, nullptr);
}

void BindingSet::set_image(std::uint32_t binding, const Image& image, VkImageLayout image_layout) {
  const bool depth = image.aspect == VK_IMAGE_ASPECT_DEPTH_BIT;
  const VkDescriptorImageInfo info{depth ? nearest_ : linear_, image.view, image_layout};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.dstBinding = binding;
  write.descriptorCount = 1;
  write.descriptorType = types_[binding];
  write.pImageInfo = &info;
  vkUpdateDescriptorSets(device_->handle, 1, &write, 0, nullptr);
}

void BindingSet::bind(VkCommandBuffer commands) const {
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set_, 0, nullptr);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set_, 0, nullptr);
}

Result<Pipeline> Pipeline::compute(Device& device, const BindingSet& bindings, std::span<const std::uint32_t> spirv,
                                   std::span<const SpecConstant> constants) {
  std::vector<VkSpecializationMapEntry> entries;
  std::vector<std::uint32_t> values;
  for (const SpecConstant& constant : constants) {
    entries.push_back({constant.id, static_cast<std::uint32_t>(values.size() * 4), 4});
    values.push_back(constant.value);
  }
  const VkSpecializationInfo specialization{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                            values.size() * 4, values.data()};
  FL_ASSIGN(const VkShaderModule module, make_module(device, spirv));
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &specialization;
  info.layout = bindings.layout;
  Pipeline pipeline;
  pipeline.device_ = &device;
  const VkResult result = vkCreateComputePipelines(device.handle, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline.handle);
  vkDestroyShaderModule(device.handle, module, nullptr);
  FL_TRY(check(result, "vkCreateComputePipelines"));
  return pipeline;
}

Result<Pipeline> Pipeline::raster(Device& device, const BindingSet& bindings, const Raster& raster) {
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
  info.layout = bindings.layout;
  Pipeline pipeline;
  pipeline.device_ = &device;
  pipeline.point_ = VK_PIPELINE_BIND_POINT_GRAPHICS;
  const VkResult result = vkCreateGraphicsPipelines(device.handle, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline.handle);
  vkDestroyShaderModule(device.handle, vertex, nullptr);
  vkDestroyShaderModule(device.handle, fragment, nullptr);
  FL_TRY(check(result, "vkCreateGraphicsPipelines"));
  return pipeline;
}

Pipeline::~Pipeline() {
  if (device_ != nullptr) vkDestroyPipeline(device_->handle, handle, nullptr);
}

}  // namespace footlight::render::vk

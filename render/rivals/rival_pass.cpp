#include "render/rivals/rival_pass.h"

#include <array>
#include <cstddef>
#include <utility>

#include "render/passes/beams.h"
#include "shaders/addblended.comp.h"
#include "shaders/bounds.comp.h"

namespace footlight::render {

RivalPass::RivalPass(const PassContext& context, const std::vector<vk::SpecConstant>& more)
    : device_(context.device),
      resources_(context.resources),
      constants_(context.constants),
      width_(static_cast<std::uint32_t>(context.settings.width)),
      height_(static_cast<std::uint32_t>(context.settings.height)),
      bindings_(context.resources.bindings) {
  constants_.insert(constants_.end(), more.begin(), more.end());
}

Status RivalPass::add_buffer(std::uint32_t binding, VkDeviceSize bytes) {
  FL_ASSIGN(vk::Buffer buffer, vk::Buffer::device_local(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  bindings_.set_buffer(binding, buffer);
  buffers_.push_back(std::move(buffer));
  return {};
}

Status RivalPass::add_compute(vk::Spirv spirv, Commands dispatch) {
  FL_ASSIGN(auto pipeline, device_.pipelines().compute(spirv, constants_));
  FL_ASSIGN(vk::BindingSet set, vk::BindingSet::create(device_, *pipeline, bindings_));
  steps_.push_back({std::move(pipeline), std::move(set), std::move(dispatch)});
  return {};
}

Status RivalPass::add_bounds() {
  FL_TRY(add_buffer(FL_BINDING_BOUNDS, sizeof(BoundsRow)));
  return add_compute(kBoundsComp, [](VkCommandBuffer commands) { vkCmdDispatch(commands, 1, 1, 1); });
}

Status RivalPass::add_meshes(vk::Spirv vertex, vk::Spirv fragment, std::uint32_t vertices) {
  constexpr VkFormat kFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
  FL_ASSIGN(vk::Image image, vk::Image::create(device_, width_, height_, kFormat,
                                               VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_STORAGE_BIT));
  FL_TRY(device_.run_once([&](VkCommandBuffer commands) {
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
  }));
  FL_ASSIGN(vk::Buffer draw,
            vk::Buffer::device_local(device_, sizeof(VkDrawIndirectCommand), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
  FL_ASSIGN(auto pipeline, device_.pipelines().raster({vertex, fragment, kFormat, VK_FORMAT_UNDEFINED, 0, {}}));
  FL_ASSIGN(vk::BindingSet set, vk::BindingSet::create(device_, *pipeline, bindings_));
  const auto render = [view = image.view, draw = draw.handle, counts = resources_.rig.counts.handle, vertices,
                       width = width_, height = height_](VkCommandBuffer commands) {
    const VkDrawIndirectCommand none{vertices, 0, 0, 0};
    vkCmdUpdateBuffer(commands, draw, 0, sizeof(none), &none);
    vk::full_barrier(commands);
    const VkBufferCopy live{offsetof(CountsRow, live_count), offsetof(VkDrawIndirectCommand, instanceCount),
                            sizeof(std::uint32_t)};
    vkCmdCopyBuffer(commands, counts, draw, 1, &live);
    vk::full_barrier(commands);
    VkRenderingAttachmentInfo color{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    color.imageView = view;
    color.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
    color.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
    info.renderArea = {{0, 0}, {width, height}};
    info.layerCount = 1;
    info.colorAttachmentCount = 1;
    info.pColorAttachments = &color;
    vkCmdBeginRendering(commands, &info);
    const VkViewport viewport{0, 0, static_cast<float>(width), static_cast<float>(height), 0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &info.renderArea);
    vkCmdDrawIndirect(commands, draw, 0, 1, sizeof(none));
    vkCmdEndRendering(commands);
  };
  steps_.push_back({std::move(pipeline), std::move(set), render});
  bindings_.set_image(FL_BINDING_BLENDED, image);
  images_.push_back(std::move(image));
  buffers_.push_back(std::move(draw));
  return add_compute(kAddblendedComp,
                     [x = groups_of(width_, FL_GROUP_FROXELS), y = groups_of(height_, FL_GROUP_FROXELS)](
                         VkCommandBuffer commands) { vkCmdDispatch(commands, x, y, 1); });
}

void RivalPass::record(VkCommandBuffer commands, std::span<const std::byte>) {
  for (const Step& step : steps_) {
    if (&step != &steps_.front()) vk::full_barrier(commands);
    step.pipeline->bind(commands, step.set);
    step.dispatch(commands);
  }
}

std::uint64_t RivalPass::own_bytes() const {
  std::uint64_t bytes = 0;
  for (const vk::Buffer& buffer : buffers_) bytes += buffer.size_bytes;
  for (const vk::Image& image : images_) bytes += image.size_bytes;
  return bytes;
}

RivalPass::Commands tiles_of_beams(const PassContext& context) {
  return [counts = context.resources.rig.counts.handle](VkCommandBuffer commands) {
    vkCmdDispatchIndirect(commands, counts, offsetof(CountsRow, beams_groups));
  };
}

std::vector<vk::SpecConstant> rival_constants(const fixtures::Needs& needs, const FrameSettings& settings) {
  return kBeamsPass.constants(needs, settings);
}

FrameSettings rival_settings(FrameSettings judged, double knob) {
  judged.tile_error = 0;
  judged.method = BeamMethod::kMarch;  // any number of nodes, and no tables of gobos
  judged.nodes = static_cast<std::uint32_t>(knob);
  return judged;
}

}  // namespace footlight::render

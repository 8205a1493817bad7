#include "render/passes/bodies.h"

#include <cstddef>
#include <utility>

#include "fixtures/bodies/primitives.h"
#include "shaders/body.vert.h"
#include "shaders/object.vert.h"
#include "shaders/surface.frag.h"

namespace footlight::render {
namespace {

class BodiesPass final : public Pass {
 public:
  // A pipeline with its descriptors.
  struct Drawing {
    std::shared_ptr<const vk::Pipeline> pipeline;
    vk::BindingSet set;
  };

  BodiesPass(const PassContext& context, Drawing bodies, Drawing objects)
      : resources_(context.resources),
        width_(static_cast<std::uint32_t>(context.settings.width)),
        height_(static_cast<std::uint32_t>(context.settings.height)),
        multi_draw_(context.device.facts().features.multiDrawIndirect == VK_TRUE),
        bodies_(std::move(bodies)),
        objects_(std::move(objects)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    VkRenderingAttachmentInfo color{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    color.imageView = resources_.picture.surface_id.view;
    color.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
    color.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    VkRenderingAttachmentInfo depth{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    depth.imageView = resources_.picture.depth.view;
    depth.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
    depth.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    depth.storeOp = VK_ATTACHMENT_STORE_OP_STORE;  // cleared to 0: infinitely far in reversed depth
    VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
    info.renderArea = {{0, 0}, {width_, height_}};
    info.layerCount = 1;
    info.colorAttachmentCount = 1;
    info.pColorAttachments = &color;
    info.pDepthAttachment = &depth;
    vkCmdBeginRendering(commands, &info);
    const VkViewport viewport{0, 0, static_cast<float>(width_), static_cast<float>(height_), 0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &info.renderArea);
    const VkDeviceSize zero = 0;
    if (resources_.rig.draw_count + resources_.rig.object_draw_count > 0) {
      vkCmdBindVertexBuffers(commands, 0, 1, &resources_.rig.vertices.handle, &zero);
      vkCmdBindIndexBuffer(commands, resources_.rig.indices.handle, 0, VK_INDEX_TYPE_UINT32);
    }
    draw(commands, bodies_, 0, resources_.rig.draw_count);
    draw(commands, objects_, resources_.rig.draw_count, resources_.rig.object_draw_count);
    vkCmdEndRendering(commands);
  }

 private:
  void draw(VkCommandBuffer commands, const Drawing& drawing, std::uint32_t first, std::uint32_t count) const {
    if (count == 0) return;
    constexpr std::uint32_t kDrawBytes = sizeof(VkDrawIndexedIndirectCommand);
    drawing.pipeline->bind(commands, drawing.set);
    const std::uint32_t together = multi_draw_ ? count : 1;
    for (std::uint32_t i = 0; i < count; i += together) {
      vkCmdDrawIndexedIndirect(commands, resources_.rig.draws.handle, VkDeviceSize{first + i} * kDrawBytes, together,
                               kDrawBytes);
    }
  }

  Resources& resources_;
  std::uint32_t width_;
  std::uint32_t height_;
  bool multi_draw_;
  Drawing bodies_;
  Drawing objects_;
};

Result<BodiesPass::Drawing> make_drawing(const PassContext& context, const vk::Pipeline::Raster& raster) {
  FL_ASSIGN(auto pipeline, context.device.pipelines().raster(raster));
  FL_ASSIGN(vk::BindingSet set, vk::BindingSet::create(context.device, *pipeline, context.resources.bindings));
  return BodiesPass::Drawing{std::move(pipeline), std::move(set)};
}

}  // namespace

const PassEntry kBodiesPass{
    "bodies",
    [](const fixtures::Needs& needs, const FrameSettings& settings) { return has_bodies(needs, settings); },
    [](const fixtures::Needs&, const FrameSettings&) { return std::vector<vk::SpecConstant>{}; },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      using fixtures::BodyVertex;
      const Resources& r = context.resources;
      vk::Pipeline::Raster raster{kBodyVert,
                                  kSurfaceFrag,
                                  r.picture.surface_id.format,
                                  r.picture.depth.format,
                                  sizeof(BodyVertex),
                                  {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(BodyVertex, position)},
                                   {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(BodyVertex, normal)},
                                   {2, 0, VK_FORMAT_R32_UINT, offsetof(BodyVertex, part)}}};
      FL_ASSIGN(BodiesPass::Drawing bodies, make_drawing(context, raster));
      raster.vertex_spirv = kObjectVert;
      FL_ASSIGN(BodiesPass::Drawing objects, make_drawing(context, raster));
      return std::unique_ptr<Pass>(new BodiesPass(context, std::move(bodies), std::move(objects)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kBodyVert, kSurfaceFrag}, {kObjectVert, kSurfaceFrag}};
    },
    "bodies of fixtures and objects of the scene",
    [] {
      return std::vector<std::uint32_t>{FL_BINDING_SURFACE_ID, FL_BINDING_DEPTH};
    }};

}  // namespace footlight::render

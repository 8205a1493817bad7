#include "render/passes/bodies.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "fixtures/bodies/primitives.h"
#include "render/passes/compute_pass.h"
#include "render/passes/triangles.h"
#include "shaders/body.vert.h"
#include "shaders/drawblocks.comp.h"
#include "shaders/drawbodies.comp.h"
#include "shaders/drawobjects.comp.h"
#include "shaders/joinedblocks.comp.h"
#include "shaders/joinedbodies.comp.h"
#include "shaders/joinedobjects.comp.h"
#include "shaders/list.comp.h"
#include "shaders/mirror.frag.h"
#include "shaders/object.vert.h"
#include "shaders/place.comp.h"
#include "shaders/resolve.comp.h"
#include "shaders/sheenbody.frag.h"
#include "shaders/sheenbody.vert.h"
#include "shaders/sheenbodymirror.frag.h"
#include "shaders/sheenmirror.frag.h"
#include "shaders/sheenresolve.comp.h"
#include "shaders/sheensurface.frag.h"
#include "shaders/surface.frag.h"
#include "shaders/texturemirror.frag.h"
#include "shaders/textureobject.vert.h"
#include "shaders/textureresolve.comp.h"
#include "shaders/texturesurface.frag.h"

namespace footlight::render {
namespace {

class BodiesPass final : public Pass {
 public:
  // Null pipelines: nothing to do for them.
  struct Parts {
    BoundPipeline place, list, bodies, objects;  // the rasteriser's are the last three
    std::vector<DrawnTriangles> rounds;              // of compute shaders: one, or depths first, then keys
    BoundPipeline resolve;
  };

  BodiesPass(const PassContext& context, Parts parts)
      : resources_(context.resources),
        width_(static_cast<std::uint32_t>(context.settings.width)),
        height_(static_cast<std::uint32_t>(context.settings.height)),
        multi_draw_(context.device.facts().features.multiDrawIndirect == VK_TRUE),
        parts_(std::move(parts)) {}

  void record(VkCommandBuffer commands, std::span<const std::byte>) override {
    if (parts_.place.pipeline) {
      const BodyRoundsHead none{0, 0, 1, 0};
      vkCmdUpdateBuffer(commands, resources_.rig.body_rounds.handle, 0, sizeof(none), &none);
      vk::full_barrier(commands);
      dispatch(commands, parts_.place, groups_of(resources_.rig.slot_count, FL_GROUP_HEADS), 1);
    }
    if (parts_.resolve.pipeline) {
      compute(commands);
      return;
    }
    if (parts_.list.pipeline) {
      vk::full_barrier(commands);
      dispatch(commands, parts_.list, resources_.rig.mesh_count, 1);
      vk::full_barrier(commands);
    }
    raster(commands);
  }

 private:
  static void dispatch(VkCommandBuffer commands, const BoundPipeline& bound, std::uint32_t x, std::uint32_t y) {
    bound.bind(commands);
    vkCmdDispatch(commands, x, y, 1);
  }

  // The nearest depth of each pixel and the first triangle there, then what it shows.
  void compute(VkCommandBuffer commands) const {
    const PictureImages& picture = resources_.picture;
    // Infinitely far. One round has the depths in the words of keys.
    if (parts_.rounds.size() > 1) vkCmdFillBuffer(commands, picture.pixel_depths.handle, 0, VK_WHOLE_SIZE, 0);
    vkCmdFillBuffer(commands, picture.pixel_keys.handle, 0, VK_WHOLE_SIZE, 0);
    for (const DrawnTriangles& drawn : parts_.rounds) {
      DrawnTriangles::clear(commands, resources_);
      vk::full_barrier(commands);
      drawn.record(commands, resources_);
      vk::full_barrier(commands);
    }
    dispatch(commands, parts_.resolve, tile_groups(static_cast<int>(width_)), tile_groups(static_cast<int>(height_)));
  }

  void raster(VkCommandBuffer commands) const {
    VkRenderingAttachmentInfo color{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    color.imageView = resources_.picture.surface_id.view;
    color.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
    color.loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;  // read only where there is a depth
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
    draw(commands, parts_.bodies, 0, resources_.rig.draw_count);
    draw(commands, parts_.objects, resources_.rig.draw_count, resources_.rig.object_draw_count);
    vkCmdEndRendering(commands);
    vk::full_barrier(commands);
  }

  void draw(VkCommandBuffer commands, const BoundPipeline& bound, std::uint32_t first, std::uint32_t count) const {
    if (count == 0) return;
    constexpr std::uint32_t kDrawBytes = sizeof(VkDrawIndexedIndirectCommand);
    bound.bind(commands);
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
  Parts parts_;
};

vk::Spirv body_fragments(bool mirrors, bool sheen) {
  if (sheen) return mirrors ? vk::Spirv(kSheenbodymirrorFrag) : vk::Spirv(kSheenbodyFrag);
  return mirrors ? vk::Spirv(kMirrorFrag) : vk::Spirv(kSurfaceFrag);
}
// Those of objects with textures, or with sheen.
vk::Spirv texture_fragments(bool mirrors, bool sheen) {
  if (sheen) return mirrors ? vk::Spirv(kSheenmirrorFrag) : vk::Spirv(kSheensurfaceFrag);
  return mirrors ? vk::Spirv(kTexturemirrorFrag) : vk::Spirv(kTexturesurfaceFrag);
}

Result<BoundPipeline> raster_part(const PassContext& context, const vk::Pipeline::Raster& raster) {
  FL_ASSIGN(auto pipeline, context.device.pipelines().raster(raster));
  return BoundPipeline::create(context, std::move(pipeline));
}

}  // namespace

const PassEntry kBodiesPass{
    "bodies", [](const fixtures::Needs& needs, const FrameSettings& settings) { return has_bodies(needs, settings); },
    // The constants select shaders.
    [](const fixtures::Needs& needs, const FrameSettings& settings) {
      return std::vector<vk::SpecConstant>{{FL_SPEC_GLOSS, has_gloss(needs, settings)},
                                           {FL_SPEC_SHEEN, has_sheen(needs, settings)}};
    },
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      using fixtures::BodyVertex;
      const Resources& r = context.resources;
      const bool mirrors = has_constant(context, FL_SPEC_GLOSS);
      const bool sheen = has_constant(context, FL_SPEC_SHEEN);
      vk::Pipeline::Raster raster{sheen ? vk::Spirv(kSheenbodyVert) : vk::Spirv(kBodyVert),
                                  body_fragments(mirrors, sheen),
                                  r.picture.surface_id.format,
                                  r.picture.depth.format,
                                  sizeof(BodyVertex),
                                  {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(BodyVertex, position)},
                                   {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(BodyVertex, normal)},
                                   {2, 0, VK_FORMAT_R32_UINT, offsetof(BodyVertex, part)}}};
      BodiesPass::Parts parts;
      if (r.rig.slot_count > 0) {
        FL_ASSIGN(parts.place, BoundPipeline::compute(context, kPlaceComp, {}));
      }
      if (context.settings.triangles != TriangleMethod::kRasteriser) {
        const bool joined = context.settings.triangles != TriangleMethod::kTwoRounds;  // as has_joined_words()
        const DrawnTriangles::Shaders in_one{kJoinedbodiesComp, kJoinedobjectsComp, kJoinedblocksComp};
        const DrawnTriangles::Shaders in_two{kDrawbodiesComp, kDrawobjectsComp, kDrawblocksComp};
        for (std::uint32_t keys = 0; keys < (joined ? 1u : 2u); ++keys) {
          std::vector<vk::SpecConstant> constants;
          if (!joined) constants.push_back({FL_SPEC_KEYS, keys});
          FL_ASSIGN(DrawnTriangles drawn, DrawnTriangles::create(context, joined ? in_one : in_two, constants));
          parts.rounds.push_back(std::move(drawn));
        }
        const vk::Spirv resolve = r.rig.texture_count == 0 ? vk::Spirv(kResolveComp)
                                  : sheen                  ? vk::Spirv(kSheenresolveComp)
                                                           : vk::Spirv(kTextureresolveComp);
        FL_ASSIGN(parts.resolve, BoundPipeline::compute(context, resolve,
                                                        {{FL_SPEC_SHEEN, sheen}, {FL_SPEC_JOINED, joined}}));
        return std::unique_ptr<Pass>(new BodiesPass(context, std::move(parts)));
      }
      if (r.rig.slot_count > 0) {
        FL_ASSIGN(parts.list, BoundPipeline::compute(context, kListComp, {}));
        FL_ASSIGN(parts.bodies, raster_part(context, raster));
      }
      if (r.rig.object_draw_count > 0) {
        raster.vertex_spirv = r.rig.texture_count > 0 ? vk::Spirv(kTextureobjectVert) : vk::Spirv(kObjectVert);
        raster.fragment_spirv =
            r.rig.texture_count > 0 ? texture_fragments(mirrors, sheen) : body_fragments(mirrors, false);
        FL_ASSIGN(parts.objects, raster_part(context, raster));
      }
      return std::unique_ptr<Pass>(new BodiesPass(context, std::move(parts)));
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kPlaceComp},
                                                 {kListComp},
                                                 {kDrawbodiesComp},
                                                 {kDrawobjectsComp},
                                                 {kDrawblocksComp},
                                                 {kJoinedbodiesComp},
                                                 {kJoinedobjectsComp},
                                                 {kJoinedblocksComp},
                                                 {kResolveComp},
                                                 {kTextureresolveComp},
                                                 {kSheenresolveComp},
                                                 {kBodyVert, kSurfaceFrag},
                                                 {kObjectVert, kSurfaceFrag},
                                                 {kBodyVert, kMirrorFrag},
                                                 {kObjectVert, kMirrorFrag},
                                                 {kTextureobjectVert, kTexturesurfaceFrag},
                                                 {kTextureobjectVert, kTexturemirrorFrag},
                                                 {kSheenbodyVert, kSheenbodyFrag},
                                                 {kSheenbodyVert, kSheenbodymirrorFrag},
                                                 {kTextureobjectVert, kSheensurfaceFrag},
                                                 {kTextureobjectVert, kSheenmirrorFrag}};
    },
    "bodies of fixtures and objects of the scene",
    [] {
      return std::vector<std::uint32_t>{FL_BINDING_SURFACE_ID, FL_BINDING_DEPTH};
    }};

}  // namespace footlight::render

#include "render/resources.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "fixtures/gobo.h"
#include "fixtures/model/primitives.h"
#include "render/pass.h"

namespace footlight::render {
namespace {

std::array<VkDescriptorType, FL_BINDING_COUNT> binding_types() {
  std::array<VkDescriptorType, FL_BINDING_COUNT> types;
  types.fill(VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
  types[FL_BINDING_SURFACE_ID] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  types[FL_BINDING_DEPTH] = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  types[FL_BINDING_RADIANCE] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  types[FL_BINDING_SCREEN] = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  types[FL_BINDING_GOBOS] = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  return types;
}

template <class Row>
Result<vk::Buffer> table(vk::Device& device, const std::vector<Row>& rows, VkBufferUsageFlags usage = 0) {
  return vk::Buffer::filled(device, std::as_bytes(std::span(rows)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | usage);
}

// All gobo images, one after the other; computed once a process.
const std::vector<float>& gobo_texels() {
  static const std::vector<float> texels = [] {
    std::vector<float> all;
    all.reserve(std::size_t{fixtures::kGoboCount} * kGoboSizePx * kGoboSizePx);
    for (int gobo = 1; gobo <= fixtures::kGoboCount; ++gobo) {
      for (int row = 0; row < kGoboSizePx; ++row) {
        for (int column = 0; column < kGoboSizePx; ++column) {
          const double x = 2 * (column + 0.5) / kGoboSizePx - 1;
          const double y = 2 * (row + 0.5) / kGoboSizePx - 1;
          all.push_back(static_cast<float>(fixtures::gobo_transmission(gobo, x, y, kGoboEdge)));
        }
      }
    }
    return all;
  }();
  return texels;
}

// Gobo images as one array. A rig without gobos gets a single texel, since the shaders name the binding even where
// their specialisation never reads it.
Result<vk::Image> make_gobos(vk::Device& device, bool needed) {
  const int count = needed ? fixtures::kGoboCount : 1;
  const int size = needed ? kGoboSizePx : 1;
  const std::vector<float> texels = needed ? gobo_texels() : std::vector<float>{1.0f};
  FL_ASSIGN(vk::Image image,
            vk::Image::create(device, static_cast<uint>(size), static_cast<uint>(size), VK_FORMAT_R32_SFLOAT,
                              VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, static_cast<uint>(count)));
  FL_ASSIGN(vk::Buffer staging, vk::Buffer::host_visible(device, texels.size() * sizeof(float), 0));
  std::memcpy(staging.mapped, texels.data(), texels.size() * sizeof(float));
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, static_cast<uint>(count)};
    region.imageExtent = {static_cast<uint>(size), static_cast<uint>(size), 1};
    vkCmdCopyBufferToImage(commands, staging.handle, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }));
  return image;
}

// One mesh buffer for the bodies of all types, fixtures sorted by type, one indirect command a type.
Status make_bodies(vk::Device& device, const fixtures::CompiledRig& compiled, Resources& r) {
  std::vector<fixtures::BodyVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<std::uint32_t> instances;
  std::vector<VkDrawIndexedIndirectCommand> draws;
  for (std::uint32_t t = 0; t < compiled.types.size(); ++t) {
    const fixtures::TypeRow& type = compiled.types[t];
    const auto first_instance = static_cast<std::uint32_t>(instances.size());
    for (std::uint32_t i = 0; i < compiled.fixtures.size(); ++i) {
      if (compiled.fixtures[i].type == t) instances.push_back(i);
    }
    const auto count = static_cast<std::uint32_t>(instances.size()) - first_instance;
    if (count == 0) continue;
    const fixtures::BodyMesh mesh = fixtures::make_body(static_cast<fixtures::BodyModel>(type.body_model),
                                                        {type.pivot_drop_m, type.lens_offset_m, type.lens_radius_m});
    draws.push_back({static_cast<std::uint32_t>(mesh.indices.size()), count, static_cast<std::uint32_t>(indices.size()),
                     static_cast<std::int32_t>(vertices.size()), first_instance});
    vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
  }
  r.draw_count = static_cast<std::uint32_t>(draws.size());
  FL_ASSIGN(r.vertices, table(device, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT));
  FL_ASSIGN(r.indices, table(device, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT));
  FL_ASSIGN(r.instances, table(device, instances));
  FL_ASSIGN(r.draws, table(device, draws, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
  r.bindings.set_buffer(FL_BINDING_INSTANCES, r.instances);
  return {};
}

Result<vk::Buffer> zeroed(vk::Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage = 0) {
  FL_ASSIGN(vk::Buffer buffer,
            vk::Buffer::device_local(device, (bytes + 3) / 4 * 4, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | usage));
  FL_TRY(device.run_once(
      [&](VkCommandBuffer commands) { vkCmdFillBuffer(commands, buffer.handle, 0, VK_WHOLE_SIZE, 0); }));
  return buffer;
}

}  // namespace

Result<Resources> Resources::create(vk::Device& device, const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                                    const FrameSettings& settings) {
  const auto width = static_cast<std::uint32_t>(settings.width);
  const auto height = static_cast<std::uint32_t>(settings.height);
  const std::uint32_t size_max = device.limits().maxImageDimension2D;
  if (settings.width < 1 || settings.height < 1 || width > size_max || height > size_max) {
    return fail(ErrorCode::kBadInput, "picture size {}x{}: expected 1x1 to {}x{} on {}", settings.width,
                settings.height, size_max, size_max, device.name());
  }
  Resources r;
  FL_ASSIGN(r.bindings, vk::BindingSet::create(device, binding_types(), 16));
  r.fixture_count = static_cast<std::uint32_t>(compiled.fixtures.size());
  r.fixture_groups = (r.fixture_count + FL_GROUP_FIXTURES - 1) / FL_GROUP_FIXTURES;
  r.box_count = static_cast<std::uint32_t>(rig.boxes.size());
  r.supertiles_x = (width + FL_SUPERTILE_PX - 1) / FL_SUPERTILE_PX;
  r.supertiles_y = (height + FL_SUPERTILE_PX - 1) / FL_SUPERTILE_PX;
  // Words come in pairs, as one group of the tile pass writes them.
  r.mask_words = (r.fixture_count + FL_GROUP_MASK - 1) / FL_GROUP_MASK * (FL_GROUP_MASK / 32);
  r.levels_bytes = compiled.universes.size() * kSlotCountMax;

  FL_ASSIGN(r.types, table(device, compiled.types));
  FL_ASSIGN(r.channels, table(device, compiled.channels));
  FL_ASSIGN(r.functions, table(device, compiled.functions));
  FL_ASSIGN(r.fixtures, table(device, compiled.fixtures));
  std::vector<BoxRow> boxes;
  for (const auto& box : rig.boxes) {
    boxes.push_back({vec4(box.min_m, 0), vec4(box.max_m, 0), vec4(box.albedo, 0)});
  }
  FL_ASSIGN(r.boxes, table(device, boxes));
  if (settings.bodies && r.fixture_count > 0) FL_TRY(make_bodies(device, compiled, r));
  FL_ASSIGN(r.gobos, make_gobos(device, compiled.needs.gobo));

  FL_ASSIGN(r.params, zeroed(device, sizeof(FrameParams)));
  FL_ASSIGN(r.levels, zeroed(device, r.levels_bytes));
  FL_ASSIGN(r.states, zeroed(device, r.fixture_count * kStateBytes));
  FL_ASSIGN(r.beams, zeroed(device, r.fixture_count * sizeof(BeamRow)));
  FL_ASSIGN(r.counts, zeroed(device, sizeof(CountsRow) + r.fixture_groups * 4, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
  FL_ASSIGN(r.masks, zeroed(device, VkDeviceSize{r.supertiles_x} * r.supertiles_y * r.mask_words * 4));

  // Without bodies there is no visibility buffer, only a texel for the bindings' sake.
  const bool bodies = has_bodies(compiled.needs, settings);
  const std::uint32_t solid_width = bodies ? width : 1;
  const std::uint32_t solid_height = bodies ? height : 1;
  FL_ASSIGN(r.surface_id, vk::Image::create(device, solid_width, solid_height, VK_FORMAT_R32G32_UINT,
                                            VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_STORAGE_BIT));
  FL_ASSIGN(r.depth, vk::Image::create(device, solid_width, solid_height, VK_FORMAT_D32_SFLOAT,
                                       VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT));
  constexpr VkImageUsageFlags kPicture =
      VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  FL_ASSIGN(r.radiance, vk::Image::create(device, width, height, VK_FORMAT_R32G32B32A32_SFLOAT, kPicture));
  FL_ASSIGN(r.screen, vk::Image::create(device, width, height, VK_FORMAT_R8G8B8A8_UNORM, kPicture));
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    for (const vk::Image* image : {&r.surface_id, &r.depth, &r.radiance, &r.screen}) {
      vk::change_layout(commands, *image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    }
    const VkClearColorValue black{{0, 0, 0, 1}};  // opaque: what a picture without a pass shows
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(commands, r.radiance.handle, VK_IMAGE_LAYOUT_GENERAL, &black, 1, &range);
    vkCmdClearColorImage(commands, r.screen.handle, VK_IMAGE_LAYOUT_GENERAL, &black, 1, &range);
  }));

  r.bindings.set_buffer(FL_BINDING_PARAMS, r.params);
  r.bindings.set_buffer(FL_BINDING_LEVELS, r.levels);
  r.bindings.set_buffer(FL_BINDING_TYPES, r.types);
  r.bindings.set_buffer(FL_BINDING_CHANNELS, r.channels);
  r.bindings.set_buffer(FL_BINDING_FUNCTIONS, r.functions);
  r.bindings.set_buffer(FL_BINDING_FIXTURES, r.fixtures);
  r.bindings.set_buffer(FL_BINDING_STATES, r.states);
  r.bindings.set_buffer(FL_BINDING_BEAMS, r.beams);
  r.bindings.set_buffer(FL_BINDING_COUNTS, r.counts);
  r.bindings.set_buffer(FL_BINDING_MASKS, r.masks);
  r.bindings.set_buffer(FL_BINDING_BOXES, r.boxes);
  r.bindings.set_image(FL_BINDING_SURFACE_ID, r.surface_id);
  r.bindings.set_image(FL_BINDING_DEPTH, r.depth);
  r.bindings.set_image(FL_BINDING_RADIANCE, r.radiance);
  r.bindings.set_image(FL_BINDING_SCREEN, r.screen);
  r.bindings.set_image(FL_BINDING_GOBOS, r.gobos, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);

  for (const vk::Buffer* buffer :
       {&r.types, &r.channels, &r.functions, &r.fixtures, &r.boxes, &r.instances, &r.vertices, &r.indices, &r.draws,
        &r.params, &r.levels, &r.states, &r.beams, &r.counts, &r.masks}) {
    r.total_bytes += buffer->size_bytes;
  }
  for (const vk::Image* image : {&r.gobos, &r.surface_id, &r.depth, &r.radiance, &r.screen}) {
    r.total_bytes += image->size_bytes;
  }
  return r;
}

}  // namespace footlight::render

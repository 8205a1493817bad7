#include "render/resources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <utility>

#include "fixtures/bodies/body.h"
#include "fixtures/gobos/gobo_images.h"
#include "render/pass.h"

namespace footlight::render {
namespace {

template <class Row>
Result<vk::Buffer> table(vk::Device& device, const std::vector<Row>& rows, VkBufferUsageFlags usage = 0) {
  return vk::Buffer::filled(device, std::as_bytes(std::span(rows)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | usage);
}

// Halves an image of three values a texel a side: the mean of four texels.
std::vector<float> halved(const std::vector<float>& image, int size) {
  const auto at = [&](int row, int column, std::size_t c) {
    return image[3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(size) +
                      static_cast<std::size_t>(column)) +
                 c];
  };
  std::vector<float> half;
  half.reserve(image.size() / 4);
  for (int row = 0; row < size / 2; ++row) {
    for (int column = 0; column < size / 2; ++column) {
      for (std::size_t c = 0; c < 3; ++c) {
        half.push_back((at(2 * row, 2 * column, c) + at(2 * row, 2 * column + 1, c) + at(2 * row + 1, 2 * column, c) +
                        at(2 * row + 1, 2 * column + 1, c)) /
                       4);
      }
    }
  }
  return half;
}

std::uint8_t srgb_of(float linear) {
  const float v = std::clamp(linear, 0.0f, 1.0f);
  const float encoded = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255.0f * encoded));
}

// Gobo images as one array with all levels of detail, in colour, 8 bits sRGB a channel. A rig without gobos gets a
// single texel, since the shaders name the binding even where their specialisation never reads it.
Result<vk::Image> make_gobos(vk::Device& device, const std::vector<fixtures::ImageSource>& images,
                             fixtures::Diagnostics& diagnostics) {
  const int size = images.empty() ? 1 : kGoboSizePx;
  const auto layers = static_cast<uint>(std::max<std::size_t>(images.size(), 1));
  const std::uint32_t layers_max = device.limits().maxImageArrayLayers;
  if (layers > layers_max) {
    return fail(ErrorCode::kBadInput, "{} gobo images: expected at most {} on {}", layers, layers_max, device.name());
  }
  uint levels = 1;
  while (size >> levels > 0) ++levels;
  std::vector<std::uint8_t> texels;
  std::vector<VkBufferImageCopy> regions;
  fixtures::ImageBudget budget;
  for (uint layer = 0; layer < layers; ++layer) {
    std::vector<float> image(3, 1.0f);
    if (!images.empty()) {
      auto read = fixtures::gobo_texels(images[layer], size, kGoboEdge, &budget);
      if (read) {
        image = std::move(*read);
      } else {
        image = fixtures::stand_in_texels(layer, size, kGoboEdge);
        diagnostics.add(fixtures::image_trouble(read.error()));
      }
    }
    int level_size = size;
    for (uint level = 0; level < levels; ++level) {
      VkBufferImageCopy region{};
      region.bufferOffset = texels.size();
      region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, layer, 1};
      region.imageExtent = {static_cast<uint>(level_size), static_cast<uint>(level_size), 1};
      regions.push_back(region);
      for (std::size_t i = 0; i < image.size(); ++i) {
        texels.push_back(srgb_of(image[i]));
        if (i % 3 == 2) texels.push_back(255);
      }
      if (level_size > 1) image = halved(image, level_size);
      level_size /= 2;
    }
  }
  FL_ASSIGN(vk::Image image,
            vk::Image::create(device, static_cast<uint>(size), static_cast<uint>(size), VK_FORMAT_R8G8B8A8_SRGB,
                              VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, layers, levels));
  FL_ASSIGN(vk::Buffer staging, vk::Buffer::host_visible(device, texels.size(), 0));
  std::memcpy(staging.mapped, texels.data(), texels.size());
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, staging.handle, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<uint>(regions.size()), regions.data());
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }));
  return image;
}

// The body of a type that brings no models, its vertices' parts as FL_PART_...: every part of the mesh is brought into
// the space behind the last joint that moves it.
fixtures::BodyMesh plain_body(const fixtures::Rig& rig, const fixtures::TypeSource& source) {
  using namespace fixtures;
  const FixtureType& type = rig.types[static_cast<std::size_t>(source.type)];
  const Mode& mode = type.modes[static_cast<std::size_t>(source.mode)];
  if (source.head != 0 || mode.geometries.size() != 4) return {};
  BodyMesh mesh = make_body(type.body, body_size(type, mode));
  constexpr std::array<int, 4> kGeometryOfPart = {kSimpleBase, kSimpleYoke, kSimpleHead, kSimpleHead};
  for (BodyVertex& vertex : mesh.vertices) {
    int geometry = kGeometryOfPart[vertex.part];
    glm::dmat4 pose(1);  // from the part to the space behind the joint
    std::uint32_t depth = 0;
    for (; geometry != kNoIndex; geometry = mode.geometries[static_cast<std::size_t>(geometry)].parent) {
      const auto joint = std::find(source.joint_geometries.rbegin(), source.joint_geometries.rend(), geometry);
      if (joint != source.joint_geometries.rend()) {
        depth = static_cast<std::uint32_t>(source.joint_geometries.rend() - joint);
        break;
      }
      pose = mode.geometries[static_cast<std::size_t>(geometry)].pose * pose;
    }
    const glm::dvec3 position = pose * glm::dvec4(vertex.position[0], vertex.position[1], vertex.position[2], 1);
    const glm::dvec3 normal = glm::dmat3(pose) * glm::dvec3(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
    for (int i = 0; i < 3; ++i) {
      vertex.position[i] = static_cast<float>(position[i]);
      vertex.normal[i] = static_cast<float>(normal[i]);
    }
    vertex.part = depth | (vertex.part == kPartLens ? FL_PART_LENS : 0);
  }
  return mesh;
}

// One mesh for each row of compiled.types; empty: no body.
std::vector<fixtures::BodyMesh> bodies_of(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                                          fixtures::Diagnostics& diagnostics) {
  using namespace fixtures;
  static_assert(kBodyDepth == FL_PART_DEPTH && kBodyLens == FL_PART_LENS);
  std::size_t models = 0;
  for (const PatchedFixture& fixture : rig.fixtures) models += model_count(mode_of(rig, fixture));
  std::vector<BodyMesh> bodies;
  BodyBudget budget;
  while (bodies.size() < compiled.sources.size()) {
    // The heads of one mode are neighbours.
    const TypeSource& first = compiled.sources[bodies.size()];
    std::vector<BodyHead> heads;
    for (std::size_t t = bodies.size(); t < compiled.sources.size(); ++t) {
      const TypeSource& source = compiled.sources[t];
      if (source.type != first.type || source.mode != first.mode || (t > bodies.size() && source.head == 0)) break;
      heads.push_back({source.geometry, source.joint_geometries});
    }
    const FixtureType& type = rig.types[static_cast<std::size_t>(first.type)];
    const Mode& mode = type.modes[static_cast<std::size_t>(first.mode)];
    if (model_count(mode) > 0) {
      auto made = fixture_bodies(type, mode, heads, model_triangles(models), diagnostics, &budget);
      std::move(made.begin(), made.end(), std::back_inserter(bodies));
    } else {
      for (std::size_t i = 0; i < heads.size(); ++i) bodies.push_back(plain_body(rig, compiled.sources[bodies.size()]));
    }
  }
  return bodies;
}

// The objects of the scene in stage space; their albedo is in the parts of their vertices.
fixtures::BodyMesh objects_of(const fixtures::Rig& rig, fixtures::Diagnostics& diagnostics) {
  const fixtures::Mesh scene = fixtures::scene_mesh(rig, diagnostics);
  fixtures::BodyMesh mesh;
  mesh.indices = scene.indices;
  for (const fixtures::MeshVertex& vertex : scene.vertices) {
    const glm::vec3 albedo = glm::clamp(scene.materials[vertex.material].albedo, 0.0f, 1.0f) * 1023.0f + 0.5f;
    const std::uint32_t part = FL_OBJECT | static_cast<std::uint32_t>(albedo.x) << 20 |
                               static_cast<std::uint32_t>(albedo.y) << 10 | static_cast<std::uint32_t>(albedo.z);
    const glm::vec3& p = vertex.position_m;
    const glm::vec3& n = vertex.normal;
    mesh.vertices.push_back({{p.x, p.y, p.z}, {n.x, n.y, n.z}, part});
  }
  return mesh;
}

// One mesh buffer for the bodies of all types and the objects, heads sorted by type, one indirect command a type.
Status make_bodies(vk::Device& device, const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                   fixtures::Diagnostics& diagnostics, Resources& r) {
  std::vector<fixtures::BodyVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<std::uint32_t> instances;
  std::vector<VkDrawIndexedIndirectCommand> draws;
  const auto add = [&](const fixtures::BodyMesh& mesh, std::uint32_t count, std::uint32_t first_instance) {
    draws.push_back({static_cast<std::uint32_t>(mesh.indices.size()), count, static_cast<std::uint32_t>(indices.size()),
                     static_cast<std::int32_t>(vertices.size()), first_instance});
    vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
  };
  const std::vector<fixtures::BodyMesh> bodies = bodies_of(rig, compiled, diagnostics);
  for (std::uint32_t t = 0; t < compiled.types.size(); ++t) {
    const fixtures::BodyMesh& mesh = bodies[t];
    if (mesh.indices.empty()) continue;
    const auto first_instance = static_cast<std::uint32_t>(instances.size());
    for (std::uint32_t i = 0; i < compiled.heads.size(); ++i) {
      if (compiled.heads[i].type == t) instances.push_back(i);
    }
    const auto count = static_cast<std::uint32_t>(instances.size()) - first_instance;
    add(mesh, count, first_instance);
  }
  r.draw_count = static_cast<std::uint32_t>(draws.size());
  if (const fixtures::BodyMesh objects = objects_of(rig, diagnostics); !objects.indices.empty()) {
    add(objects, 1, 0);
    for (const fixtures::BodyVertex& vertex : objects.vertices) {
      const glm::dvec3 at(vertex.position[0], vertex.position[1], vertex.position[2]);
      r.objects.low_m = glm::min(r.objects.low_m, at);
      r.objects.high_m = glm::max(r.objects.high_m, at);
    }
    r.object_draw_count = 1;
  }
  FL_ASSIGN(r.vertices, table(device, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT));
  FL_ASSIGN(r.indices, table(device, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT));
  FL_ASSIGN(r.instances, table(device, instances));
  FL_ASSIGN(r.draws, table(device, draws, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
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
  r.head_count = static_cast<std::uint32_t>(compiled.heads.size());
  r.head_groups = (r.head_count + FL_GROUP_HEADS - 1) / FL_GROUP_HEADS;
  r.motor_count = compiled.motor_count;
  r.spin_count = compiled.spin_count;
  r.shutter_count = compiled.strobe_count;
  r.optics_count = compiled.optics_count;
  r.lamp_counts = compiled.lamp_counts;
  r.dowser_count = compiled.dowser_count;
  r.smooth_count = compiled.flex_count + compiled.smooth_count;
  r.box_count = static_cast<std::uint32_t>(rig.boxes.size());
  r.supertiles_x = (width + FL_SUPERTILE_PX - 1) / FL_SUPERTILE_PX;
  r.supertiles_y = (height + FL_SUPERTILE_PX - 1) / FL_SUPERTILE_PX;
  // Words come in pairs, as one group of the tile pass writes them.
  r.mask_words = (compiled.beams_max + FL_GROUP_MASK - 1) / FL_GROUP_MASK * (FL_GROUP_MASK / 32);
  r.levels_bytes = compiled.universes.size() * kSlotCountMax;

  FL_ASSIGN(r.types, table(device, compiled.types));
  FL_ASSIGN(r.channels, table(device, compiled.channels));
  FL_ASSIGN(r.functions, table(device, compiled.functions));
  FL_ASSIGN(r.masters, table(device, compiled.masters));
  FL_ASSIGN(r.motors, table(device, compiled.motors));
  FL_ASSIGN(r.spins, table(device, compiled.spins));
  FL_ASSIGN(r.joints, table(device, compiled.joints));
  FL_ASSIGN(r.wheels, table(device, compiled.wheels));
  FL_ASSIGN(r.facets, table(device, compiled.facets));
  FL_ASSIGN(r.lights, table(device, compiled.lights));
  FL_ASSIGN(r.wheel_slots, table(device, compiled.wheel_slots));
  FL_ASSIGN(r.defaults, table(device, compiled.defaults));
  FL_ASSIGN(r.colors, table(device, compiled.colors));
  FL_ASSIGN(r.heads, table(device, compiled.heads));
  std::vector<BoxRow> boxes;
  for (const auto& box : rig.boxes) {
    boxes.push_back({vec4(box.min_m, 0), vec4(box.max_m, 0), vec4(box.albedo, 0)});
  }
  FL_ASSIGN(r.boxes, table(device, boxes));
  fixtures::Diagnostics diagnostics;
  if (has_bodies(compiled.needs, settings)) {
    FL_TRY(make_bodies(device, rig, compiled, diagnostics, r));
    r.bindings.set_buffer(FL_BINDING_INSTANCES, r.instances);
  }
  FL_ASSIGN(r.gobos, make_gobos(device, compiled.images, diagnostics));
  diagnostics.finish();
  r.diagnostics = diagnostics.take();

  FL_ASSIGN(r.params, zeroed(device, sizeof(FrameParams)));
  FL_ASSIGN(r.levels, zeroed(device, r.levels_bytes));
  if (r.levels_bytes > kUpdateBytesMax) {
    FL_ASSIGN(r.staged_levels, vk::Buffer::host_visible(device, r.levels_bytes, 0));
  }
  FL_ASSIGN(r.states, zeroed(device, r.head_count * kStateBytes));
  FL_ASSIGN(r.motor_states, zeroed(device, compiled.motor_count * kMotorStateBytes));
  FL_ASSIGN(r.spin_states, zeroed(device, compiled.spin_count * kSpinStateBytes));
  FL_ASSIGN(r.shutter_states, zeroed(device, compiled.strobe_count * kShutterStateBytes));
  FL_ASSIGN(r.beams, zeroed(device, compiled.beams_max * sizeof(BeamRow)));
  FL_ASSIGN(r.blades, zeroed(device, compiled.needs.blades ? compiled.beams_max * sizeof(BladesRow) : 0));
  FL_ASSIGN(r.optics_states, zeroed(device, compiled.optics_count * kOpticsStateBytes));
  for (std::size_t lamp = 1; lamp < r.lamp_states.size(); ++lamp) {
    FL_ASSIGN(r.lamp_states[lamp], zeroed(device, compiled.lamp_counts[lamp] * kLampStateBytes));
  }
  FL_ASSIGN(r.dowser_states, zeroed(device, compiled.dowser_count * kDowserStateBytes));
  FL_ASSIGN(r.smooth_states, zeroed(device, r.smooth_count * kSmoothStateBytes));
  FL_ASSIGN(r.counts, zeroed(device, sizeof(CountsRow) + r.head_groups * 8, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT));
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
  const auto side = static_cast<std::uint32_t>(settings.supersample);
  FL_ASSIGN(r.screen, vk::Image::create(device, width / side, height / side, VK_FORMAT_R8G8B8A8_UNORM, kPicture));
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    for (const vk::Image* image : {&r.surface_id, &r.depth, &r.radiance, &r.screen}) {
      vk::change_layout(commands, *image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    }
    const VkClearColorValue black{{0, 0, 0, 1}};  // opaque: what a picture without a pass shows
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(commands, r.radiance.handle, VK_IMAGE_LAYOUT_GENERAL, &black, 1, &range);
    vkCmdClearColorImage(commands, r.screen.handle, VK_IMAGE_LAYOUT_GENERAL, &black, 1, &range);
  }));

  std::vector<std::pair<std::uint32_t, const vk::Buffer*>> buffers = {
      {FL_BINDING_PARAMS, &r.params},
      {FL_BINDING_LEVELS, &r.levels},
      {FL_BINDING_TYPES, &r.types},
      {FL_BINDING_CHANNELS, &r.channels},
      {FL_BINDING_FUNCTIONS, &r.functions},
      {FL_BINDING_MASTERS, &r.masters},
      {FL_BINDING_MOTORS, &r.motors},
      {FL_BINDING_SPINS, &r.spins},
      {FL_BINDING_JOINTS, &r.joints},
      {FL_BINDING_WHEEL_SLOTS, &r.wheel_slots},
      {FL_BINDING_DEFAULTS, &r.defaults},
      {FL_BINDING_COLORS, &r.colors},
      {FL_BINDING_HEADS, &r.heads},
      {FL_BINDING_STATES, &r.states},
      {FL_BINDING_MOTOR_STATES, &r.motor_states},
      {FL_BINDING_SPIN_STATES, &r.spin_states},
      {FL_BINDING_SHUTTER_STATES, &r.shutter_states},
      {FL_BINDING_BEAMS, &r.beams},
      {FL_BINDING_COUNTS, &r.counts},
      {FL_BINDING_MASKS, &r.masks},
      {FL_BINDING_BOXES, &r.boxes},
      {FL_BINDING_WHEELS, &r.wheels},
      {FL_BINDING_FACETS, &r.facets},
      {FL_BINDING_OPTICS_STATES, &r.optics_states},
      {FL_BINDING_BLADES, &r.blades},
      {FL_BINDING_LIGHTS, &r.lights},
      {FL_BINDING_DOWSER_STATES, &r.dowser_states},
      {FL_BINDING_SMOOTH_STATES, &r.smooth_states},
  };
  for (std::uint32_t lamp = 1; lamp < r.lamp_states.size(); ++lamp) {
    buffers.emplace_back(FL_BINDING_LAMP(lamp), &r.lamp_states[lamp]);
  }
  for (const auto& [binding, buffer] : buffers) {
    r.bindings.set_buffer(binding, *buffer);
    r.total_bytes += buffer->size_bytes;
  }
  r.bindings.set_image(FL_BINDING_SURFACE_ID, r.surface_id);
  r.bindings.set_image(FL_BINDING_DEPTH, r.depth);
  r.bindings.set_image(FL_BINDING_RADIANCE, r.radiance);
  r.bindings.set_image(FL_BINDING_SCREEN, r.screen);
  r.bindings.set_image(FL_BINDING_GOBOS, r.gobos, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);

  for (const vk::Buffer* buffer : {&r.instances, &r.vertices, &r.indices, &r.draws})
    r.total_bytes += buffer->size_bytes;
  for (const vk::Image* image : {&r.gobos, &r.surface_id, &r.depth, &r.radiance, &r.screen}) {
    r.total_bytes += image->size_bytes;
  }
  return r;
}

void forget_states(VkCommandBuffer commands, const Resources& resources) {
  vk::full_barrier(commands);
  for (const vk::Buffer* buffer : resources.all_states())
    vkCmdFillBuffer(commands, buffer->handle, 0, VK_WHOLE_SIZE, 0);
  vk::full_barrier(commands);
}

void take_states(VkCommandBuffer commands, const Resources& from, const Resources& to) {
  vk::full_barrier(commands);
  for (std::size_t i = 0; i < from.all_states().size(); ++i) {
    const VkBufferCopy all{0, 0, std::min(from.all_states()[i]->size_bytes, to.all_states()[i]->size_bytes)};
    vkCmdCopyBuffer(commands, from.all_states()[i]->handle, to.all_states()[i]->handle, 1, &all);
  }
  vk::full_barrier(commands);
}

}  // namespace footlight::render

#include "render/texture_tables.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "fixtures/glass/pane.h"
#include "fixtures/model/srgb.h"

namespace footlight::render {
namespace {

fixtures::PaneImage light_of(const fixtures::RgbImage& coded) {
  fixtures::PaneImage light{coded.width, coded.height, {}};
  light.texels.clear();
  light.texels.reserve(coded.rgb.size() / 3);
  float linear[256];
  for (int i = 0; i < 256; ++i) linear[i] = fixtures::linear_of_srgb(static_cast<float>(i) / 255.0f);
  for (std::size_t i = 0; i + 2 < coded.rgb.size(); i += 3) {
    light.texels.emplace_back(linear[coded.rgb[i]], linear[coded.rgb[i + 1]], linear[coded.rgb[i + 2]]);
  }
  return light;
}

// Adds the texels of all levels; returns how many levels there are.
std::uint32_t add_levels(fixtures::PaneImage image, std::vector<std::uint32_t>& texels) {
  for (std::uint32_t levels = 1;; ++levels) {
    for (const glm::vec3& light : image.texels) {
      const glm::vec3 root = glm::sqrt(glm::clamp(light, 0.0f, 1.0f)) * 1023.0f + 0.5f;
      texels.push_back(static_cast<std::uint32_t>(root.x) << 20 | static_cast<std::uint32_t>(root.y) << 10 |
                       static_cast<std::uint32_t>(root.z));
    }
    if (image.width == 1 && image.height == 1) return levels;
    image = fixtures::halved(image);
  }
}

}  // namespace

ObjectTextures object_textures(const fixtures::Mesh& scene, SheenTable& sheens) {
  ObjectTextures made;
  std::map<const fixtures::RgbImage*, TextureRow> known;
  for (const fixtures::MeshMaterial& material : scene.materials) {
    made.material.push_back(FL_NONE);
    const std::uint32_t sheen = sheens.number(material.sheen);
    if (!material.texture && sheen == 0) continue;
    const vec4 albedo(glm::clamp(material.albedo, 0.0f, 1.0f), sheen);
    if (!material.texture) {
      made.material.back() = static_cast<std::uint32_t>(made.rows.size());
      made.rows.push_back({albedo, 0, 0, 0, 1});
      continue;
    }
    const fixtures::MeshTexture& texture = *material.texture;
    const auto [place, is_new] = known.try_emplace(texture.image.get());
    if (is_new) {
      place->second.texel_first = static_cast<std::uint32_t>(made.texels.size());
      place->second.width = static_cast<std::uint32_t>(texture.image->width);
      place->second.height = static_cast<std::uint32_t>(texture.image->height);
      place->second.modes = add_levels(light_of(*texture.image), made.texels);  // the number of levels
    }
    made.material.back() = static_cast<std::uint32_t>(made.rows.size());
    made.rows.push_back(place->second);
    made.rows.back().modes |= static_cast<std::uint32_t>(texture.wrap_u) << FL_TEXTURE_WRAP_U |
                              static_cast<std::uint32_t>(texture.wrap_v) << FL_TEXTURE_WRAP_V;
    made.rows.back().albedo = albedo;
  }
  if (made.rows.empty()) return made;
  for (const fixtures::MeshVertex& vertex : scene.vertices) made.uvs.push_back(vertex.uv);
  return made;
}

Status make_texture_tables(vk::Device& device, const ObjectTextures& textures, RigTables& r) {
  if (textures.rows.empty()) return {};
  const std::uint64_t bytes = std::max(textures.texels.size() * sizeof(std::uint32_t),
                                       textures.uvs.size() * sizeof(glm::vec2));
  if (bytes > device.limits().maxStorageBufferRange) {
    return fail(ErrorCode::kUnsupported,
                "{}: maxStorageBufferRange is {}, needed: {} bytes for the textures of objects; use smaller images",
                device.name(), device.limits().maxStorageBufferRange, bytes);
  }
  r.texture_count = static_cast<std::uint32_t>(textures.rows.size());
  FL_ASSIGN(r.textures, vk::Buffer::table(device, textures.rows));
  FL_ASSIGN(r.texture_texels, vk::Buffer::table(device, textures.texels));
  FL_ASSIGN(r.object_uvs, vk::Buffer::table(device, textures.uvs));
  return {};
}

}  // namespace footlight::render

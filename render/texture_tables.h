// Textures of the objects of the scene, as tables.
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/bodies/mesh.h"
#include "render/resources.h"

namespace footlight::render {

struct ObjectTextures {
  std::vector<TextureRow> rows;         // one a textured material
  std::vector<std::uint32_t> texels;    // of all images and their levels: roots of light, 10 bits each from blue to red
  std::vector<glm::vec2> uvs;           // one a vertex; empty where no material has a texture
  std::vector<std::uint32_t> material;  // the row of each material; FL_NONE: it has a plain colour
};
// Images that several textures share are there once.
[[nodiscard]] ObjectTextures object_textures(const fixtures::Mesh& scene);

// Makes the three tables, none where there are no textures. Fails if a table of the device is too small for them.
Status make_texture_tables(vk::Device& device, const ObjectTextures& textures, RigTables& r);

}  // namespace footlight::render

// Textures of the objects of the scene, as tables.
#pragma once

#include <cstdint>
#include <vector>

#include "fixtures/bodies/mesh.h"
#include "render/resources.h"
#include "render/sheen_tables.h"

namespace footlight::render {

struct ObjectTextures {
  std::vector<TextureRow> rows;         // one a material with a texture or sheen
  std::vector<std::uint32_t> texels;    // of all images and their levels: roots of light, 10 bits each from blue to red
  std::vector<glm::vec2> uvs;           // one a vertex; empty where there are no rows
  std::vector<std::uint32_t> material;  // the row of each material; FL_NONE: it has a plain colour and is matt
};
// Images that several textures share are there once. A material with sheen has a row as well, without an image where it
// has none.
[[nodiscard]] ObjectTextures object_textures(const fixtures::Mesh& scene, SheenTable& sheens);

// Makes the three tables, none where there are no textures. Fails if a table of the device is too small for them.
Status make_texture_tables(vk::Device& device, const ObjectTextures& textures, RigTables& r);

}  // namespace footlight::render

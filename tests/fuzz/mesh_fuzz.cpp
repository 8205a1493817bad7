// 3DS and glTF with images; valid meshes are scaled, mirrored and simplified.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fixtures/bodies/mesh.h"
#include "fixtures/gobos/png.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/model_bytes.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  seeds.add("box.3ds", box_3ds(100, 200, 300));
  const auto turned = chunk(0xA351, u16_text(2)) + chunk(0xA356, f32_text(2)) + chunk(0xA35C, f32_text(30));
  seeds.add("print.3ds", quad_3ds(texture_3ds("PRINT.PNG", turned)));
  seeds.add("missing.3ds", quad_3ds(texture_3ds("none.png") + texture_3ds("print.png"), {0, 0, 1, 0}));
  seeds.add("box.glb", box_glb(1, 2, 3));
  seeds.add("mirrored.glb", box_glb(1, 2, 3, R"("scale":[-1,1,1])"));
  TexturedQuad quad;
  const auto png = fixtures::png_of(2, 1, 3, std::vector<std::uint8_t>{0, 1, 2, 100, 200, 255});
  quad.image.assign(reinterpret_cast<const char*>(png.data()), png.size());
  quad.texture_words = R"(,"extensions":{"KHR_texture_transform":{"offset":[0,1],"rotation":1,"scale":[2,2]}})";
  seeds.add("print.glb", quad_glb(quad));
  // The image ends after its buffer.
  const std::string view = fmt::format(R"("byteOffset":92,"byteLength":{})", png.size());
  quad.edits = {{view, R"("byteOffset":92,"byteLength":4096)"}};
  seeds.add("beyond.glb", quad_glb(quad));
  seeds.add("strip.gltf",
            R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
            R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
            R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
            R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":5}]}]})");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fixtures::Diagnostics diagnostics;
  // A name with a "p" is that of an image.
  static const auto png = fixtures::png_of(2, 1, 3, std::vector<std::uint8_t>{0, 1, 2, 100, 200, 255});
  const fixtures::MeshFiles beside{
      [](const std::string& named) { return named.find_first_of("pP") == std::string::npos ? std::string() : named; },
      [](const std::string&) -> Result<fixtures::Bytes> { return fixtures::Bytes(png.begin(), png.end()); }};
  (void)fixtures::image_names_3ds(std::as_bytes(std::span<const std::uint8_t>(data, size)));
  const auto mesh = fixtures::read_mesh(std::as_bytes(std::span<const std::uint8_t>(data, size)), "fuzz", diagnostics,
                                        nullptr, fixtures::MeshImages::kBaseColor, beside);
  if (!mesh) {
    require(mesh.error().message.starts_with("fuzz"));
    return 0;
  }
  require(!mesh->indices.empty() && mesh->indices.size() % 3 == 0);
  for (const std::uint32_t index : mesh->indices) require(index < mesh->vertices.size());
  for (const fixtures::MeshVertex& vertex : mesh->vertices) {
    require(vertex.material < mesh->materials.size());
    require(std::abs(glm::length(vertex.normal) - 1) < 1e-3F);
    require(glm::length(vertex.uv) < 2e5F);
  }
  for (const fixtures::MeshMaterial& material : mesh->materials) {
    if (!material.texture) continue;
    const fixtures::RgbImage& image = *material.texture->image;
    require(image.width > 0 && image.height > 0 && std::max(image.width, image.height) <= fixtures::kTexturePxMax);
    require(image.rgb.size() == 3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  }
  const fixtures::Mesh scaled = scaled_to(*mesh, {1, 2, 0});
  require(scaled.indices.size() == mesh->indices.size());
  require(simplified(scaled, 4).indices.size() <= scaled.indices.size());
  return 0;
}

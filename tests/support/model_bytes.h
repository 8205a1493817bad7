// 3DS and glTF files made in memory, valid or damaged on purpose.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fixtures/files/files.h"

namespace footlight::testing {

using fixtures::Bytes;

// A chunk of 3DS: id, length, content.
[[nodiscard]] std::string chunk(std::uint16_t id, std::string_view content);
[[nodiscard]] std::string u16_text(std::uint16_t value);
[[nodiscard]] std::string f32_text(float value);
// A 3DS file with one object of these points and faces; all faces in material "paint" of this byte colour.
// material: further chunks of it; uvs: places of the points in its texture.
[[nodiscard]] std::string file_3ds(const std::vector<float>& points_xyz, const std::vector<std::uint16_t>& corners,
                                   const std::uint8_t (&color)[3], const std::string& material = {},
                                   const std::vector<float>& uvs = {});
// The chunk of a texture with this file name.
[[nodiscard]] std::string texture_3ds(const std::string& file, const std::string& chunks = {});
// An upright square of 1 m that faces -y, with a texture whose lower left corner is at its lower left one.
[[nodiscard]] std::string quad_3ds(const std::string& texture,
                                   const std::vector<float>& uvs = {0, 0, 1, 0, 1, 1, 0, 1});
// A box of this size in units, from the origin, faces outwards.
[[nodiscard]] std::string box_3ds(float x, float y, float z);

// A .glb with this JSON and binary chunk.
[[nodiscard]] std::string file_glb(std::string_view json, std::string_view binary);
// Of a box of this size, from the origin, y up; `node` is added to its node: "\"scale\":[-1,1,1]".
[[nodiscard]] std::string box_glb(float x, float y, float z, std::string_view node = "");

// A .glb of an upright rectangle that faces -y, its lower edge at z = 0, with a textured material.
struct TexturedQuad {
  float width_m = 1;
  float height_m = 1;
  std::vector<float> uvs{0, 1, 1, 1, 1, 0, 0, 0};     // from the lower left corner, counter-clockwise
  std::string image;                                  // bytes of a PNG or JPEG file
  std::string image_words = R"("mimeType":"image/png","bufferView":3)";  // of the image's row
  std::string sampler = "{}";
  std::string texture_words;  // added to the material's texture, with a comma before it
  std::vector<std::pair<std::string, std::string>> edits;  // texts of the JSON, what replaces them; one missing: ""
};
[[nodiscard]] std::string quad_glb(const TexturedQuad& quad);

[[nodiscard]] Bytes bytes_of(std::string_view text);

// Files in memory, not in a file system.
class MemoryFiles final : public fixtures::Files {
 public:
  explicit MemoryFiles(std::map<std::string, std::string> files);
  [[nodiscard]] const std::vector<std::string>& names() const override { return names_; }
  [[nodiscard]] Result<Bytes> read(std::string_view name, std::uint64_t size_max_bytes) const override;
  [[nodiscard]] std::string shown_name(std::string_view name) const override { return "z:" + std::string(name); }

 private:
  std::map<std::string, std::string> files_;
  std::vector<std::string> names_;
};

}  // namespace footlight::testing

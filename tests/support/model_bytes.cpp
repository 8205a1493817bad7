#include "tests/support/model_bytes.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

namespace footlight::testing {
namespace {

// Corners of a box: bit 0 is x, bit 1 y, bit 2 z. Twelve triangles, counter-clockwise from outside.
constexpr std::uint16_t kBoxCorners[] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};

std::vector<float> box_points(float x, float y, float z) {
  std::vector<float> points;
  for (int i = 0; i < 8; ++i) {
    points.insert(points.end(), {(i & 1) != 0 ? x : 0, (i & 2) != 0 ? y : 0, (i & 4) != 0 ? z : 0});
  }
  return points;
}

std::string u32_text(std::uint32_t value) {
  return u16_text(static_cast<std::uint16_t>(value)) + u16_text(static_cast<std::uint16_t>(value >> 16));
}

}  // namespace

std::string u16_text(std::uint16_t value) { return {static_cast<char>(value & 0xFF), static_cast<char>(value >> 8)}; }

std::string f32_text(float value) {
  std::uint32_t word = 0;
  std::memcpy(&word, &value, 4);
  return u32_text(word);
}

std::string chunk(std::uint16_t id, std::string_view content) {
  return u16_text(id) + u32_text(static_cast<std::uint32_t>(content.size() + 6)) + std::string(content);
}

std::string file_3ds(const std::vector<float>& points_xyz, const std::vector<std::uint16_t>& corners,
                     const std::uint8_t (&color)[3], const std::string& more, const std::vector<float>& uvs) {
  const auto faces = static_cast<std::uint16_t>(corners.size() / 3);
  std::string points = u16_text(static_cast<std::uint16_t>(points_xyz.size() / 3));
  for (const float value : points_xyz) points += f32_text(value);
  std::string list = u16_text(faces);
  std::string painted = std::string("paint") + '\0' + u16_text(faces);
  for (std::uint16_t face = 0; face < faces; ++face) {
    for (std::size_t k = 0; k < 3; ++k) list += u16_text(corners[face * 3U + k]);
    list += u16_text(7);
    painted += u16_text(face);
  }
  list += chunk(0x4130, painted);
  const std::string rgb{static_cast<char>(color[0]), static_cast<char>(color[1]), static_cast<char>(color[2])};
  const std::string material = chunk(0xA000, std::string("paint") + '\0') + chunk(0xA020, chunk(0x0011, rgb)) + more;
  std::string places = u16_text(static_cast<std::uint16_t>(uvs.size() / 2));
  for (const float value : uvs) places += f32_text(value);
  if (!uvs.empty()) list = chunk(0x4120, list) + chunk(0x4140, places);
  const std::string mesh = chunk(0x4100, chunk(0x4110, points) + (uvs.empty() ? chunk(0x4120, list) : list));
  return chunk(0x4D4D, chunk(0x0002, "\3\0\0\0") +
                           chunk(0x3D3D, chunk(0x4000, std::string("box") + '\0' + mesh) + chunk(0xAFFF, material)));
}

std::string texture_3ds(const std::string& file, const std::string& chunks) {
  return chunk(0xA200, chunk(0x0030, u16_text(100)) + chunk(0xA300, file + '\0') + chunks);
}

std::string quad_3ds(const std::string& texture, const std::vector<float>& uvs) {
  return file_3ds({0, 0, 0, 1000, 0, 0, 1000, 0, 1000, 0, 0, 1000}, {0, 1, 2, 0, 2, 3}, {255, 0, 128}, texture, uvs);
}

std::string box_3ds(float x, float y, float z) {
  return file_3ds(box_points(x, y, z), {std::begin(kBoxCorners), std::end(kBoxCorners)}, {255, 0, 128});
}

std::string file_glb(std::string_view json, std::string_view binary) {
  std::string padded_json(json);
  while (padded_json.size() % 4 != 0) padded_json += ' ';
  std::string padded_binary(binary);
  while (padded_binary.size() % 4 != 0) padded_binary += '\0';
  std::string body = u32_text(static_cast<std::uint32_t>(padded_json.size())) + "JSON" + padded_json;
  if (!padded_binary.empty()) {
    body += u32_text(static_cast<std::uint32_t>(padded_binary.size())) + std::string("BIN\0", 4) + padded_binary;
  }
  return "glTF" + u32_text(2) + u32_text(static_cast<std::uint32_t>(body.size() + 12)) + body;
}

std::string box_glb(float x, float y, float z, std::string_view node) {
  std::string binary;
  for (const float value : box_points(x, y, z)) binary += f32_text(value);
  for (const std::uint16_t corner : kBoxCorners) binary += u16_text(corner);
  const std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{}{}}}],)"
      R"("materials":[{{"name":"paint","pbrMetallicRoughness":{{"baseColorFactor":[0.5,0.25,1,1]}}}}],)"
      R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],)"
      R"("buffers":[{{"byteLength":{}}}],"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":96}},)"
      R"({{"buffer":0,"byteOffset":96,"byteLength":72}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":8,)"
      R"("type":"VEC3","min":[0,0,0],"max":[{},{},{}]}},{{"bufferView":1,"componentType":5123,"count":36,)"
      R"("type":"SCALAR"}}]}})",
      node.empty() ? "" : ",", node, binary.size(), x, y, z);
  return file_glb(json, binary);
}

std::string quad_glb(const TexturedQuad& quad) {
  const float x = quad.width_m / 2;
  std::string binary;
  for (const float value : {-x, 0.0F, 0.0F, x, 0.0F, 0.0F, x, quad.height_m, 0.0F, -x, quad.height_m, 0.0F}) {
    binary += f32_text(value);
  }
  for (const float value : quad.uvs) binary += f32_text(value);
  for (const int corner : {0, 1, 2, 0, 2, 3}) binary += u16_text(static_cast<std::uint16_t>(corner));
  binary += quad.image;
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],)"
      R"("materials":[{{"name":"print","pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,1,1],)"
      R"("baseColorTexture":{{"index":0{}}}}}}}],"textures":[{{"source":0,"sampler":0}}],"samplers":[{}],)"
      R"("images":[{{"name":"print.png",{}}}],)"
      R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0}}]}}],)"
      R"("buffers":[{{"byteLength":{}}}],"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":48}},)"
      R"({{"buffer":0,"byteOffset":48,"byteLength":32}},{{"buffer":0,"byteOffset":80,"byteLength":12}},)"
      R"({{"buffer":0,"byteOffset":92,"byteLength":{}}}],)"
      R"("accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[{},0,0],"max":[{},{},0]}},)"
      R"({{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},)"
      R"({{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}}]}})",
      quad.texture_words, quad.sampler, quad.image_words, std::max<std::size_t>(binary.size(), 93),
      std::max<std::size_t>(quad.image.size(), 1), -x, x, quad.height_m);
  for (const auto& [from, to] : quad.edits) {
    const std::size_t at = json.find(from);
    if (at == std::string::npos) return {};
    json.replace(at, from.size(), to);
  }
  return file_glb(json, quad.image.empty() ? binary + '\0' : binary);
}

Bytes bytes_of(std::string_view text) {
  Bytes bytes(text.size());
  std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return bytes;
}

MemoryFiles::MemoryFiles(std::map<std::string, std::string> files) : files_(std::move(files)) {
  for (const auto& [name, text] : files_) names_.push_back(name);
}

Result<Bytes> MemoryFiles::read(std::string_view name, std::uint64_t size_max_bytes) const {
  const auto at = files_.find(std::string(name));
  if (at == files_.end()) return fail(ErrorCode::kNotFound, "{}: not there", shown_name(name));
  if (at->second.size() > size_max_bytes) return fail(ErrorCode::kBadInput, "{}: too large", shown_name(name));
  return bytes_of(at->second);
}

}  // namespace footlight::testing

#include "render/pane_tables.h"

#include "render/pane_groups.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <glm/gtc/packing.hpp>

namespace footlight::render {
namespace {

// Where the texels of each image begin, in the order of the panes; one image has one place.
std::vector<std::pair<const fixtures::PaneImage*, std::uint64_t>> places_of(const fixtures::Rig& rig,
                                                                            std::uint64_t& texels) {
  std::vector<std::pair<const fixtures::PaneImage*, std::uint64_t>> places;
  std::map<const fixtures::PaneImage*, std::uint64_t> known;
  texels = 0;
  for (const fixtures::Pane& pane : rig.panes) {
    const fixtures::PaneImage* image = &image_of(pane);
    const auto [place, is_new] = known.try_emplace(image, texels);
    if (is_new) texels += fixtures::texels_with_levels(*image);
    places.emplace_back(image, place->second);
  }
  return places;
}

std::uint32_t levels_of(const fixtures::PaneImage& image) {
  std::uint32_t levels = 1;
  for (int side = std::max(image.width, image.height); side > 1; side = (side + 1) / 2) ++levels;
  return levels;
}

void add_texels(fixtures::PaneImage image, glm::uvec2* out) {
  for (;;) {
    for (const glm::vec3& texel : image.texels) {
      *out++ = {glm::packHalf2x16({texel.r, texel.g}), glm::packHalf2x16({texel.b, 0})};
    }
    if (image.width == 1 && image.height == 1) return;
    image = fixtures::halved(image);
  }
}

}  // namespace

const fixtures::PaneImage& image_of(const fixtures::Pane& pane) {
  static const fixtures::PaneImage kClear;
  return pane.image ? *pane.image : kClear;
}

std::vector<PaneRow> pane_rows(const fixtures::Rig& rig) {
  std::uint64_t texels = 0;
  const auto places = places_of(rig, texels);
  const glm::dvec3 sun = rig.sun.direction;
  const glm::dvec3 sun_lx = fixtures::sun_lx(rig.sun);
  std::vector<PaneRow> rows;
  for (std::size_t i = 0; i < rig.panes.size(); ++i) {
    const fixtures::Pane& pane = rig.panes[i];
    const glm::dmat4 pose = fixtures::pose_of(pane);
    const glm::dvec3 right = glm::dvec3(pose[0]) * (pane.width_m / 2);
    const glm::dvec3 up = glm::dvec3(pose[2]) * (pane.height_m / 2);
    const glm::dvec3 normal = glm::cross(glm::dvec3(pose[0]), glm::dvec3(pose[2]));
    const bool shines = std::abs(glm::dot(normal, sun)) >= kPaneCosineLeast;
    const glm::dvec3 along = shines ? sun : normal;
    const double volume = glm::dot(glm::cross(right, up), along);
    const fixtures::PaneImage& image = *places[i].first;
    PaneRow row{};
    row.center = vec4(pane.position_m, std::hypot(pane.width_m, pane.height_m) / 2);
    row.across = vec4(glm::cross(up, along) / volume, 0);
    row.upward = vec4(glm::cross(along, right) / volume, 0);
    row.along = vec4(glm::cross(right, up) / volume, 0);
    row.sun = vec4(sun, 0);
    row.light = vec4(shines ? sun_lx * pane.color : glm::dvec3(0), 0);
    row.glass = vec4(rig.sun.sky_lx / std::numbers::pi * pane.color, 0);
    row.texel_first = static_cast<std::uint32_t>(places[i].second);
    row.width = static_cast<std::uint32_t>(image.width);
    row.height = static_cast<std::uint32_t>(image.height);
    row.levels = levels_of(image);
    rows.push_back(row);
  }
  return rows;
}

std::uint64_t pane_texel_bytes(const fixtures::Rig& rig) {
  std::uint64_t texels = 0;
  (void)places_of(rig, texels);
  return texels * sizeof(glm::uvec2);
}

std::uint64_t pane_mask_bytes(const fixtures::Rig& rig, std::uint64_t occluders) {
  return std::max<std::uint64_t>(rig.panes.size() * ((occluders + 31) / 32), 1) * 4;
}

Status make_pane_tables(vk::Device& device, const fixtures::Rig& rig, bool has_sums, RigTables& r) {
  std::uint64_t count = 0;
  const auto places = places_of(rig, count);
  if (const std::uint64_t bytes = pane_texel_bytes(rig); bytes > device.limits().maxStorageBufferRange) {
    return fail(ErrorCode::kUnsupported,
                "{}: maxStorageBufferRange is {}, needed: {} bytes for the images of panes; use smaller images",
                device.name(), device.limits().maxStorageBufferRange, bytes);
  }
  std::vector<glm::uvec2> texels(count);
  std::uint64_t done = 0;
  for (const auto& [image, first] : places) {
    if (first < done) continue;
    add_texels(*image, texels.data() + first);
    done = first + fixtures::texels_with_levels(*image);
  }
  r.pane_count = static_cast<std::uint32_t>(rig.panes.size());
  const std::uint64_t occluders = r.occluders.size_bytes / sizeof(OccluderRow);
  r.occluder_words = static_cast<std::uint32_t>((occluders + 31) / 32);
  const std::vector<PaneRow> rows = pane_rows(rig);
  FL_ASSIGN(r.panes, vk::Buffer::table(device, rows));
  FL_ASSIGN(r.pane_texels, vk::Buffer::table(device, texels));
  FL_ASSIGN(r.pane_masks,
            vk::Buffer::device_local(device, pane_mask_bytes(rig, occluders), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  return make_pane_groups(device, rig, has_sums, r);
}

}  // namespace footlight::render

#include "render/display_films.h"

#include <cstring>

#include "render/display_tables.h"
#include "sim/core/check.h"

namespace footlight::render {

Status DisplayFilms::create(vk::Device& device, const MemoryShape& shape, const RigTables& rig) {
  const auto& displays = shape.rig.displays;
  displays_ = displays.size();
  FL_TRY(projections_.create(device, shape, rig));
  VkDeviceSize bytes = 0;
  DisplayTables tables;
  for (std::size_t i = 0; i < displays.size(); ++i) {
    if (!fixtures::shows_film(displays[i])) continue;
    if (films_.empty()) tables = display_tables(shape.rig, shape.compiled);
    const VkDeviceSize first = VkDeviceSize{tables.rows[i].pixel_first} * kPixelBytes;
    films_.push_back({i, displays[i].columns, displays[i].rows, bytes, first, nullptr});
    bytes += static_cast<VkDeviceSize>(displays[i].columns) * static_cast<VkDeviceSize>(displays[i].rows) *
             kPixelBytes;
  }
  if (bytes > 0) {
    FL_ASSIGN(staged_, vk::Buffer::host_visible(device, bytes, 0));
  }
  return {};
}

void DisplayFilms::show(std::size_t display, const std::shared_ptr<const fixtures::PaneImage>& pixels) {
  if (display >= displays_) projections_.show(display - displays_, pixels);
  for (Film& film : films_) {
    if (film.display != display) continue;
    FL_CHECK_EQ(pixels->width, film.columns);
    FL_CHECK_EQ(pixels->height, film.rows);
    film.pixels = pixels;
  }
}

void DisplayFilms::record(VkCommandBuffer commands, RigTables& rig, std::span<const std::uint8_t> levels) {
  projections_.record(commands, rig, levels);
  if (rig.display_pixels.handle == VK_NULL_HANDLE) return;
  for (Film& film : films_) {
    if (!film.pixels) continue;
    const VkDeviceSize size = film.pixels->texels.size() * kPixelBytes;
    std::memcpy(static_cast<std::byte*>(staged_.mapped) + film.staged, film.pixels->texels.data(), size);
    const VkBufferCopy region{film.staged, film.pixels_at, size};
    vkCmdCopyBuffer(commands, staged_.handle, rig.display_pixels.handle, 1, &region);
    film.pixels.reset();
    rig.display_films_new = true;
  }
  if (rig.display_films_new) vk::full_barrier(commands);
}

}  // namespace footlight::render

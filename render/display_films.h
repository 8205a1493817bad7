// The pixels that displays and projectors get while the frame runs: of videos, and those of DMX for projectors.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/gobo_films.h"
#include "render/resources.h"

namespace footlight::render {

class DisplayFilms {
 public:
  // Makes room for the pixels of all displays that show a film (fixtures::shows_film()), and of projections; none
  // without such displays. The rig's tables are those of the frame.
  Status create(vk::Device& device, const MemoryShape& shape, const RigTables& rig);
  // columns x rows pixels of what fixtures::shown_at() is of the rig, from the next record() on: share of light, linear
  // Rec. 709. Ignored if that shows no film.
  void show(std::size_t display, const std::shared_ptr<const fixtures::PaneImage>& pixels);
  // Copies what is new to the pixels of the displays, and has the pass of displays compute the cells above. The
  // commands of the record() before must be finished.
  // levels: universes x 512 bytes; empty: all are 0.
  void record(VkCommandBuffer commands, RigTables& rig, std::span<const std::uint8_t> levels);
  // What pixels are copied to before they go to the tables, of displays and of projections.
  [[nodiscard]] std::uint64_t display_bytes() const { return staged_.size_bytes; }
  [[nodiscard]] std::uint64_t projection_bytes() const { return projections_.bytes(); }
  [[nodiscard]] std::uint64_t bytes() const { return display_bytes() + projection_bytes(); }

 private:
  struct Film {
    std::size_t display = 0;
    int columns = 0;
    int rows = 0;
    VkDeviceSize staged = 0;                            // bytes, in staged_
    VkDeviceSize pixels_at = 0;                         // bytes, in the table of pixels
    std::shared_ptr<const fixtures::PaneImage> pixels;  // new ones; else null
  };
  std::vector<Film> films_;
  GoboFilms projections_;
  std::size_t displays_ = 0;  // of the rig
  vk::Buffer staged_;
};

}  // namespace footlight::render

// The pictures of projectors that change while the frame runs: videos and pixel maps, written into the layers of the
// gobo images that the projectors' beams show.
//
// Memory: 1.5 MB of the host for each picture of 714 x 402 texels, and no more on the GPU than gobos that stand. Time
// of the host for a new picture: docs/numerics.md#projectors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fixtures/displays/map_film.h"
#include "fixtures/projectors/projector.h"
#include "render/resources.h"

namespace footlight::render {

// A part of a square image with all levels of detail, as it is copied to the GPU: sRGB, four bytes a texel. Outside of
// the part the image is black.
struct FilmLevel {
  std::uint32_t level = 0;
  int left = 0;
  int top = 0;
  int columns = 0;
  int rows = 0;
  std::size_t first = 0;  // byte of its first texel
};
struct FilmTexels {
  std::vector<FilmLevel> levels;
  std::vector<std::uint8_t> texels;
};
// A picture over a part of an image of size_px a side: means over the area of each texel, then of four texels each. The
// part is that of an image of kProjectorGoboPx a side, as images that stand have it. color: share of light. Within 0.6
// of a code of 255 of what double has.
[[nodiscard]] FilmTexels film_texels(const fixtures::PaneImage& picture, const glm::vec3& color,
                                     const fixtures::GoboPart& part, int size_px);

class GoboFilms {
 public:
  // Of the projections of a rig; none if nothing reads gobos. The rig's tables are those of the frame.
  Status create(vk::Device& device, const MemoryShape& shape, const RigTables& rig);
  // columns x rows pixels of a projection, as DisplayFilms::show() takes them, from the next record() on.
  void show(std::size_t projection, const std::shared_ptr<const fixtures::PaneImage>& pixels);
  // Copies what is new, also of pixel maps at these levels (universes x 512 bytes; empty: all are 0). The commands of
  // the record() before must be finished.
  void record(VkCommandBuffer commands, const RigTables& rig, std::span<const std::uint8_t> levels);
  // What pictures are copied to before they go to the gobo images.
  [[nodiscard]] std::uint64_t bytes() const { return staged_.size_bytes; }

 private:
  struct Film {
    fixtures::Display display;
    fixtures::GoboPart part;
    std::optional<fixtures::PanelFilm> panel;  // of a projector whose panel shows something else than the picture
    bool has_layer = false;  // a beam shows it
    std::uint32_t layer = 0;
    VkDeviceSize staged = 0;                            // bytes, in staged_
    std::shared_ptr<const fixtures::PaneImage> pixels;  // new ones; else null
    std::optional<fixtures::MapFilm> map;               // of a film that has a layer and a pixel map
  };
  std::vector<Film> films_;  // one each of Rig::projections
  vk::Buffer staged_;
  int size_px_ = 0;
};

}  // namespace footlight::render

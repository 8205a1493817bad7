// The pixels that displays get from outside while the frame runs: of videos.
#pragma once

#include <memory>
#include <vector>

#include "render/resources.h"

namespace footlight::render {

class DisplayFilms {
 public:
  // Makes room for the pixels of all displays that show a film (fixtures::shows_film()); none without such displays.
  Status create(vk::Device& device, const MemoryShape& shape);
  // columns x rows pixels of a display of the rig, from the next record() on: share of light, linear Rec. 709. Ignored
  // if that display shows no film.
  void show(std::size_t display, const std::shared_ptr<const fixtures::PaneImage>& pixels);
  // Copies what is new to the cells of the displays, and has the pass of displays compute the larger ones. The commands
  // of the record() before must be finished.
  void record(VkCommandBuffer commands, RigTables& rig);

 private:
  struct Film {
    std::size_t display = 0;
    int columns = 0;
    int rows = 0;
    VkDeviceSize staged = 0;                            // bytes, in staged_
    VkDeviceSize cells = 0;                             // bytes, in RigTables::display_cells
    std::shared_ptr<const fixtures::PaneImage> pixels;  // new ones; else null
  };
  std::vector<Film> films_;
  vk::Buffer staged_;
};

}  // namespace footlight::render

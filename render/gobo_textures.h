// The images of gobos on the GPU.
#pragma once

#include <cstdint>
#include <vector>

#include "render/resources.h"

namespace footlight::render {

// Gobo images with all levels of detail, in colour, 8 bits sRGB a channel. A rig without gobos gets a single texel,
// since the shaders name the binding even where their specialisation never reads it.
struct GoboTexels {
  int size_px = 1;
  std::uint32_t layers = 1;
  std::uint32_t levels = 0;
  std::vector<std::uint8_t> texels;
  std::vector<VkBufferImageCopy> regions;        // where each level of each layer lies in texels
  std::vector<std::uint32_t> planes;             // of each image 1 where it is grey, else 3
  std::vector<fixtures::Diagnostic> troubles;    // of images that could not be read
};

// Reads files and draws built-in gobos, without a device: on any thread. Images that change are black (gobo_films.h).
[[nodiscard]] GoboTexels read_gobos(const std::vector<fixtures::ImageSource>& images, int size_px);
// kBadInput for more images than the device has layers.
[[nodiscard]] Status check_gobos(const vk::Device& device, std::size_t images);
// One array of all images.
[[nodiscard]] Result<vk::Image> make_gobos(vk::Device& device, const GoboTexels& read);

}  // namespace footlight::render

// The images of gobos on the GPU.
#pragma once

#include <cstdint>
#include <vector>

#include "render/resources.h"

namespace footlight::render {

// Gobo images as one array with all levels of detail, in colour, 8 bits sRGB a channel. A rig without gobos gets a
// single texel, since the shaders name the binding even where their specialisation never reads it.
// planes: of each image 1 where it is grey, else 3.
[[nodiscard]] Result<vk::Image> make_gobos(vk::Device& device, const std::vector<fixtures::ImageSource>& images,
                                           int size_px, fixtures::Diagnostics& diagnostics,
                                           std::vector<std::uint32_t>& planes);

}  // namespace footlight::render

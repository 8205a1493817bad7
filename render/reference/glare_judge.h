// The camera's glare from its definition (render/shaders/shared/glare.h), in double: closed forms and quadrature,
// without Gaussians and without a pyramid.
#pragma once

#include <vector>

#include "render/image.h"

namespace footlight::render {

// g of the definition: scattered light per squared focal length, at a distance of `r` focal lengths.
[[nodiscard]] double glare_density(double r);

// Of the scattered light of a pixel, which leaves it evenly, the share that falls on the pixel `dx`, `dy` pixels away.
// Pixels have a side of `pixel` focal lengths.
[[nodiscard]] double glare_between(int dx, int dy, double pixel);

// The light that a lens scatters which scatters all of it: of each pixel to each other and to itself, 3 values a pixel.
// Light that leaves the picture is lost. Takes time with the square of the number of pixels. Of `light`, values that
// are not above 0 do not count.
[[nodiscard]] std::vector<double> judge_glare(const RadianceImage& light, double pixel);

}  // namespace footlight::render

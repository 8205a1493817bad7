// Pictures of the light of panes, displays and lasers beside those of the judge.
#pragma once

#include <functional>
#include <vector>

#include "tests/render/scenes.h"

namespace footlight::render::testing {

// Of the rig's first camera.
void view_from(Scene& scene, glm::dvec3 from, glm::dvec3 to);
// judged: what the judge computes, else as the product draws it; `change` may set more.
[[nodiscard]] RadianceImage drawn_light(
    vk::Device& device, const Scene& scene, int width, int height, bool judged,
    const std::function<void(FrameSettings&)>& change = [](FrameSettings&) {});
// By the judge, after a step of 0 s.
[[nodiscard]] std::vector<double> judged_light(const Scene& scene, int width, int height);

// Relative L2. The judge's picture has light.
[[nodiscard]] double rel_l2(const RadianceImage& image, const std::vector<double>& judge);
[[nodiscard]] double sum_of(const RadianceImage& image);
// If FOOTLIGHT_PRINT_ERRORS is set.
void print_error(const char* what, double error);

}  // namespace footlight::render::testing

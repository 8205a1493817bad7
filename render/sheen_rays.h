// Rays that a surface with sheen sends for what it mirrors (render/shaders/shared/sheen.h), in double. Pure.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "render/frame_io.h"

namespace footlight::render {

struct SheenRay {
  glm::dvec3 way{0, 0, 1};  // to where the light comes from, unit; the normal is z, and the eye lies towards x
  double share = 0;         // of that light, if each facet mirrored all of it; the mean over all rays counts
  double fresnel = 0;       // Schlick's share at the facet
};

// One ray a facet, of facets as the eye sees them (Heitz 2018, "Sampling the GGX Distribution of Visible Normals"), by
// a Hammersley set. Rays that would go into the surface have a share of 0. alpha: above 0; cosine: to the eye, 0 to 1.
[[nodiscard]] std::vector<SheenRay> sheen_rays(double alpha, double cosine, int count);

// Of the light that comes evenly from all sides, what a surface with sheen reflects to the eye: x of what it reflects
// straight back, plus y; by Schlick, as sheen.h has it. cosine: to the eye, 0 to 1. The mean over `samples` facets that
// the eye sees. alpha: above 0.
[[nodiscard]] glm::dvec2 sheen_shares(double alpha, double cosine, int samples);
// The same by the table of a frame, as shaders read it.
[[nodiscard]] glm::dvec2 table_shares(const std::vector<vec4>& table, double alpha, double cosine);
// FL_PROBE_SHARES rows by the cosine of FL_PROBE_SHARES columns by the roughness (probe_share_place()).
[[nodiscard]] std::vector<vec4> probe_share_table();

}  // namespace footlight::render

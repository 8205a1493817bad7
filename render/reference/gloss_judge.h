// The judge of floors that mirror, in double, from the definition.
//
// A floor is made of facets that mirror. Their slopes on two axes are independent and normally distributed, with the
// roughness as the root of the sum of both variances. What is mirrored is the mean over facets, each weighted by what
// the eye sees of it; facets that mirror downwards do not count. Of the light on the floor the share of Schlick's
// formula is mirrored, for the floor's own normal, and the rest is left to its albedo.
#pragma once

#include <functional>

#include <glm/glm.hpp>

#include "fixtures/model/gloss.h"
#include "render/reference/judge.h"

namespace footlight::render {

// Light from a direction, cd/m^2.
using LightFrom = std::function<glm::dvec3(const glm::dvec3& direction)>;

// The floor that mirrors at a place on a face that looks up; null: the face is matt.
[[nodiscard]] const fixtures::GlossTop* gloss_at(const JudgeScene& scene, const glm::dvec3& point_m);

// Share of the light that is mirrored: gloss.share + (1 - gloss.share) (1 - cosine)^5. cosine: of the ray's angle to
// the normal, 0 to 1.
[[nodiscard]] double gloss_share(const fixtures::Gloss& gloss, double cosine);

// The mean, by `rays` facets of a Hammersley set; a floor without roughness takes one. way: of the ray from the eye,
// unit, downwards. Its error falls about as 1 / rays where the light is smooth.
[[nodiscard]] glm::dvec3 mirrored_mean(const fixtures::Gloss& gloss, const glm::dvec3& way, int rays,
                                       const LightFrom& light);

}  // namespace footlight::render

#include "render/display.h"

#include "fixtures/model/color.h"

namespace footlight::render {

std::string_view word_of(ToneCurve tone) {
  switch (tone) {
    case ToneCurve::kFilmic: return "filmic";
    case ToneCurve::kReinhard: return "reinhard";
    case ToneCurve::kLinear: return "linear";
    case ToneCurve::kAgx: break;
  }
  return "agx";
}

std::optional<ToneCurve> tone_of(std::string_view word) {
  for (const ToneCurve tone : kToneCurves) {
    if (word == word_of(tone)) return tone;
  }
  return std::nullopt;
}

glm::dmat3 white_balance(double white_k) {
  if (white_k == 0) return glm::dmat3(1);
  // Rows of the matrix as they are published; glm has columns.
  const glm::dmat3 bradford =
      glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296));
  const glm::dvec3 from = bradford * fixtures::rgb_to_xyz(fixtures::black_body_rgb(white_k));
  const glm::dvec3 to = bradford * fixtures::rgb_to_xyz(glm::dvec3(1));
  const glm::dmat3 back = glm::inverse(bradford);
  glm::dmat3 balance;
  for (int c = 0; c < 3; ++c) {
    glm::dvec3 primary(0);
    primary[c] = 1;
    balance[c] = fixtures::xyz_to_rgb(back * (to / from * (bradford * fixtures::rgb_to_xyz(primary))));
  }
  return balance;
}

}  // namespace footlight::render

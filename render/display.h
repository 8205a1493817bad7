// What the camera makes of light before a screen shows it: white balance and tone curve.
#pragma once

#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "render/settings.h"

namespace footlight::render {

inline constexpr double kWhiteMinK = 1500;
inline constexpr double kWhiteMaxK = 20'000;

// "agx", "filmic", "reinhard", "linear".
[[nodiscard]] std::string_view word_of(ToneCurve tone);
[[nodiscard]] std::optional<ToneCurve> tone_of(std::string_view word);
inline constexpr ToneCurve kToneCurves[] = {ToneCurve::kAgx, ToneCurve::kFilmic, ToneCurve::kReinhard,
                                            ToneCurve::kLinear};

// Linear Rec. 709 to linear Rec. 709: light of a black body of white_k becomes grey (D65) with its luminance. By the
// Bradford transform (Lam, 1985; ICC.1 Annex E). Negative parts of the result are to be brought inside
// (fixtures/shared/color.h). white_k 0: the unit matrix.
[[nodiscard]] glm::dmat3 white_balance(double white_k);

struct Display {
  ToneCurve tone = ToneCurve::kAgx;
  double white_k = 0;
};

}  // namespace footlight::render

// From a picture of 8-bit RGB to the light of a display's pixels.
#pragma once

#include <array>

#include "drivers/vrsl/picture.h"
#include "fixtures/glass/pane.h"

namespace footlight::tools {

// Light of each code, as a share of white.
using LightCurve256 = std::array<float, 256>;
// gamma 0: as sRGB (IEC 61966-2-1); else the code's share of 255 to this power.
[[nodiscard]] LightCurve256 light_curve(double gamma);

// Each of columns x rows pixels is the mean of the light of the part of the picture that it covers. In float: within
// 1e-5 of the mean in double (tests/tools/footlight/clip_test.cpp). Times: `footlight clip`.
[[nodiscard]] fixtures::PaneImage light_of(const drivers::Picture& picture, const LightCurve256& curve, int columns,
                                           int rows);

}  // namespace footlight::tools

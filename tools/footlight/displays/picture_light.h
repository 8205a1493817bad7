// From a picture of 8-bit RGB to the light of a display's pixels.
#pragma once

#include <array>
#include <memory>

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
// The same. The memory of `light` is used again: new memory takes longer than the light that is written to it.
void set_light(const drivers::Picture& picture, const LightCurve256& curve, int columns, int rows,
               fixtures::PaneImage& light);

// Images with the memory of those that nobody holds any more. Any thread may let go of one, also after the end of this.
class LightImages {
 public:
  [[nodiscard]] std::shared_ptr<const fixtures::PaneImage> light_of(const drivers::Picture& picture,
                                                                    const LightCurve256& curve, int columns, int rows);

 private:
  struct Spare;
  std::shared_ptr<Spare> spare_;
};

}  // namespace footlight::tools

// Pictures of how a frame was computed, and of the light on surfaces: the words of --show.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "render/image.h"
#include "render/settings.h"
#include "sim/core/result.h"

namespace footlight::tools {

enum class ShownView {
  kPicture,
  kClasses,  // red: beams computed pixel by pixel; green: taken together as smooth; blue: with a rim or cuts
  kHits,     // how many beams each pixel shows
  kSteps,    // cells of the glass of panes along each pixel's ray
  kLux,      // illuminance of surfaces
  kError     // difference from the same frame computed pixel by pixel with eight nodes
};

// "picture", "classes", "hits", "steps", "lux" or "error"; kBadInput for others.
[[nodiscard]] Result<ShownView> shown_view_of(std::string_view word);

// "X,Y", pixels from the top left: --probe.
[[nodiscard]] Result<std::pair<int, int>> parse_probe(const std::string& probe);

// What the frame writes for it. kBadInput for kSteps of a rig without panes.
[[nodiscard]] Result<render::FrameView> frame_view_of(ShownView shown, bool has_panes);

// One number a pixel, in the rows of the image that it was made of.
struct Values {
  int width = 0;
  int height = 0;
  std::vector<float> values;
};

// Beams of all classes together; of FrameView::kClasses.
[[nodiscard]] Values hits_of(const render::RadianceImage& classes);
// Photometric: Rec. 709 weights of the channels; of FrameView::kLux.
[[nodiscard]] Values lux_of(const render::RadianceImage& lux);
// |frame - reference| / (reference + a hundredth of the reference's mean), the largest of the channels. The images have
// the same size.
[[nodiscard]] Values error_of(const render::RadianceImage& frame, const render::RadianceImage& reference);

// The shares of the classes as a colour, as bright as the logarithm of the number of beams.
[[nodiscard]] render::ScreenImage class_picture(const render::RadianceImage& classes);

// False colours from blue over green and yellow to red, by the logarithm between low and high, 0 < low < high. Values
// below low, and what is not finite, are black and white.
[[nodiscard]] render::ScreenImage heat_picture(const Values& values, double low, double high);

// Shares of all hits that fell to each class, 0 to 1; all 0 where nothing is hit.
struct ClassShares {
  double hits_per_px = 0;
  double pixel = 0;
  double smooth = 0;
  double record = 0;
};
[[nodiscard]] ClassShares class_shares(const render::RadianceImage& classes);

}  // namespace footlight::tools

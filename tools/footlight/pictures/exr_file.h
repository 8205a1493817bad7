// Pictures as OpenEXR files: the light itself, before exposure and tone map.
#pragma once

#include <string>

#include "fixtures/files/files.h"
#include "render/image.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::tools {

// What the header of the file states beside the pixels.
struct ExrHeader {
  double exposure_ev = 0;     // EV at ISO 100 that a PNG of the same picture has
  DurationNs time_ns = 0;     // of the picture in its log
  DurationNs shutter_ns = 0;  // the pixels are the mean light over so long before that time
  DurationNs frame_ns = 0;    // from picture to picture of a sequence; 0: it is a single one
  std::string settings;       // how it was computed (render/quality.h, json_of()); empty: not stated
};

[[nodiscard]] inline bool is_exr(const std::string& path) { return path.size() > 4 && path.ends_with(".exr"); }

// Channels R, G and B of 32-bit float, each value as it is in `image`, compressed without loss (ZIP). Attributes:
//   chromaticities    Rec. 709, white D65
//   whiteLuminance    1, since (1, 1, 1) is white of 1 cd/m^2
//   expTime           shutter_ns in s
//   framesPerSecond   of a sequence
//   footlight/units, footlight/exposureEv, footlight/timeS, footlight/settings
// kUnsupported where this build has no OpenEXR.
[[nodiscard]] Result<fixtures::Bytes> exr_of(const render::RadianceImage& image, const ExrHeader& given);

// Fails where this build cannot write OpenEXR, for a message before the work and not after it.
[[nodiscard]] Status check_exr(const std::string& path);
// As write_png() writes PNG.
Status write_exr(const std::string& path, const render::RadianceImage& image, const ExrHeader& header);

}  // namespace footlight::tools

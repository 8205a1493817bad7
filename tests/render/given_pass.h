// A pass that puts a picture in the place of what a frame would draw.
#pragma once

#include "render/image.h"
#include "render/pass.h"

namespace footlight::render::testing {

// First in a list of passes. Its picture is that of the last give(), which has the frame's size.
extern const PassEntry kGivenPass;
void give(const RadianceImage& light);

}  // namespace footlight::render::testing

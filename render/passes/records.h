// Beams that are smooth over a supertile but for their rim or for what cuts them, as polynomials.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kRecordsPass;
}  // namespace footlight::render

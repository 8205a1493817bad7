// Raw levels to fixture states: decode, motors, shutters, phases. Recorded once a DMX step, not once a frame.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kStepPass;
}  // namespace footlight::render

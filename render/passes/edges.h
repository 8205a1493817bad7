// Smooths the edges of solid things.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kEdgesPass;
}  // namespace footlight::render

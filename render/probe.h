// Sheen and reflection probes (render/shaders/shared/sheen.h, probe.h) for C++: footlight::render::f32 in float as on
// the GPU, f64 in double.
#pragma once

#include "render/frame_io.h"
#include "sim/shared/shared.h"

namespace footlight::render::f32 {
using namespace ::footlight::f32;
#include "render/shaders/shared/sheen.h"
// After sheen.h.
#include "render/shaders/shared/probe.h"
}  // namespace footlight::render::f32

namespace footlight::render::f64 {
using namespace ::footlight::f64;
#include "render/shaders/shared/sheen.h"
// After sheen.h.
#include "render/shaders/shared/probe.h"
}  // namespace footlight::render::f64

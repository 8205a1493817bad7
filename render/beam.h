// The light formulas of render/shaders/shared/beam.h, the tone curves of agx.h and tone.h and the weights of glare.h
// for C++: footlight::render::f32 in float as on the GPU, f64 in double.
#pragma once

#include "render/frame_io.h"
#include "sim/shared/shared.h"

// gauss.h has to come before beam.h, tile_node.h after it.
// clang-format off
namespace footlight::render::f32 {
using namespace ::footlight::f32;
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/mirror.h"
#include "render/shaders/shared/laser.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/shaft.h"
#include "render/shaders/shared/display.h"
#include "render/shaders/shared/gobo_chord.h"
#include "render/shaders/shared/tile_node.h"
#include "fixtures/shared/color.h"
#include "render/shaders/shared/agx.h"
#include "render/shaders/shared/tone.h"
#include "render/shaders/shared/glare.h"
}  // namespace footlight::render::f32

namespace footlight::render::f64 {
using namespace ::footlight::f64;
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/mirror.h"
#include "render/shaders/shared/laser.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/shaft.h"
#include "render/shaders/shared/display.h"
#include "render/shaders/shared/gobo_chord.h"
#include "render/shaders/shared/tile_node.h"
#include "fixtures/shared/color.h"
#include "render/shaders/shared/agx.h"
#include "render/shaders/shared/tone.h"
#include "render/shaders/shared/glare.h"
}  // namespace footlight::render::f64
// clang-format on

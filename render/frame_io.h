// render/shaders/shared/frame_io.h for C++.
#pragma once

#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

#include "fixtures/compile/tables.h"

namespace footlight::render {
using uint = std::uint32_t;
using vec4 = glm::vec4;
#include "render/shaders/shared/frame_io.h"

static_assert(sizeof(FrameParams) == 128);
static_assert(offsetof(FrameParams, width) == 64);
static_assert(sizeof(BeamRow) == 160);
static_assert(sizeof(BladesRow) == 64);
static_assert(sizeof(CountsRow) == 96);
static_assert(sizeof(TileDepthRow) == 32);
static_assert(sizeof(CoarseRow) == 208);
static_assert(sizeof(BoxRow) == 48);
}  // namespace footlight::render

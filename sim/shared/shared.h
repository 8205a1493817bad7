// The shared time behaviour for C++: footlight::f32 in float, as on the GPU; footlight::f64 in double, the reference.
// See sim/shared/real.h for the rules of the subset.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include <glm/glm.hpp>

#include "sim/shared/real.h"

#define FL_SHARED_USING       \
  using uint = std::uint32_t; \
  using Turns = glm::uvec2;   \
  using glm::abs;             \
  using glm::ceil;            \
  using glm::clamp;           \
  using glm::cross;           \
  using glm::dot;             \
  using glm::floor;           \
  using glm::inversesqrt;     \
  using glm::max;             \
  using glm::min;             \
  using glm::mix;             \
  using glm::normalize;       \
  using glm::sqrt;            \
  using std::acos;            \
  using std::atan;            \
  using std::cos;             \
  using std::exp;             \
  using std::exp2;            \
  using std::log;             \
  using std::log2;            \
  using std::pow;             \
  using std::sin;             \
  using std::tan;

namespace footlight {
// GLSL's built-in function of this name.
inline void umulExtended(std::uint32_t a, std::uint32_t b, std::uint32_t& high, std::uint32_t& low) {
  const std::uint64_t product = std::uint64_t{a} * b;
  high = static_cast<std::uint32_t>(product >> 32);
  low = static_cast<std::uint32_t>(product);
}
}  // namespace footlight

namespace footlight::f32 {
using Real = float;
using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
FL_SHARED_USING
// Each header uses those above it.
// clang-format off
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
#include "sim/shared/filter.h"
#include "sim/shared/haze.h"
#include "sim/shared/dimmer.h"
#include "sim/shared/lamp.h"
#include "sim/shared/shutter.h"
// clang-format on
}  // namespace footlight::f32

namespace footlight::f64 {
using Real = double;
using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
FL_SHARED_USING
// Each header uses those above it.
// clang-format off
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
#include "sim/shared/filter.h"
#include "sim/shared/haze.h"
#include "sim/shared/dimmer.h"
#include "sim/shared/lamp.h"
#include "sim/shared/shutter.h"
// clang-format on
}  // namespace footlight::f64

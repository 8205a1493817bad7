// The judge's mirror balls: what each mirror makes of each beam of a lamp, in double and from the definition
// (docs/numerics.md#mirrors). It shares no formula with render/shaders/shared/mirror.h.
#pragma once

#include <cstddef>
#include <span>

#include "fixtures/model/rig.h"
#include "fixtures/simulate/walker.h"
#include "render/reference/judge.h"

namespace footlight::render {

// Adds the beams of all mirrors that the beams of the scene light. `heads`: of these beams, in their order; nothing
// hides the way from a lamp to a mirror.
void add_mirrored(const fixtures::Rig& rig, fixtures::f64::Walker& walker, std::span<const std::size_t> heads,
                  JudgeScene& scene);

}  // namespace footlight::render

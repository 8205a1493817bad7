// What a pattern (sim/pattern.h) does with a rig: each fixture is a voice, lit in open white at its place, as faders
// start, and dark by its dimmer. A fixture without a dimmer darkens by its colours. All other channels stand still.
#pragma once

#include <span>

#include "fixtures/model/rig.h"
#include "sim/pattern.h"

namespace footlight::tools {

// universes: ascending; those that the rig does not use get zeros.
[[nodiscard]] PatternPlan rig_pattern(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                                      std::span<const Universe> universes);

}  // namespace footlight::tools

// What surfaces with sheen mirror: maps of the stage's light as probes see it.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kProbesPass;
}  // namespace footlight::render

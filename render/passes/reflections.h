// What reflection probes show, mirrored by the pixels of surfaces with sheen.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kReflectionsPass;
}  // namespace footlight::render

// Which stage box each pixel shows.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kBoxesPass;
}  // namespace footlight::render

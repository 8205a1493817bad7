// The table of haze that is not even: what each ray of a grid over the picture passes through.
#pragma once

#include "render/pass.h"

namespace footlight::render {
extern const PassEntry kHazePass;
}

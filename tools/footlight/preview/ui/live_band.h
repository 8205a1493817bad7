// What lies over everything else: the frame of armed outputs, and tags that say what the stage does not show. Tags
// stand in the middle of the stage's upper edge, or beside it where a panel has its title there. Dear ImGui only.
#pragma once

#include "sim/core/clock.h"
#include "tools/footlight/preview/ui/inputs_view.h"
#include "tools/footlight/preview/ui/outputs_view.h"

namespace footlight::tools {

// After all panels of the picture: their titles are not covered. stage_width: of the part of the window beside the side
// panel. Both return where the lowest of their tags ends, in units of the user interface, or y if there is none.
float draw_live_band(const OutputsView& outputs, float stage_width, float scale);
float draw_input_tags(const InputsView& inputs, float stage_width, float y);
// That the window is locked, with the key that unlocks it: a tag, and a frame inside that of armed outputs. Returns as
// the others.
float draw_lock(float stage_width, float scale, float y);
// At the top left: that what the fixtures get is recorded, and for how long.
void draw_recording_mark(DurationNs elapsed_ns, float scale);

}  // namespace footlight::tools

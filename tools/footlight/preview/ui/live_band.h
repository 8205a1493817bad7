// The frame around the window while outputs to real lamps are armed or blacked out. Dear ImGui only.
#pragma once

#include "tools/footlight/preview/ui/outputs_view.h"

namespace footlight::tools {

// Over everything else, in every state of the side panel. Takes no clicks. Without an armed output there is no frame,
// and no text but that of a blackout. stage_width: of the picture, in units of the user interface.
void draw_live_band(const OutputsView& outputs, float stage_width, float scale);

}  // namespace footlight::tools

// The frame around the window while outputs to real lamps are armed or blacked out. Dear ImGui only.
#pragma once

#include "sim/core/clock.h"
#include "tools/footlight/preview/ui/inputs_view.h"
#include "tools/footlight/preview/ui/outputs_view.h"

namespace footlight::tools {

// Over everything else, in every state of the side panel. Takes no clicks. Without an armed output there is no frame,
// and no text but that of a blackout. stage_width: of the picture, in units of the user interface.
// Returns where its text ends, from the top of the window; 0 without one.
float draw_live_band(const OutputsView& outputs, float stage_width, float scale);

// "MADE UP: mock:chase" over everything else, while there is a made-up input. Takes no clicks. y: of its upper edge.
void draw_made_up_tag(const InputsView& made_up, float stage_width, float y);

// A red dot with the time of a recording, at the top left over everything else.
void draw_recording_mark(DurationNs elapsed_ns, float scale);

}  // namespace footlight::tools

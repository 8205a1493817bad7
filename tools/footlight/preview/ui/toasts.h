// The newest messages as boxes at the bottom left of the stage. Dear ImGui only.
#pragma once

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/messages.h"

namespace footlight::tools {

// Over everything else; takes no clicks. stage: its size in units of the user interface.
void draw_toasts(const MessageLog& log, TimeNs now_ns, const ImVec2& stage, float scale);

}  // namespace footlight::tools

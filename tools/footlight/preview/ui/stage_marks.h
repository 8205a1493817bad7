// What is drawn over the picture: corners around the selected fixtures and their names, and a line of news.
#pragma once

#include "tools/footlight/preview/ui/stage_box.h"
#include "tools/footlight/preview/ui/stage_pick.h"
#include "tools/footlight/preview/ui/ui_state.h"

namespace footlight::tools {

// Under the panels. At most kMarksMax fixtures.
inline constexpr std::size_t kMarksMax = 2000;
void draw_marks(const fixtures::Rig& rig, const StagePick& pick, const StagePlace& place, const Selection& selection,
                float scale);

// The rectangle of a drag that selects.
void draw_box(const StageBox& box, float scale);
// How to fly, at the bottom of the stage, while it is on.
void draw_fly(const FlyCamera& fly, const StagePlace& place, float scale);

}  // namespace footlight::tools

// What is drawn over the picture: corners around the selected fixtures and their names, and a line of news.
#pragma once


#include "tools/footlight/preview/ui/stage_pick.h"
#include "tools/footlight/preview/ui/ui_state.h"

namespace footlight::tools {

// Under the panels. At most kMarksMax fixtures.
inline constexpr std::size_t kMarksMax = 2000;
void draw_marks(const fixtures::Rig& rig, const StagePick& pick, const StagePlace& place, const Selection& selection,
                float scale);

}  // namespace footlight::tools

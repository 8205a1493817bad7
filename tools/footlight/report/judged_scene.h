// The judge's scene of a scene of the report.
#pragma once

#include "render/reference/judge.h"
#include "render/settings.h"
#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

// After a step of 0 s, with the images of gobos as frames with these settings have them, and without floors that
// mirror. on_cpu: frames are drawn by a CPU, whose images of gobos are smaller.
[[nodiscard]] render::JudgeScene judge_of(const Scene& scene, const render::FrameSettings& settings, bool on_cpu);

}  // namespace footlight::tools

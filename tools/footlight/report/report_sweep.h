// footlight report --pictures --sweep: cost of every method against one property of the generated scene.
#pragma once

#include "tools/footlight/report/report_parts.h"
#include "tools/footlight/report/sweep.h"

namespace footlight::tools {

// Prints the rows of every scene, and writes all of them to one CSV file and a plot of time against the value.
Status report_sweep(render::vk::Device& device, const Sweep& sweep, const SweepScene& scene,
                    PictureReportOptions pictures, const ReportOptions& options);

}  // namespace footlight::tools

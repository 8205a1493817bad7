// Replaces report_pictures.cpp in builds without the renderer.
#include "tools/footlight/report/report_parts.h"

namespace footlight::tools {

ReportHalf add_report_pictures(Arguments&) { return {}; }

}  // namespace footlight::tools

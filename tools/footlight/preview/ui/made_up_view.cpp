#include "tools/footlight/preview/ui/made_up_view.h"

#include "sim/core/counted.h"

namespace footlight::tools {

std::string made_up_words(const MadeUpView& view) {
  if (view.inputs.empty()) return "";
  return "MADE UP: " + (view.inputs.size() == 1 ? view.inputs.front() : counted(view.inputs.size(), "input"));
}

}  // namespace footlight::tools

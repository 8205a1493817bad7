#include "tools/footlight/preview/ui/inputs_view.h"

#include "sim/core/counted.h"

namespace footlight::tools {

std::string made_up_words(const InputsView& view) {
  if (view.dark_by_hand) return "BLACKOUT by hand";
  if (view.made_up.empty()) return "";
  return "MADE UP: " + (view.made_up.size() == 1 ? view.made_up.front() : counted(view.made_up.size(), "input"));
}

}  // namespace footlight::tools

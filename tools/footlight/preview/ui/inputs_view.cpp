#include "tools/footlight/preview/ui/inputs_view.h"

#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

std::string made_up_words(const InputsView& view) {
  if (view.dark_by_hand) return tr("BLACKOUT by hand");
  if (view.made_up.empty()) return "";
  const std::size_t count = view.made_up.size();
  return count == 1 ? trf("MADE UP: {}", view.made_up.front())
                    : trf_n("MADE UP: {} input", "MADE UP: {} inputs", count, count);
}

}  // namespace footlight::tools

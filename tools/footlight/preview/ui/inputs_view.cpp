#include "tools/footlight/preview/ui/inputs_view.h"

#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

bool InputsView::drop_requests() {
  const bool any = add || remove || move || release_hand || tap || learn;
  add.reset();
  remove.reset();
  move.reset();
  learn.reset();
  release_hand = tap = false;
  return any;
}

std::string made_up_words(const InputsView& view) {
  if (view.made_up.empty()) return "";
  const std::size_t count = view.made_up.size();
  return count == 1 ? trf("MADE UP: {}", view.made_up.front())
                    : trf_n("MADE UP: {} input", "MADE UP: {} inputs", count, count);
}

std::string hand_blackout_words(const InputsView& view) { return view.dark_by_hand ? tr("BLACKOUT by hand") : ""; }

std::string hand_blackout_end() {
  return tr("`footlight blackout off`, or `end it` in F6, ends the blackout by hand");
}

}  // namespace footlight::tools

// What the user opened instead of what a window shows: the options of the window after it. Knows no window.
#pragma once

#include <string>

#include "tools/footlight/preview/preview.h"

namespace footlight::tools {

struct NextWindow {
  std::string rig;       // empty: the same one
  std::string log;       // empty: none; with a rig both are opened
  bool recover = false;  // the same rig and log, with the edits that a session lost
  std::string saved_as;  // without a rig: where the same one was saved since; empty: nowhere else
};

// An endpoint that sets levels by hand. A text that is no endpoint is none, and is refused where it is opened.
[[nodiscard]] bool sets_levels_by_hand(const std::string& endpoint);

// `options`: of the window before, as its user left it.
[[nodiscard]] PreviewOptions options_for(PreviewOptions options, const NextWindow& next);

}  // namespace footlight::tools

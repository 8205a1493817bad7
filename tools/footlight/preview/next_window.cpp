#include "tools/footlight/preview/next_window.h"

#include <vector>

#include "tools/footlight/bridge/open_ports.h"

namespace footlight::tools {

bool sets_levels_by_hand(const std::string& endpoint) { return is_control(endpoint).value_or(false); }

PreviewOptions options_for(PreviewOptions options, const NextWindow& next) {
  if (next.recover) {
    options.recover = true;
    return options;
  }
  if (!next.rig.empty()) {
    options.files.rig = next.rig;
    options.files.demo = false;
    options.files.log.clear();
    options.camera.clear();
    options.camera_words.focus_m.reset();  // a distance in the rig from before
    options.select.clear();
  } else if (!next.saved_as.empty()) {
    options.files.rig = next.saved_as;
    options.files.demo = false;
  }
  if (!next.log.empty()) {
    options.files.log = next.log;
    std::erase_if(options.ins, [](const std::string& text) { return !sets_levels_by_hand(text); });
  }
  return options;
}

}  // namespace footlight::tools

// Settings of a frame that begins once other threads have compiled what its pictures need. The frame before draws on
// until then.
#pragma once

#include <functional>
#include <optional>

#include "render/settings.h"

namespace footlight::tools {

class ComingSettings {
 public:
  // Asked once between two pictures. True: a frame of these settings can begin. begins() is called for settings that
  // were not wanted the time before; finished(), after it, tells whether all that was begun is compiled.
  [[nodiscard]] bool come(const render::FrameSettings& wanted,
                          const std::function<void(const render::FrameSettings&)>& begins,
                          const std::function<bool()>& finished) {
    if (wanted_ != wanted) {
      wanted_ = wanted;
      begins(wanted);
    }
    if (!finished()) return false;
    wanted_.reset();
    return true;
  }
  // The frame before is wanted again.
  void leave() { wanted_.reset(); }
  [[nodiscard]] bool waits() const { return wanted_.has_value(); }

 private:
  std::optional<render::FrameSettings> wanted_;
};

}  // namespace footlight::tools

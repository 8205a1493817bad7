// Questions about outputs to real lamps: before they are armed, and before a live one is removed. Dear ImGui only.
#pragma once

#include <optional>

#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

class ArmQuestion {
 public:
  static constexpr OutputId kAll = -1;  // outputs that are off
  // At the next draw().
  void ask(OutputId which);
  void drop() { asks_.reset(); }
  // Once a picture. A yes adds to OutputsView::arm.
  void draw(const UiInput& input);

 private:
  void draw_asked(const OutputsView& outputs) const;

  std::optional<OutputId> asks_;  // which output the question is about, or kAll
  bool opens_ = false;            // the question opens with this picture
  bool clear_ = false;            // its tick
};

class RemovalQuestion {
 public:
  // At the next draw().
  void ask(OutputId which) {
    removes_ = which;
    opens_ = true;
  }
  void drop() { removes_.reset(); }
  // Once a picture. A yes adds to OutputsView::remove.
  void draw(OutputsView& outputs);

 private:
  std::optional<OutputId> removes_;  // nothing: there is no question
  bool opens_ = false;
};

}  // namespace footlight::tools

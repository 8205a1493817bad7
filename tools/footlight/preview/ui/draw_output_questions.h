// Questions about outputs to real lamps: before they are armed, and before a live one is removed. Dear ImGui only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

class ArmQuestion {
 public:
  static constexpr std::size_t kAll = SIZE_MAX;  // outputs that are off
  // About the output of a row. At the next draw().
  void ask(std::size_t which);
  void drop() { asks_.reset(); }
  // Once a picture. A yes adds to OutputsView::arm.
  void draw(const UiInput& input);

 private:
  void draw_asked(const OutputsView& outputs) const;

  std::optional<std::size_t> asks_;  // which output the question is about, or kAll
  std::string asked_;                // its endpoint
  bool opens_ = false;               // the question opens with this picture
  bool clear_ = false;               // its tick
};

class RemovalQuestion {
 public:
  // At the next draw().
  void ask(const std::string& endpoint) {
    removes_ = endpoint;
    opens_ = true;
  }
  void drop() { removes_.clear(); }
  // Once a picture. A yes adds to OutputsView::remove.
  void draw(OutputsView& outputs);

 private:
  std::string removes_;  // empty: there is no question
  bool opens_ = false;
};

}  // namespace footlight::tools

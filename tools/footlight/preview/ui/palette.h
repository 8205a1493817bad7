// A field that searches every action of keys and menus and runs one. Dear ImGui only.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "tools/footlight/preview/ui/actions.h"

namespace footlight::tools {

class Palette {
 public:
  // At the next draw(), with an empty field.
  void open() { opens_ = true; }
  // From open() on: keys then belong to its field, also before that has the keyboard.
  [[nodiscard]] bool is_open() const { return opens_ || shown_; }
  // Once a picture. Returns what the user chose: Enter runs the marked row, a click its own; up and down mark another.
  // Esc, or a click beside it, closes it.
  [[nodiscard]] std::optional<UiCall> draw(const UiDesk& desk, bool has_log, const OutputsView* outputs, float scale);

 private:
  void search(const UiDesk& desk, bool has_log, const OutputsView* outputs);
  void mark_next(int step);
  [[nodiscard]] std::optional<UiCall> draw_rows(bool entered, bool scrolls, float scale);

  bool opens_ = false;
  bool shown_ = false;  // in the last draw()
  std::array<char, 128> text_{};
  std::vector<UiActionItem> rows_;  // that have all words of the text
  std::size_t marked_ = 0;          // of rows_
};

}  // namespace footlight::tools

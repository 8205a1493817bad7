// Popups that edit the patch, names, numbers and modes of fixtures, and copy and delete them. Dear ImGui only.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::tools {

class RigEditor {
 public:
  using Field = EditField;

  // Opens the popup of a field at the mouse, at the next draw(). which: the fixtures, in the order in which addresses,
  // names and numbers count up; not empty.
  void open(const UiDesk& desk, Field field, std::vector<int> which);
  // The entries of a context menu, between the begin and end of a popup. Opens popups by draw().
  void draw_menu(UiDesk& desk, const std::vector<int>& which);
  // In the same window in every frame.
  void draw(UiDesk& desk, float scale);

 private:
  void draw_fields(UiDesk& desk, float scale);
  void apply(UiDesk& desk);
  void tell(const Status& edited);

  Field field_ = Field::kAddress;
  std::vector<int> which_;
  std::uint64_t shown_count_ = 0;  // UiDesk::shown_count() whose indices which_ has
  bool opens_ = false;
  bool focuses_ = false;
  std::array<char, 256> text_{};
  int first_ = 1;  // number in names
  int count_ = 1;  // of copies
  std::array<double, 3> offset_m_{0.5, 0, 0};
  bool free_only_ = false;
  std::string error_;
};

// What a user can do with the selection of a rig that can be edited, also from the keyboard. A message for the line of
// news; empty: nothing happened.
[[nodiscard]] std::string delete_selected(UiDesk& desk);
[[nodiscard]] std::string unpatch_selected(UiDesk& desk);

}  // namespace footlight::tools

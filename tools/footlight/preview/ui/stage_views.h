// Several views of one stage: where they are in the window, and which of them is drawn next (decision 0155). Knows no
// window.
#pragma once

namespace footlight::tools {

// Pixels of a window, from its top left.
struct PixelRect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool operator==(const PixelRect&) const = default;
};

inline constexpr int kViewsMax = 4;

// 1, 2 or 4.
[[nodiscard]] constexpr bool is_view_count(int views) { return views == 1 || views == 2 || views == kViewsMax; }
// The next one, and 1 after the last.
[[nodiscard]] constexpr int next_view_count(int views) { return views >= kViewsMax ? 1 : 2 * views; }

// Where a view is in `whole`: two are side by side, or above each other where it is higher than wide; four are two by
// two. All have the same size, at least 1 x 1, with a gap of kViewGapPx between them.
inline constexpr int kViewGapPx = 2;
[[nodiscard]] PixelRect view_place(const PixelRect& whole, int views, int view);
// The view at this pixel; -1: none.
[[nodiscard]] int view_at(const PixelRect& whole, int views, int x, int y);

// The views take turns. Of two views the active one has two pictures of three, of four every second one; the others
// follow each other between.
class ViewTurns {
 public:
  // The view of the next picture. active: in [0, views).
  [[nodiscard]] int next(int views, int active);

 private:
  int active_run_ = 0;  // pictures of the active view since one of another
  int other_ = 0;       // that was drawn last
};

}  // namespace footlight::tools

#include "tools/footlight/preview/ui/stage_views.h"

#include <algorithm>

namespace footlight::tools {

PixelRect view_place(const PixelRect& whole, int views, int view) {
  if (views <= 1) return whole;
  const bool beside = views == kViewsMax || whole.width >= whole.height;
  const bool below = views == kViewsMax || !beside;
  const int width = beside ? std::max((whole.width - kViewGapPx) / 2, 1) : whole.width;
  const int height = below ? std::max((whole.height - kViewGapPx) / 2, 1) : whole.height;
  const int column = beside ? view % 2 : 0;
  const int row = views == kViewsMax ? view / 2 : below ? view : 0;
  return {whole.x + column * (width + kViewGapPx), whole.y + row * (height + kViewGapPx), width, height};
}

int view_at(const PixelRect& whole, int views, int x, int y) {
  for (int view = 0; view < views; ++view) {
    const PixelRect place = view_place(whole, views, view);
    if (x >= place.x && y >= place.y && x < place.x + place.width && y < place.y + place.height) return view;
  }
  return -1;
}

int ViewTurns::next(int views, int active) {
  const int run = views == 2 ? 2 : 1;
  if (views <= 1 || active_run_ < run) {
    ++active_run_;
    return active;
  }
  active_run_ = 0;
  do {
    other_ = (other_ + 1) % views;
  } while (other_ == active);
  return other_;
}

}  // namespace footlight::tools

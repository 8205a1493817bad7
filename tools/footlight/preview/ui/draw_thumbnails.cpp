#include "tools/footlight/preview/ui/draw_thumbnails.h"

#include <algorithm>
#include <cmath>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr float kAspect = static_cast<float>(Thumbnails::kWidth) / static_cast<float>(Thumbnails::kHeight);
constexpr float kTipUnits = 288;  // width in a tooltip

// A picture stands for times this near to it.
DurationNs reach_of(DurationNs duration_ns) { return duration_ns / static_cast<DurationNs>(Thumbnails::kCountMax); }

}  // namespace

void draw_thumbnail(ImDrawList& draw, const Thumbnails::Picture& picture, ImVec2 low, ImVec2 high, bool whole) {
  const int columns = whole ? Thumbnails::kWidth : Thumbnails::kWidth / 2;
  const int rows = whole ? Thumbnails::kHeight : Thumbnails::kHeight / 2;
  const std::vector<std::uint32_t>& colours = whole ? picture.pixels : picture.half;
  draw.PrimReserve((columns - 1) * (rows - 1) * 6, columns * rows);
  const unsigned first = draw._VtxCurrentIdx;
  const ImVec2 white = ImGui::GetFontTexUvWhitePixel();
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const ImVec2 at{low.x + (high.x - low.x) * static_cast<float>(x) / static_cast<float>(columns - 1),
                      low.y + (high.y - low.y) * static_cast<float>(y) / static_cast<float>(rows - 1)};
      draw.PrimWriteVtx(at, white, colours[static_cast<std::size_t>(y * columns + x)]);
    }
  }
  for (int y = 0; y + 1 < rows; ++y) {
    for (int x = 0; x + 1 < columns; ++x) {
      const unsigned corner = first + static_cast<unsigned>(y * columns + x);
      const unsigned below = corner + static_cast<unsigned>(columns);
      for (const unsigned index : {corner, corner + 1, below + 1, corner, below + 1, below}) {
        draw.PrimWriteIdx(static_cast<ImDrawIdx>(index));
      }
    }
  }
}

void draw_thumbnails(ImDrawList& draw, const Thumbnails& thumbnails, DurationNs duration_ns, ImVec2 low, ImVec2 size) {
  const float width = size.y * kAspect;
  const int places = static_cast<int>(size.x / (width + 2));
  if (places < 1 || duration_ns <= 0) return;
  const float each = size.x / static_cast<float>(places);
  const double place_ns = static_cast<double>(duration_ns) / places;
  for (int place = 0; place < places; ++place) {
    const auto middle_ns = static_cast<TimeNs>((place + 0.5) * place_ns);
    const auto reach_ns = std::max(static_cast<DurationNs>(place_ns / 2), reach_of(duration_ns));
    const Thumbnails::Picture* picture = thumbnails.nearest(middle_ns, reach_ns);
    if (picture == nullptr) continue;
    const float left = low.x + (static_cast<float>(place) + 0.5f) * each - width / 2;
    draw_thumbnail(draw, *picture, {left, low.y}, {left + width, low.y + size.y}, false);
  }
}

void draw_thumbnail_tip(const Thumbnails& thumbnails, TimeNs at_ns, DurationNs duration_ns, float scale) {
  const Thumbnails::Picture* picture = thumbnails.nearest(at_ns, reach_of(duration_ns));
  if (picture == nullptr) return;
  const ImVec2 size{kTipUnits * scale, kTipUnits * scale / kAspect};
  const ImVec2 low = ImGui::GetCursorScreenPos();
  ImGui::Dummy(size);
  draw_thumbnail(*ImGui::GetWindowDrawList(), *picture, low, {low.x + size.x, low.y + size.y}, true);
  ui_text(kUiDim, trf("picture of {}", time_text(picture->at_ns)));
}

}  // namespace footlight::tools

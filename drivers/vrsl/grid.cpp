#include "drivers/vrsl/grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "drivers/vrsl/grid_cells.h"
#include "drivers/vrsl/grid_check.h"
#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr double kCellMinPx = 2;
constexpr double kLimitedBlack = 16;
constexpr double kLimitedSpan = 219;

// IEC 61966-2-1, 0 to 1.
double linear_of_srgb(double coded) {
  return coded <= 0.04045 ? coded / 12.92 : std::pow((coded + 0.055) / 1.055, 2.4);
}
double srgb_of_linear(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

std::uint8_t rounded(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

// The first pixel whose middle is at or past each edge, so that each pixel belongs to the cell that holds its middle.
std::vector<int> edges(double first, double pitch, int cells, int size) {
  std::vector<int> at;
  for (int i = 0; i <= cells; ++i) {
    at.push_back(std::clamp(static_cast<int>(std::ceil(first + i * pitch - 0.5)), 0, size));
  }
  return at;
}

}  // namespace

std::string_view name_of(GridLayout layout) {
  switch (layout) {
    case GridLayout::kHorizontalBottom: return "horizontal-bottom";
    case GridLayout::kHorizontalTop: return "horizontal-top";
    case GridLayout::kVerticalLeft: return "vertical-left";
    case GridLayout::kVerticalRight: return "vertical-right";
  }
  return "";
}
std::string_view name_of(GridPlanes planes) { return planes == GridPlanes::kLuma ? "luma" : "rgb"; }
std::string_view name_of(GridRange range) { return range == GridRange::kFull ? "full" : "limited"; }
std::string_view name_of(GridTransfer transfer) {
  switch (transfer) {
    case GridTransfer::kLinear: return "linear";
    case GridTransfer::kFromSrgb: return "from-srgb";
    case GridTransfer::kToSrgb: return "to-srgb";
  }
  return "";
}

GridPlace default_place(GridLayout layout, int width, int height) {
  const int across = grid_cells_across(layout);
  const int down = grid_cells_down(layout);
  if (width * down == height * across) {
    const double cell = static_cast<double>(width) / across;
    return {0, 0, cell, cell};
  }
  const double cell = static_cast<double>(width) / kGridRows;
  GridPlace place{0, 0, cell, cell};
  if (layout != GridLayout::kHorizontalTop) place.top = height - down * cell;
  if (layout == GridLayout::kVerticalRight) place.left = width - across * cell;
  return place;
}

float GridReading::lowest(int universe_count) const {
  return *std::min_element(confidence.begin(), confidence.begin() + std::clamp(universe_count, 1, kGridUniversesMax));
}

Result<GridCodec> GridCodec::make(const GridFormat& format) {
  if (format.width < 1 || format.height < 1 || format.width > kGridSizeMaxPx || format.height > kGridSizeMaxPx) {
    return fail(ErrorCode::kBadInput, "a picture of {} x {} pixels; expected 1 to {} in both directions", format.width,
                format.height, kGridSizeMaxPx);
  }
  GridCodec codec;
  codec.format_ = format;
  codec.place_ = format.place.value_or(default_place(format.layout, format.width, format.height));
  const GridPlace& place = codec.place_;
  if (!(place.cell_width >= kCellMinPx) || !(place.cell_height >= kCellMinPx)) {
    return fail(ErrorCode::kBadInput, "cells of {:.2f} x {:.2f} pixels are too small; expected at least {} x {}",
                place.cell_width, place.cell_height, kCellMinPx, kCellMinPx);
  }
  const int across = grid_cells_across(format.layout);
  const int down = grid_cells_down(format.layout);
  const double right = place.left + across * place.cell_width;
  const double bottom = place.top + down * place.cell_height;
  if (!(place.left >= -0.5) || !(place.top >= -0.5) || !(right <= format.width + 0.5) ||
      !(bottom <= format.height + 0.5)) {
    return fail(ErrorCode::kBadInput,
                "the {} grid reaches from {:.1f}, {:.1f} to {:.1f}, {:.1f} and is not inside a picture of {} x {}; "
                "expected a larger picture, such as {} x {}",
                name_of(format.layout), place.left, place.top, right, bottom, format.width, format.height, kGridWidthPx,
                kGridHeightPx);
  }
  const bool has_room = format.layout == GridLayout::kHorizontalBottom ? place.top >= place.cell_height
                        : format.layout == GridLayout::kHorizontalTop  ? bottom + place.cell_height <= format.height
                        : format.layout == GridLayout::kVerticalLeft   ? right + place.cell_width <= format.width
                                                                       : place.left >= place.cell_width;
  if (format.check_row && !has_room) {
    return fail(ErrorCode::kBadInput, "no room for the check row beside the {} grid in a picture of {} x {}",
                name_of(format.layout), format.width, format.height);
  }
  codec.edges_across_ = edges(place.left, place.cell_width, across, format.width);
  codec.edges_down_ = edges(place.top, place.cell_height, down, format.height);
  codec.inner_across_ = inner_parts(place.left, place.cell_width, across, format.width);
  codec.inner_down_ = inner_parts(place.top, place.cell_height, down, format.height);
  codec.set_tables();
  return codec;
}

void GridCodec::set_tables() {
  const bool limited = format_.range == GridRange::kLimited;
  for (int i = 0; i < 256; ++i) {
    const auto at = static_cast<std::size_t>(i);
    double shown = i / 255.0;
    if (format_.transfer == GridTransfer::kFromSrgb) shown = linear_of_srgb(shown);
    if (format_.transfer == GridTransfer::kToSrgb) shown = srgb_of_linear(shown);
    code_of_[at] = rounded(limited ? kLimitedBlack + kLimitedSpan * shown : 255 * shown);
    double read = limited ? std::clamp((i - kLimitedBlack) / kLimitedSpan, 0.0, 1.0) : i / 255.0;
    if (format_.transfer == GridTransfer::kFromSrgb) read = srgb_of_linear(read);
    if (format_.transfer == GridTransfer::kToSrgb) read = linear_of_srgb(read);
    level_of_[at] = rounded(255 * read);
  }
}

int GridCodec::slot_count(int universe) const {
  if (universe < 1 || universe > universe_count()) return 0;
  if (is_horizontal(format_.layout)) return kSlotCountMax;
  const int first_cell = (universe - 1) % kGridPlaneUniverses * kGridPitch;
  return std::clamp(kGridRowsVertical * kGridColumns - first_cell, 0, kSlotCountMax);
}

int GridCodec::unreachable_count() const {
  int count = 0;
  for (int universe = 1; universe <= universe_count(); ++universe) count += kSlotCountMax - slot_count(universe);
  return count;
}

void GridCodec::encode(std::span<const std::uint8_t> levels, Picture& picture, std::uint16_t sequence) const {
  if (picture.width != format_.width || picture.height != format_.height) {
    picture.clear(format_.width, format_.height);
    if (code_of_[0] != 0) std::fill(picture.rgb.begin(), picture.rgb.end(), code_of_[0]);
  }
  const int across_count = grid_cells_across(format_.layout);
  const int down_count = grid_cells_down(format_.layout);
  const auto code_at = [&](int plane, int cell) {
    const int universe = plane * kGridPlaneUniverses + cell / kGridPitch;  // from 0
    const int slot = cell % kGridPitch;
    const auto at = static_cast<std::size_t>(universe * kSlotCountMax + slot);
    return code_of_[slot < kSlotCountMax && at < levels.size() ? levels[at] : 0];
  };
  const std::size_t left = static_cast<std::size_t>(edges_across_.front());
  const std::size_t row_bytes = 3 * (static_cast<std::size_t>(edges_across_.back()) - left);
  for (int down = 0; down < down_count; ++down) {
    const int top = edges_down_[static_cast<std::size_t>(down)];
    const int bottom = edges_down_[static_cast<std::size_t>(down) + 1];
    if (top == bottom) continue;
    std::uint8_t* const first_row = picture.at(static_cast<int>(left), top);
    std::uint8_t* pixel = first_row;
    for (int across = 0; across < across_count; ++across) {
      const int cell = grid_cell_at(format_.layout, format_.flipped, across, down);
      const bool luma = format_.planes == GridPlanes::kLuma;
      const std::uint8_t red = code_at(0, cell);
      const std::uint8_t green = luma ? red : code_at(1, cell);
      const std::uint8_t blue = luma ? red : code_at(2, cell);
      const int end = edges_across_[static_cast<std::size_t>(across) + 1];
      for (int x = edges_across_[static_cast<std::size_t>(across)]; x < end; ++x, pixel += 3) {
        pixel[0] = red;
        pixel[1] = green;
        pixel[2] = blue;
      }
    }
    for (int y = top + 1; y < bottom; ++y) {
      std::memcpy(picture.at(static_cast<int>(left), y), first_row, row_bytes);
    }
  }
  if (format_.check_row) draw_check(levels, picture, sequence);
}

Status GridCodec::decode(const PictureView& picture, std::span<std::uint8_t> levels, GridReading& reading) const {
  FL_CHECK_GE(levels.size(), static_cast<std::size_t>(universe_count()) * kSlotCountMax);
  if (picture.width != format_.width || picture.height != format_.height) {
    return fail(ErrorCode::kBadInput, "a picture of {} x {} pixels; expected {} x {}", picture.width, picture.height,
                format_.width, format_.height);
  }
  reading = {};
  levels = levels.first(static_cast<std::size_t>(universe_count()) * kSlotCountMax);
  std::fill(levels.begin(), levels.end(), std::uint8_t{0});
  const bool luma = format_.planes == GridPlanes::kLuma;
  const int plane_count = luma ? 1 : 3;
  std::array<CellEvidence, kGridUniversesMax> evidence;
  std::array<int, kGridUniversesMax> cells{};
  bool blank = true;
  for (int down = 0; down < grid_cells_down(format_.layout); ++down) {
    const int* const inner_down = &inner_down_[2 * static_cast<std::size_t>(down)];
    for (int across = 0; across < grid_cells_across(format_.layout); ++across) {
      const int* const inner_across = &inner_across_[2 * static_cast<std::size_t>(across)];
      const CellColor color = color_of(picture, inner_across[0], inner_across[1], inner_down[0], inner_down[1]);
      const double quality = quality_of(color, luma);
      const int cell = grid_cell_at(format_.layout, format_.flipped, across, down);
      const int slot = cell % kGridPitch;
      for (int plane = 0; plane < plane_count; ++plane) {
        const auto universe = static_cast<std::size_t>(plane * kGridPlaneUniverses + cell / kGridPitch);
        const double code = luma ? luminance_of(color) : color.mean[static_cast<std::size_t>(plane)];
        const std::uint8_t level = level_of_[rounded(code)];
        evidence[universe].add(quality, std::abs(code - code_of_[0]), slot >= kSlotCountMax);
        ++cells[universe];
        blank = blank && level == 0;
        if (slot < kSlotCountMax) levels[universe * kSlotCountMax + static_cast<std::size_t>(slot)] = level;
      }
    }
  }
  reading.blank = blank;
  for (std::size_t i = 0; i < static_cast<std::size_t>(universe_count()); ++i) {
    // The second universe of a vertical grid ends before its padding, and the third is not shown.
    const std::size_t first = i / kGridPlaneUniverses * kGridPlaneUniverses;
    double confidence = evidence[first].confidence(cells[first]);
    if (cells[i] > 0) {
      const double own = evidence[i].confidence(cells[i]);
      confidence = evidence[i].padding_cells > 0 ? own : std::min(own, confidence);
    }
    reading.confidence[i] = static_cast<float>(confidence);
  }
  if (format_.check_row) read_check(picture, levels, reading);
  return {};
}

}  // namespace footlight::drivers

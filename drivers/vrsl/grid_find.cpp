#include "drivers/vrsl/grid_find.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "drivers/vrsl/grid_cells.h"

namespace footlight::drivers {
namespace {

constexpr GridLayout kLayoutsTried[] = {GridLayout::kHorizontalBottom, GridLayout::kHorizontalTop,
                                        GridLayout::kVerticalLeft, GridLayout::kVerticalRight};
constexpr int kEdgesMin = 12;          // neighbours of different levels that a grid must have to be found
constexpr double kEdgeCodes = 16;      // the difference between them
constexpr double kSharpMin = 0.85;     // share of these edges that are sharp
constexpr double kFoundCellMinPx = 5;  // smaller cells have too few pixels to be certain; 640 pixels of width have 5.33
constexpr double kTintCodes = 24;      // of a cell that is not grey
constexpr double kFoundBlack = 16;     // and how far padding may be away from it
constexpr double kLimitedSlack = 6;
constexpr double kLimitedWhite = 243;  // with some overshoot

// The cells of a layout at a place.
struct Cells {
  GridLayout layout = GridLayout::kHorizontalBottom;
  GridPlace place;
  int across = 0, down = 0;
  std::vector<int> xs, ys;        // inner_parts()
  std::vector<CellColor> colors;  // rows from the top
  [[nodiscard]] const CellColor& at(int x, int y) const {
    return colors[static_cast<std::size_t>(y) * static_cast<std::size_t>(across) + static_cast<std::size_t>(x)];
  }
};

bool is_inside(const GridPlace& place, GridLayout layout, int width, int height) {
  return place.cell_width >= kFoundCellMinPx && place.cell_height >= kFoundCellMinPx && place.left >= -0.5 &&
         place.top >= -0.5 && place.left + grid_cells_across(layout) * place.cell_width <= width + 0.5 &&
         place.top + grid_cells_down(layout) * place.cell_height <= height + 0.5;
}

Cells cells_of(const PictureView& picture, GridLayout layout, const GridPlace& place) {
  Cells cells{layout, place, grid_cells_across(layout), grid_cells_down(layout), {}, {}, {}};
  cells.xs = inner_parts(place.left, place.cell_width, cells.across, picture.width);
  cells.ys = inner_parts(place.top, place.cell_height, cells.down, picture.height);
  cells.colors.reserve(static_cast<std::size_t>(cells.across * cells.down));
  for (std::size_t y = 0; y < cells.ys.size(); y += 2) {
    for (std::size_t x = 0; x < cells.xs.size(); x += 2) {
      cells.colors.push_back(color_of(picture, cells.xs[x], cells.xs[x + 1], cells.ys[y], cells.ys[y + 1]));
    }
  }
  return cells;
}

double distance_of(const CellColor& a, const CellColor& b) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a.mean[c] - b.mean[c]));
  return most;
}
double from_black(const CellColor& color, double black) { return distance_of(color, {{black, black, black}, 0}); }

// The step between the two halves of a cell's inner part, from left to right or from top to bottom. 0 in a grid, a
// quarter of the step to the next cell in a picture that changes smoothly.
double slope_of(const PictureView& picture, const Cells& cells, int x, int y, bool across) {
  const auto at_x = 2 * static_cast<std::size_t>(x), at_y = 2 * static_cast<std::size_t>(y);
  const int left = cells.xs[at_x], right = cells.xs[at_x + 1], top = cells.ys[at_y], bottom = cells.ys[at_y + 1];
  const int middle = across ? (left + right) / 2 : (top + bottom) / 2;
  if (middle == (across ? left : top)) return 0;
  if (across) {
    return distance_of(color_of(picture, left, middle, top, bottom), color_of(picture, middle, right, top, bottom));
  }
  return distance_of(color_of(picture, left, right, top, middle), color_of(picture, left, right, middle, bottom));
}

struct Edges {
  int all = 0;
  int sharp = 0;
};

Edges edges_of(const PictureView& picture, const Cells& cells) {
  constexpr double kSlopeMax = 0.12, kSlopeNoise = 1.5;
  Edges edges;
  const auto add = [&](int x, int y, int other_x, int other_y, bool across) {
    const double step = distance_of(cells.at(x, y), cells.at(other_x, other_y));
    if (step <= kEdgeCodes) return;
    ++edges.all;
    const double slope =
        std::max(slope_of(picture, cells, x, y, across), slope_of(picture, cells, other_x, other_y, across));
    edges.sharp += slope <= kSlopeMax * step + kSlopeNoise ? 1 : 0;
  };
  for (int y = 0; y < cells.down; ++y) {
    for (int x = 0; x < cells.across; ++x) {
      if (x > 0) add(x, y, x - 1, y, true);
      if (y > 0) add(x, y, x, y - 1, false);
    }
  }
  return edges;
}

// How the cells are read: what fits best of upside down or not, colours or grey, full or limited.
struct Reading {
  bool flipped = false;
  bool either_way = false;  // upside down fits as well
  GridPlanes planes = GridPlanes::kLuma;
  GridRange range = GridRange::kFull;
  double confidence = 0;
  double blackness = 0;  // of the padding
  int good = 0;          // lit cells of one colour
};

CellEvidence evidence_of(const Cells& cells, bool flipped, bool grey, double black) {
  CellEvidence evidence;
  for (int y = 0; y < cells.down; ++y) {
    for (int x = 0; x < cells.across; ++x) {
      const CellColor& color = cells.at(x, y);
      const bool padding = grid_cell_at(cells.layout, flipped, x, y) % kGridPitch >= kSlotCountMax;
      evidence.add(quality_of(color, grey), from_black(color, black), padding);
    }
  }
  return evidence;
}

Reading reading_of(const Cells& cells) {
  Reading reading;
  int tinted = 0;
  double most = 0, least = 255;
  for (const CellColor& color : cells.colors) {
    const auto [low, high] = std::minmax_element(color.mean.begin(), color.mean.end());
    if (*high - *low > kTintCodes && quality_of(color, false) >= 0.5) ++tinted;
    most = std::max(most, *high);
    least = std::min(least, *low);
  }
  if (tinted >= 4) reading.planes = GridPlanes::kRgb;
  const bool grey = reading.planes == GridPlanes::kLuma;
  for (const auto range : {GridRange::kFull, GridRange::kLimited}) {
    if (range == GridRange::kLimited && (least < kFoundBlack - kLimitedSlack || most > kLimitedWhite)) continue;
    const double black = range == GridRange::kLimited ? kFoundBlack : 0;
    const CellEvidence upright = evidence_of(cells, false, grey, black);
    const CellEvidence turned = evidence_of(cells, true, grey, black);
    const int count = cells.across * cells.down;
    const bool flipped = turned.blackness() > upright.blackness();
    const CellEvidence& better = flipped ? turned : upright;
    if (range == GridRange::kLimited && better.confidence(count) <= reading.confidence) continue;
    reading.range = range;
    reading.confidence = better.confidence(count);
    reading.blackness = better.blackness();
    reading.good = better.good;
    reading.flipped = flipped;
    reading.either_way = std::min(upright.blackness(), turned.blackness()) >= kGridConfidenceMin;
  }
  // Where both fit, the grid is as VRSL has it.
  if (reading.either_way) reading.flipped = false;
  return reading;
}

// ---- Places that no layout has of itself ----

// Differences between neighbouring pixels, summed up per column (or row) over a part of the picture; 0 at the border.
std::vector<double> steps_across(const PictureView& picture, int top, int bottom) {
  std::vector<double> steps(static_cast<std::size_t>(picture.width) + 1);
  for (int y = top; y < bottom; ++y) {
    const std::uint8_t* pixel = picture.row(y) + 3;
    for (int x = 1; x < picture.width; ++x, pixel += 3) {
      const int step = std::abs(pixel[0] - pixel[-3]) + std::abs(pixel[1] - pixel[-2]) + std::abs(pixel[2] - pixel[-1]);
      steps[static_cast<std::size_t>(x)] += std::min(step, 96);
    }
  }
  for (double& step : steps) step /= 96.0 * std::max(bottom - top, 1);
  return steps;
}
std::vector<double> steps_down(const PictureView& picture, int left, int right) {
  std::vector<double> steps(static_cast<std::size_t>(picture.height) + 1);
  for (int y = 1; y < picture.height; ++y) {
    const std::uint8_t* above = picture.at(left, y - 1);
    const std::uint8_t* below = picture.at(left, y);
    double sum = 0;
    for (int i = 0; i < 3 * (right - left); i += 3) {
      const int step =
          std::abs(below[i] - above[i]) + std::abs(below[i + 1] - above[i + 1]) + std::abs(below[i + 2] - above[i + 2]);
      sum += std::min(step, 96);
    }
    steps[static_cast<std::size_t>(y)] = sum / (96.0 * std::max(right - left, 1));
  }
  return steps;
}

// Lines at first + k * pitch, k = 0 to cells.
struct Comb {
  double first = 0;
  double pitch = 0;
  double score = 0;
};

// Combs that fit the steps: large ones on the lines, small ones in the middle of cells. Best first, all different.
class CombSearch {
 public:
  explicit CombSearch(const std::vector<double>& steps) : size_(static_cast<int>(steps.size()) - 1) {
    near_.resize(steps.size());
    sums_.resize(steps.size() + 1);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      near_[i] = std::max({steps[i], i > 0 ? steps[i - 1] : 0, i + 1 < steps.size() ? steps[i + 1] : 0});
      sums_[i + 1] = sums_[i] + steps[i];
    }
  }

  void search(int cells, double pitch_from, double pitch_to, double pitch_step) {
    for (double pitch = pitch_from; pitch <= pitch_to && pitch * cells <= size_ + 0.5; pitch += pitch_step) {
      for (double first = 0; first + pitch * cells <= size_ + 0.5; first += 1) {
        if (may_fit(first, pitch)) keep(score(cells, first, pitch));
      }
    }
  }
  [[nodiscard]] const std::vector<Comb>& best() const { return best_; }

 private:
  // Judges by the first cells: lines, and less between them.
  [[nodiscard]] bool may_fit(double first, double pitch) const {
    constexpr double kLineMin = 0.01;
    double lines = 0, middles = 0;
    for (int k = 1; k <= 3; ++k) {
      const double line = near_[static_cast<std::size_t>(std::lround(first + k * pitch))];
      if (line < kLineMin) return false;
      lines += line;
      middles += near_[static_cast<std::size_t>(std::lround(first + (k - 0.5) * pitch))];
    }
    return middles < lines;
  }

  [[nodiscard]] Comb score(int cells, double first, double pitch) const {
    double lines = 0, middles = 0;
    for (int k = 0; k <= cells; ++k) {
      const double at = first + k * pitch;
      // The border of the picture is a line as well as any other.
      if (k > 0 && k < cells) lines += near_[static_cast<std::size_t>(std::lround(at))];
      if (k == cells) break;
      const auto from = static_cast<std::size_t>(std::lround(at + 0.3 * pitch));
      const auto to = std::max(from + 1, static_cast<std::size_t>(std::lround(at + 0.7 * pitch)));
      middles += (sums_[to] - sums_[from]) / static_cast<double>(to - from);
    }
    return {first, pitch, lines / (cells - 1) - 3 * middles / cells};
  }

  void keep(const Comb& comb) {
    constexpr std::size_t kMost = 6;
    if (comb.score <= 0.02 || (best_.size() == kMost && comb.score <= best_.back().score)) return;
    const auto near = [&](const Comb& other) {
      return std::abs(other.first - comb.first) < 2 && std::abs(other.pitch - comb.pitch) < 0.3;
    };
    const auto same = std::find_if(best_.begin(), best_.end(), near);
    if (same != best_.end()) {
      if (same->score >= comb.score) return;
      *same = comb;
    } else {
      best_.push_back(comb);
    }
    std::sort(best_.begin(), best_.end(), [](const Comb& a, const Comb& b) { return a.score > b.score; });
    if (best_.size() > kMost) best_.pop_back();
  }

  int size_;
  std::vector<double> near_, sums_;
  std::vector<Comb> best_;
};

constexpr double kPitchMax = 40;

// Places where the short side of a grid fits, with the long side fitted to it.
std::vector<GridPlace> places_of(const PictureView& picture, bool horizontal) {
  std::vector<GridPlace> places;
  const int short_cells = kGridColumns;
  const int long_cells = horizontal ? kGridRows : kGridRowsVertical;
  const int long_size = horizontal ? picture.width : picture.height;
  CombSearch sides(horizontal ? steps_down(picture, 0, picture.width) : steps_across(picture, 0, picture.height));
  sides.search(short_cells, kFoundCellMinPx, std::min(kPitchMax, (long_size + 0.5) / long_cells), 0.06);
  for (const Comb& side : sides.best()) {
    const int from = std::max(static_cast<int>(std::lround(side.first)), 0);
    const int to = std::min(static_cast<int>(std::lround(side.first + short_cells * side.pitch)),
                            horizontal ? picture.height : picture.width);
    CombSearch lengths(horizontal ? steps_across(picture, from, to) : steps_down(picture, from, to));
    lengths.search(long_cells, side.pitch - 0.1, side.pitch + 0.1, 0.01);
    for (const Comb& length : lengths.best()) {
      const Comb& x = horizontal ? length : side;
      const Comb& y = horizontal ? side : length;
      // The long side measures the cells more exactly.
      const double middle = side.first + short_cells * side.pitch / 2;
      const double begin = middle - short_cells * length.pitch / 2;
      places.push_back({horizontal ? x.first : begin, horizontal ? begin : y.first, length.pitch, length.pitch});
    }
  }
  return places;
}

struct Candidate {
  Cells cells;
  Reading reading;
};

// What a place shows, if that can be a grid at all. It may be damaged: the caller decides by its confidence.
std::optional<Candidate> candidate_at(const PictureView& picture, GridLayout layout, const GridPlace& place) {
  if (!is_inside(place, layout, picture.width, picture.height)) return std::nullopt;
  Candidate candidate{cells_of(picture, layout, place), {}};
  candidate.reading = reading_of(candidate.cells);
  if (candidate.reading.blackness < kGridConfidenceMin) return std::nullopt;
  const Edges edges = edges_of(picture, candidate.cells);
  if (edges.sharp < kEdgesMin || edges.sharp < kSharpMin * edges.all) return std::nullopt;
  return candidate;
}

// The candidate that explains most cells, and one that explains as many in another way. A corner of a grid of one
// layout is a grid of another layout with few cells, so more cells are better than a higher confidence.
struct Choice {
  std::optional<Candidate> best;
  std::optional<Candidate> rival;

  void consider(std::optional<Candidate> candidate) {
    if (!candidate) return;
    if (best && candidate->reading.good == best->reading.good) {
      rival = std::move(candidate);
    } else if (!best || candidate->reading.good > best->reading.good) {
      best = std::move(candidate);
      rival.reset();
    }
  }
};

// True if the grid, moved by a cell, covers as many lit cells.
bool fits_elsewhere(const PictureView& picture, const Candidate& candidate) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) continue;
      GridPlace place = candidate.cells.place;
      place.left += dx * place.cell_width;
      place.top += dy * place.cell_height;
      const auto other = candidate_at(picture, candidate.cells.layout, place);
      if (other && other->reading.confidence >= kGridConfidenceMin && other->reading.good >= candidate.reading.good) {
        return true;
      }
    }
  }
  return false;
}

// ---- Transfer ----

// Bits of evidence that the codes come from a transfer that leaves gaps: a code that fits has as many as codes near it
// are left out. nullopt if a code does not fit.
std::optional<double> bits_for(const GridFormat& format, const std::array<bool, 256>& seen) {
  const auto codec = GridCodec::make(format);
  if (!codec) return std::nullopt;
  std::array<bool, 256> used{};
  for (int level = 0; level < 256; ++level) used[codec->code_of(static_cast<std::uint8_t>(level))] = true;
  double bits = 0;
  for (int code = 0; code < 256; ++code) {
    if (!seen[static_cast<std::size_t>(code)]) continue;
    if (!used[static_cast<std::size_t>(code)]) return std::nullopt;
    int near = 0, filled = 0;
    for (int other = std::max(code - 8, 0); other <= std::min(code + 8, 255); ++other, ++near) {
      filled += used[static_cast<std::size_t>(other)] ? 1 : 0;
    }
    bits += std::log2(static_cast<double>(near) / filled);
  }
  return bits;
}

constexpr double kTransferBits = 12;  // one picture in 4,000 has them by chance

void find_transfer(const Cells& cells, GridFinding& finding) {
  std::array<bool, 256> seen{};
  int exact = 0;
  for (const CellColor& color : cells.colors) {
    if (color.variance > 0.01) continue;
    ++exact;
    for (const double mean : color.mean) seen[static_cast<std::size_t>(std::lround(mean))] = true;
  }
  const bool lossless = exact * 10 >= static_cast<int>(cells.colors.size()) * 9;
  int fitting = 0;
  for (const auto transfer : {GridTransfer::kFromSrgb, GridTransfer::kToSrgb}) {
    GridFormat format = finding.format;
    format.transfer = transfer;
    const auto bits = bits_for(format, seen);
    if (!bits) continue;
    ++fitting;
    if (lossless && *bits >= kTransferBits) {
      finding.format.transfer = transfer;
      return;
    }
  }
  if (!lossless || fitting > 0) {
    finding.open.push_back(
        "The transfer (linear, from-srgb, to-srgb) is not decided by the picture; it is taken as linear.");
  }
}

bool is_black(const PictureView& picture) {
  for (int y = 0; y < picture.height; ++y) {
    const std::uint8_t* const row = picture.row(y);
    if (std::any_of(row, row + 3 * static_cast<std::size_t>(picture.width),
                    [](std::uint8_t code) { return code > 20; }))
      return false;
  }
  return true;
}

}  // namespace

Result<GridFinding> find_grid(const PictureView& picture) {
  if (picture.width < 1 || picture.height < 1 || picture.width > kGridSizeMaxPx || picture.height > kGridSizeMaxPx) {
    return fail(ErrorCode::kNotFound, "no grid: a picture of {} x {} pixels", picture.width, picture.height);
  }
  if (is_black(picture)) {
    return fail(ErrorCode::kNotFound,
                "no grid: the picture is black, and so is a grid whose levels are all 0; set a level, or name the "
                "layout");
  }
  Choice choice;
  for (const GridLayout layout : kLayoutsTried) {
    choice.consider(candidate_at(picture, layout, default_place(layout, picture.width, picture.height)));
  }
  const auto is_certain = [&] { return choice.best && choice.best->reading.confidence >= kGridConfidenceMin; };
  const bool usual = is_certain();
  if (!usual) {
    for (const bool horizontal : {true, false}) {
      const GridLayout layout = horizontal ? GridLayout::kHorizontalBottom : GridLayout::kVerticalLeft;
      for (const GridPlace& place : places_of(picture, horizontal)) {
        auto candidate = candidate_at(picture, layout, place);
        // Neighbouring guesses of one place are no rivals.
        if (candidate && choice.best && candidate->reading.good == choice.best->reading.good) continue;
        choice.consider(std::move(candidate));
      }
    }
  }
  if (!is_certain()) {
    return fail(ErrorCode::kNotFound,
                "no grid: no blocks of one colour with black padding fit the picture; the best guess has a confidence "
                "of {:.2f}, expected at least {}",
                choice.best ? choice.best->reading.confidence : 0.0, kGridConfidenceMin);
  }
  const Candidate& best = *choice.best;
  if (choice.rival) {
    return fail(ErrorCode::kNotFound,
                "no certain grid: the few lit cells fit {} as well as {}; name the layout, as in layout={}",
                name_of(best.cells.layout), name_of(choice.rival->cells.layout), name_of(best.cells.layout));
  }
  if (!usual && fits_elsewhere(picture, best)) {
    return fail(ErrorCode::kNotFound,
                "no certain grid: it fits at several places that are a cell apart, because too few levels are above 0; "
                "name the layout and the place");
  }
  GridFinding finding;
  finding.format.layout = best.cells.layout;
  finding.format.planes = best.reading.planes;
  finding.format.range = best.reading.range;
  finding.format.flipped = best.reading.flipped;
  finding.format.width = picture.width;
  finding.format.height = picture.height;
  if (!usual) finding.format.place = best.cells.place;
  finding.confidence = static_cast<float>(best.reading.confidence);
  if (best.reading.either_way) {
    finding.open.push_back(
        "Upside down or not is not decided by the picture, because addresses near 512 are 0; it is taken as VRSL has "
        "it.");
  }
  if (best.reading.planes == GridPlanes::kLuma) {
    finding.open.push_back("It is grey: three universes, or nine of which 4 to 6 and 7 to 9 equal 1 to 3.");
  }
  find_transfer(best.cells, finding);
  return finding;
}

}  // namespace footlight::drivers

// The grid: DMX universes as blocks of grey or colour in a picture, as VR Stage Lighting (VRSL) takes them.
//
//   FL_ASSIGN(const GridCodec codec, GridCodec::make({.planes = GridPlanes::kRgb}));
//   Picture picture;
//   codec.encode(levels, picture);              // 9 x 512 levels to 1920 x 1080 pixels
//   FL_TRY(codec.decode(picture.view(), levels, reading));
//
// A universe fills 520 cells: 512 addresses and 8 of padding, which is black. Cell i of a plane has column i mod 13 and
// row i div 13 of a table; a row is a fixture of 13 channels. A picture shows the table in one of two ways:
//
//   horizontal  120 x 13 cells: rows of the table run to the right, column 0 is at the top
//   vertical    13 x 67 cells: columns run to the right, row 0 is at the bottom. Rows from 67 on are not shown
//
// A cell is 16 x 16 pixels of a picture that is 1920 wide, and scales with the picture.
//
// VRSL's camera, which looks at the video, is turned by 90 degrees for horizontal grids (prefab
// VRSL-DMX-USharpVideoReaderScreen-Horizontal), and HNode writes what it expects (SerializerVRSL, TextureWriter). The
// texture that VRSL's editor fills from OSC (GridReader) is mirrored: its column 0 is at the bottom. That is `flipped`.
//
// Facts: VRSL commit 12dedbe, HNode commits e1a7a51 and 8792f4b. Threads: a codec may be used by several at once.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/vrsl/picture.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr int kGridColumns = 13;  // of the table
inline constexpr int kGridRows = 120;    // three universes
inline constexpr int kGridRowsVertical = 67;
inline constexpr int kGridPitch = 520;  // cells of a universe
inline constexpr int kGridPlaneUniverses = 3;
inline constexpr int kGridUniversesMax = 9;
inline constexpr int kGridCellPx = 16;  // of a picture kGridWidthPx wide
inline constexpr int kGridWidthPx = 1920;
inline constexpr int kGridHeightPx = 1080;
inline constexpr int kGridSizeMaxPx = 8192;  // width and height of pictures

enum class GridLayout {
  kHorizontalBottom,  // VRSL's own place for a horizontal grid
  kHorizontalTop,
  kVerticalLeft,
  kVerticalRight,
};
enum class GridPlanes {
  kLuma,  // universes 1 to 3, each as red, green and blue alike; read as luminance
  kRgb,   // universes 1 to 3 in red, 4 to 6 in green, 7 to 9 in blue
};
enum class GridRange {
  kFull,     // codes 0 to 255
  kLimited,  // codes 16 to 235: 220 of 256 levels remain
};
enum class GridTransfer {
  kLinear,    // the code is the level
  kFromSrgb,  // code = level read as sRGB and made linear: HNode's "Gamma Correction"; dark levels coincide
  kToSrgb,    // the opposite, for a reader that makes the picture linear; bright levels coincide
};
// Names as in options of endpoints: "horizontal-bottom", "luma", "full", "linear", "from-srgb".
[[nodiscard]] std::string_view name_of(GridLayout layout);
[[nodiscard]] std::string_view name_of(GridPlanes planes);
[[nodiscard]] std::string_view name_of(GridRange range);
[[nodiscard]] std::string_view name_of(GridTransfer transfer);
[[nodiscard]] constexpr bool is_horizontal(GridLayout layout) {
  return layout == GridLayout::kHorizontalBottom || layout == GridLayout::kHorizontalTop;
}

// Where the grid is in a picture, in pixels from its top left corner.
struct GridPlace {
  double left = 0;
  double top = 0;
  double cell_width = kGridCellPx;
  double cell_height = kGridCellPx;
  bool operator==(const GridPlace&) const = default;
};

struct GridFormat {
  GridLayout layout = GridLayout::kHorizontalBottom;
  GridPlanes planes = GridPlanes::kLuma;
  GridRange range = GridRange::kFull;
  GridTransfer transfer = GridTransfer::kLinear;
  bool flipped = false;  // the grid is upside down in its place
  // A row of blocks beside the grid with a sequence number and a CRC-32 (grid_check.h). Outside VRSL's grid.
  bool check_row = false;
  int width = kGridWidthPx;  // of the picture
  int height = kGridHeightPx;
  std::optional<GridPlace> place;  // nullopt: default_place()
  bool operator==(const GridFormat&) const = default;
};

// The place that a layout has in a picture of this size: along its edge, with cells of width / 120 pixels. A picture
// with the proportions of the grid alone is the grid alone.
[[nodiscard]] GridPlace default_place(GridLayout layout, int width, int height);
// Cells of a layout in the picture: 120 x 13 or 13 x 67.
[[nodiscard]] constexpr int grid_cells_across(GridLayout layout) {
  return is_horizontal(layout) ? kGridRows : kGridColumns;
}
[[nodiscard]] constexpr int grid_cells_down(GridLayout layout) {
  return is_horizontal(layout) ? kGridColumns : kGridRowsVertical;
}
// The cell of a plane (0 to 1559) at a place in the picture, counted in cells from the top left of the grid.
[[nodiscard]] constexpr int grid_cell_at(GridLayout layout, bool flipped, int across, int down) {
  if (is_horizontal(layout)) return across * kGridColumns + (flipped ? kGridColumns - 1 - down : down);
  return (flipped ? down : kGridRowsVertical - 1 - down) * kGridColumns + across;
}

// What was found in a picture beside the levels.
struct GridReading {
  // For each universe, 0 to 1: how far its cells are of one colour each (grey, in luma planes) and its padding is
  // black. 1: as encoded. Below kGridConfidenceMin it is another picture, or too damaged to use. A universe that the
  // layout does not show has the value of the first of its plane.
  std::array<float, kGridUniversesMax> confidence{};
  bool blank = false;  // every cell is as for level 0: a blackout, or a picture without a grid
  // The check row, if the format has one and it was readable.
  std::optional<std::uint16_t> sequence;
  bool damaged = false;  // its CRC-32 differs, or the format has a check row and none was readable
  [[nodiscard]] float lowest(int universe_count) const;
};
inline constexpr float kGridConfidenceMin = 0.5f;

class GridCodec {
 public:
  // Errors: kBadInput if the picture is larger than kGridSizeMaxPx or cells are smaller than 2 pixels, or if the grid
  // (or its check row) is not inside the picture.
  [[nodiscard]] static Result<GridCodec> make(const GridFormat& format);

  [[nodiscard]] const GridFormat& format() const { return format_; }
  [[nodiscard]] const GridPlace& place() const { return place_; }
  [[nodiscard]] int universe_count() const { return format_.planes == GridPlanes::kRgb ? 9 : 3; }
  // Addresses of a universe that the layout carries, from address 1 on: 512, or 351 and 0 for the second and third
  // universe of each plane of a vertical grid. universe: from 1; 0 above universe_count().
  [[nodiscard]] int slot_count(int universe) const;
  [[nodiscard]] bool carries(int universe, Address address) const {
    return is_address(address) && address <= slot_count(universe);
  }
  // Addresses of all its universes that it cannot carry: 0, or 673 for each plane of a vertical grid.
  [[nodiscard]] int unreachable_count() const;

  // `levels`: universe after universe, 512 each; missing ones are 0, and further ones are ignored. Draws the grid and
  // leaves the pixels around it as they are; a picture of another size becomes a black one of the right size first.
  // No allocation otherwise.
  void encode(std::span<const std::uint8_t> levels, Picture& picture, std::uint16_t sequence = 0) const;

  // Writes universe_count() x 512 levels; addresses that the layout does not carry become 0. `levels` has room for
  // them. Uses the mean of the inner half of each cell in both directions. kBadInput if the picture has another size
  // than the format; then nothing was written. A low confidence is no error.
  Status decode(const PictureView& picture, std::span<std::uint8_t> levels, GridReading& reading) const;

  // A level after encoding and decoding without a loss in between: some coincide in limited range and with sRGB.
  [[nodiscard]] std::uint8_t through(std::uint8_t level) const { return level_of_[code_of_[level]]; }
  [[nodiscard]] std::uint8_t code_of(std::uint8_t level) const { return code_of_[level]; }
  [[nodiscard]] std::uint8_t level_of(std::uint8_t code) const { return level_of_[code]; }

 private:
  GridCodec() = default;
  void set_tables();
  void draw_check(std::span<const std::uint8_t> levels, Picture& picture, std::uint16_t sequence) const;
  void read_check(const PictureView& picture, std::span<const std::uint8_t> levels, GridReading& reading) const;
  [[nodiscard]] std::uint32_t check_sum(std::span<const std::uint8_t> levels, std::uint16_t sequence) const;

  GridFormat format_;
  GridPlace place_;
  std::array<std::uint8_t, 256> code_of_{};
  std::array<std::uint8_t, 256> level_of_{};
  // Edges of cells in pixels, one more than there are cells; inner parts as pairs of first and one past the last.
  std::vector<int> edges_across_, edges_down_;
  std::vector<int> inner_across_, inner_down_;
};

}  // namespace footlight::drivers

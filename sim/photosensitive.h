// Protection for people with photosensitive epilepsy: counts flashes, warns, and can limit light.
//
// The input is what the audience sees: the luminance and colour of every tile at a time. A tile is a piece of a picture
// or one fixture's share of the light. It does not use DMX. The caller applies and logs the returned gains. It does not
// certify anything: patterns, camera motion and the viewer's distance are not covered.
//
// Limits and their sources:
// - a flash is a pair of opposing changes of luminance of 20 cd/m2 or more, where the darker is below 160 cd/m2; more
//   than three flashes in a second, together over more than a quarter of the screen, are harmful: ITU-R BT.1702 and
//   Ofcom's Guidance Note on flashing images, as quoted by makers of analysers. On a screen of 200 cd/m2 the change is
//   10 %, which is also WCAG 2's figure;
// - saturated red is R / (R + G + B) >= 0.8, and a red flash changes (R - G - B) x 320 by more than 20, whatever the
//   luminance: WCAG 2, after Harding and Binnie 2002;
// - flashing for more than 5 s may be harmful even within the limits: Ofcom, from memory.
//
// It counts single changes up and down between the extremes of a tile. More than three flashes are more than six
// changes within the window. Tiles that flash out of step are counted together, which is stricter than the guidance.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace footlight {

struct FlashLimits {
  double change_cd_m2 = 20;  // of luminance; > 0
  double dark_cd_m2 = 160;   // changes count if the darker side is below this
  double red_share = 0.8;    // R / (R + G + B) of saturated red
  double red_change = 20;    // of (R - G - B) x 320; > 0
  int flashes = 3;           // allowed within the window; 1 to 15
  double area = 0.25;        // share of the whole that may flash more
  std::int64_t window_ns = 1'000'000'000;
  std::int64_t long_ns = 5'000'000'000;  // flashing for longer than this is reported as long_sequence
};

// Light of one tile. Negative values and NaN count as 0.
struct TileLight {
  double luminance_cd_m2 = 0;
  double red = 0;  // linear, 0 to 1 of full output of the screen or emitter
  double green = 0;
  double blue = 0;
};

struct FlashVerdict {
  double flashes = 0;  // the largest count of any tile within the window, in halves; 16 means 16 or more
  double red_flashes = 0;
  double area = 0;  // share of the whole that flashes more than allowed
  double red_area = 0;
  bool harmful = false;        // either area is above the limit
  bool long_sequence = false;  // more than the area limit has flashed for longer than long_ns, at any rate
  double held_area = 0;        // share of the whole that limit() dimmed in this call
  double least_gain = 1;       // the lowest gain of those tiles
};

// For one thread. Bounded memory: 600 bytes a tile.
class PhotosensitiveGuard {
 public:
  // areas: the share of the whole of each tile. At least one tile.
  PhotosensitiveGuard(const FlashLimits& limits, std::vector<double> areas);

  // Measures what is shown at now_ns. Missing tiles are dark; extra tiles are ignored. If the time goes back, counting
  // starts again.
  FlashVerdict measure(std::int64_t now_ns, std::span<const TileLight> tiles);

  // As measure(), and dims light that would make the picture harmful. gains[i], 0 to 1, is the factor for tile i. Only
  // rises are limited, so nothing becomes brighter than the input. The verdict describes the limited light. It is never
  // harmful if only limited light was shown before.
  FlashVerdict limit(std::int64_t now_ns, std::span<const TileLight> tiles, std::vector<double>& gains);

 private:
  static constexpr std::size_t kChangesMost = 32;

  // The changes of one value.
  struct Swing {
    double low = 0;  // since the last change
    double high = 0;
    int last = 0;  // 1: the last change was up, -1: down, 0: none yet
    bool seen = false;
    std::size_t next = 0;
    std::array<std::int64_t, kChangesMost> changes_ns{};  // times, a ring buffer
    std::size_t count = 0;                                // number of times, at most kChangesMost

    [[nodiscard]] int changes_since(std::int64_t from_ns) const;  // changes after from_ns
    [[nodiscard]] bool rises(double value, double change, double dark) const;
    void take(std::int64_t now_ns, double value, double change, double dark);
  };
  struct Tile {
    double area = 0;
    Swing luminance;
    Swing red;
  };

  [[nodiscard]] double red_value(const TileLight& light) const;
  void restart_if_back(std::int64_t now_ns);
  FlashVerdict verdict(std::int64_t now_ns);

  FlashLimits limits_;
  std::vector<Tile> tiles_;
  std::int64_t last_ns_;
  std::int64_t flashing_since_ns_;
};

}  // namespace footlight

// Checks a sequence of pictures for flashes that can harm people with photosensitive epilepsy, and can hold them back.
//
// The picture is divided into 16 x 9 tiles. A tile's light is the mean of its pixels in linear light, on a screen with
// a white of 200 cd/m^2. The limits and their sources: sim/photosensitive.h. Pictures further apart than half a flash
// miss flashes: at 60 a second most are detected, below 12 a second none (kFlashPauseMaxNs).
#pragma once

#include <vector>

#include "render/image.h"
#include "sim/core/clock.h"
#include "sim/photosensitive.h"

namespace footlight::tools {

inline constexpr DurationNs kFlashPauseMaxNs = 80 * kNsPerMs;
// A picture of so few pixels is enough: four a side of each tile.
inline constexpr int kFlashWidth = 64;
inline constexpr int kFlashHeight = 36;

// A period of harmful flashes, held back or not.
struct FlashStretch {
  DurationNs from_ns = 0;
  DurationNs until_ns = 0;
  double flashes = 0;  // the most within a second, of one tile; 16: or more
  double area = 0;     // largest share of the picture
  bool red = false;    // saturated red was the reason
};

class FlashWatch {
 public:
  // limit: harmful pictures are darkened; otherwise they are only checked.
  explicit FlashWatch(bool limit);

  // Checks the picture that is shown from at_ns on; times increase. With `limit` it is darkened by tile, smoothly
  // between their centres, in linear light. True: a period of harmful flashes begins with this picture.
  bool check(DurationNs at_ns, render::ScreenImage& picture);

  // The same for a caller that cannot darken a picture but can hold the last one. True: do not show this one now.
  bool must_wait(DurationNs at_ns, const render::ScreenImage& picture);

  // From now on must_wait() is called, where pictures were shown as check() has seen them.
  void hold_from_here();

  [[nodiscard]] bool harmful() const { return harmful_; }  // of the input pictures, now
  // So far; the last one may continue.
  [[nodiscard]] const std::vector<FlashStretch>& stretches() const { return stretches_; }
  [[nodiscard]] double least_gain() const { return least_gain_; }  // the strongest darkening; 1: none

 private:
  bool note(DurationNs at_ns, const render::ScreenImage& picture);
  void darken(render::ScreenImage& picture) const;

  bool limit_;
  PhotosensitiveGuard guard_;
  PhotosensitiveGuard input_;  // of the input pictures
  std::vector<TileLight> tiles_;
  std::vector<TileLight> shown_;  // of must_wait(): the picture that is held
  std::vector<double> gains_;
  std::vector<FlashStretch> stretches_;
  bool harmful_ = false;
  double least_gain_ = 1;
};

}  // namespace footlight::tools

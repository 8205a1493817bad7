// Watches a sequence of pictures for flashes that harm people with photosensitive epilepsy, and can hold them back.
//
// The picture is cut into 16 x 9 tiles; a tile's light is the mean of its pixels in linear light, on a screen whose
// white is 200 cd/m^2. What counts as harmful, and from whose guidance: sim/photosensitive.h. Pictures further apart
// than half of a flash hide flashes: 60 a second tell most, fewer than 12 a second tell nothing (kFlashPauseMaxNs).
#pragma once

#include <vector>

#include "render/image.h"
#include "sim/core/clock.h"
#include "sim/photosensitive.h"

namespace footlight::tools {

inline constexpr DurationNs kFlashPauseMaxNs = 80 * kNsPerMs;

// A stretch of the sequence in which it was harmful, or would have been.
struct FlashStretch {
  DurationNs from_ns = 0;
  DurationNs until_ns = 0;
  double flashes = 0;  // most within a second, of one tile; 16: or more
  double area = 0;     // largest share of the picture
  bool red = false;    // saturated red was the reason
};

class FlashWatch {
 public:
  // limit: pictures are darkened where they would be harmful; otherwise they are only looked at.
  explicit FlashWatch(bool limit);

  // The picture shown from at_ns on; times rise. Darkens it where the watch limits: by tile, smooth between their
  // centres, in linear light. True: a stretch has begun with this picture.
  bool snapshot(DurationNs at_ns, render::ScreenImage& picture);

  // The same, for who cannot darken a picture but show the last one longer. True: this one must not follow now.
  bool must_wait(DurationNs at_ns, const render::ScreenImage& picture);

  [[nodiscard]] bool harmful() const { return harmful_; }  // the pictures as they come, now
  // So far; the last one may still be going on.
  [[nodiscard]] const std::vector<FlashStretch>& stretches() const { return stretches_; }
  [[nodiscard]] double least_gain() const { return least_gain_; }  // the strongest darkening; 1: none

 private:
  bool note(DurationNs at_ns, const render::ScreenImage& picture);
  void darken(render::ScreenImage& picture) const;

  bool limit_;
  PhotosensitiveGuard guard_;
  PhotosensitiveGuard asked_;  // of the pictures as they came: what would have been
  std::vector<TileLight> tiles_;
  std::vector<TileLight> shown_;  // of must_wait(): the picture that stands
  std::vector<double> gains_;
  std::vector<FlashStretch> stretches_;
  bool harmful_ = false;
  double least_gain_ = 1;
};

}  // namespace footlight::tools

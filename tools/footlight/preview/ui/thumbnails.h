// Small pictures of the show over a log, by time: which there are, which is made next, and how they are drawn.
//
// Dear ImGui 1.86 draws no images with Vulkan but its font, so a picture is a mesh with a colour at each corner. The
// shelf beside the glyphs (picture_shelf.h) has cells of 64 x 64 only.
// Knows no GPU. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/core/clock.h"

namespace footlight::tools {

class Thumbnails {
 public:
  static constexpr int kWidth = 96;
  static constexpr int kHeight = 54;
  static constexpr std::size_t kCountMax = 64;  // evenly over the log; 26 kB each

  struct Picture {
    TimeNs at_ns = 0;
    std::vector<std::uint32_t> pixels;  // kWidth x kHeight, as ImGui has colours; rows from the top
    std::vector<std::uint32_t> half;    // kWidth / 2 x kHeight / 2, means of four
  };

  // Times ascend in the order of all(). A picture at a time that has one replaces it.
  void add(TimeNs at_ns, std::span<const std::uint8_t> rgba);
  [[nodiscard]] const std::vector<Picture>& all() const { return pictures_; }
  // The one whose time is nearest; null: there is none within reach_ns.
  [[nodiscard]] const Picture* nearest(TimeNs at_ns, DurationNs reach_ns) const;
  void clear() { pictures_.clear(); }

  // The time that the next picture is for: the log is divided into kCountMax parts, coarsely at first, and each gets a
  // picture of its beginning. Nothing: all up to known_ns have one.
  [[nodiscard]] std::optional<TimeNs> next(DurationNs duration_ns, TimeNs known_ns) const;
  // No picture can be made for this time, or it is that of another time.
  void pass_over(TimeNs at_ns) { passed_.push_back(at_ns); }

 private:
  std::vector<Picture> pictures_;
  std::vector<TimeNs> passed_;
};

}  // namespace footlight::tools

// Small square pictures that panels draw, all in one square image, which the window has beside the glyphs of its text.
//
// A panel asks for a picture by its key, in every frame. The first time the shelf notes it; a thread makes it, one
// picture at a time, and it is there some frames later. When the shelf is full, the picture that was not asked for for
// the longest time makes room, unless it was asked for in this frame. Threads: one, but for `make`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/core/result.h"

namespace footlight::tools {

inline constexpr int kShelfPicturePx = 64;

struct ShelfPicture {
  std::vector<std::uint8_t> rgba;  // kShelfPicturePx a side, row by row from the top
};

class PictureShelf {
 public:
  static constexpr int kSide = 8;  // pictures a side of the shelf
  static constexpr int kSizePx = kSide * kShelfPicturePx;

  // How pictures are made: calls `make`, on another thread or at once. Tests pass their own.
  using Start = std::function<std::future<Result<ShelfPicture>>(std::function<Result<ShelfPicture>()> make)>;
  explicit PictureShelf(Start start = on_a_thread());
  [[nodiscard]] static Start on_a_thread();

  // A part of the texture of the user interface: of each side, 0 to 1.
  struct Place {
    float left = 0;
    float top = 0;
    float right = 0;
    float bottom = 0;
  };
  // Nothing while it is being made, and if it cannot be. `make` must own what it uses, which lives as long as the key.
  [[nodiscard]] std::optional<Place> find(const std::string& key, const std::function<Result<ShelfPicture>()>& make);
  // Once a frame: takes a picture that is done, and begins the next one.
  void step();

  // The image: RGBA, kSizePx a side. It is empty until the first picture is there.
  [[nodiscard]] const std::vector<std::uint8_t>& rgba() const { return rgba_; }
  // Counts the changes of it.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }
  // Where the window has the image. Nothing: it has none, and find() has no pictures.
  std::optional<Place> area;

 private:
  struct Entry {
    std::optional<int> cell;
    bool failed = false;
    bool waits = true;        // to be made
    std::uint64_t asked = 0;  // the frame in which it was asked for last
    std::function<Result<ShelfPicture>()> make;  // kept: a key may name what it owns
  };

  [[nodiscard]] Entry* oldest_entry();
  [[nodiscard]] bool has_room();
  [[nodiscard]] std::optional<int> free_cell();
  void put(int cell, const ShelfPicture& picture);

  Start start_;
  std::map<std::string, Entry> entries_;
  std::vector<bool> used_;
  std::future<Result<ShelfPicture>> making_;  // valid: of making_key_
  std::string making_key_;
  std::vector<std::uint8_t> rgba_;
  std::uint64_t revision_ = 0;
  std::uint64_t frame_ = 1;
};

}  // namespace footlight::tools

#include "tools/footlight/preview/ui/picture_shelf.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "sim/core/no_signals.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kCells = std::size_t{PictureShelf::kSide} * PictureShelf::kSide;
constexpr std::size_t kEntriesMax = 4 * kCells;  // of which most have lost their place
constexpr std::size_t kPictureBytes = std::size_t{4} * kShelfPicturePx * kShelfPicturePx;

}  // namespace

PictureShelf::PictureShelf(Start start) : start_(std::move(start)), used_(kCells) {}

PictureShelf::Start PictureShelf::on_a_thread() {
  return [](std::function<Result<ShelfPicture>()> make) {
    const NoSignals no_signals;
    return std::async(std::launch::async, std::move(make));
  };
}

std::optional<PictureShelf::Place> PictureShelf::find(const std::string& key,
                                                      const std::function<Result<ShelfPicture>()>& make) {
  if (!area) return std::nullopt;
  Entry& entry = entries_[key];
  entry.asked = frame_;
  if (entry.failed) return std::nullopt;
  if (!entry.cell) {
    if (!entry.make) entry.make = make;
    entry.waits = making_key_ != key;
    return std::nullopt;
  }
  const float width = (area->right - area->left) / kSide;
  const float height = (area->bottom - area->top) / kSide;
  const float left = area->left + static_cast<float>(*entry.cell % kSide) * width;
  const int row = *entry.cell / kSide;
  const float top = area->top + static_cast<float>(row) * height;
  return Place{left, top, left + width, top + height};
}

void PictureShelf::step() {
  if (making_.valid() && making_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const Result<ShelfPicture> made = making_.get();
    Entry& entry = entries_[std::exchange(making_key_, {})];
    const bool good = made && made->rgba.size() == kPictureBytes;
    entry.failed = !good;
    if (const auto cell = good ? free_cell() : std::nullopt) {  // else it is asked for again in the next frame
      entry.cell = *cell;
      entry.waits = false;
      put(*cell, *made);
    }
  }
  if (!making_.valid() && has_room()) {  // else what is made would have no place, and be made again
    // Of those that are still wanted.
    const auto next = std::find_if(entries_.begin(), entries_.end(),
                                   [&](const auto& one) { return one.second.waits && one.second.asked == frame_; });
    if (next != entries_.end()) {
      making_key_ = next->first;
      next->second.waits = false;
      making_ = start_(next->second.make);
    }
  }
  if (entries_.size() > kEntriesMax) {
    std::erase_if(entries_, [&](const auto& one) {
      return !one.second.cell && one.second.asked != frame_ && one.first != making_key_;
    });
  }
  ++frame_;
}

// What was not shown for the longest time; null: all is shown.
PictureShelf::Entry* PictureShelf::oldest_entry() {
  Entry* oldest = nullptr;
  for (auto& [key, entry] : entries_) {
    if (entry.cell && entry.asked != frame_ && (oldest == nullptr || entry.asked < oldest->asked)) oldest = &entry;
  }
  return oldest;
}

bool PictureShelf::has_room() {
  return std::find(used_.begin(), used_.end(), false) != used_.end() || oldest_entry() != nullptr;
}

std::optional<int> PictureShelf::free_cell() {
  const auto free = std::find(used_.begin(), used_.end(), false);
  if (free != used_.end()) return static_cast<int>(free - used_.begin());
  Entry* oldest = oldest_entry();
  if (oldest == nullptr) return std::nullopt;
  return std::exchange(oldest->cell, std::nullopt);
}

void PictureShelf::put(int cell, const ShelfPicture& picture) {
  used_[static_cast<std::size_t>(cell)] = true;
  rgba_.resize(kPictureBytes * kCells);
  constexpr std::size_t kRowBytes = std::size_t{4} * kShelfPicturePx;
  for (std::size_t row = 0; row < kShelfPicturePx; ++row) {
    const std::size_t to = (static_cast<std::size_t>(cell / kSide) * kShelfPicturePx + row) * kRowBytes * kSide +
                           static_cast<std::size_t>(cell % kSide) * kRowBytes;
    std::copy_n(picture.rgba.begin() + static_cast<std::ptrdiff_t>(row * kRowBytes), kRowBytes,
                rgba_.begin() + static_cast<std::ptrdiff_t>(to));
  }
  ++revision_;
}

}  // namespace footlight::tools

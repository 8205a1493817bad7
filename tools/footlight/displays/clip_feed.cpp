#include "tools/footlight/displays/clip_feed.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "sim/core/no_signals.h"

namespace footlight::tools {

namespace {

std::uint64_t light_bytes(int columns, int rows) {
  return static_cast<std::uint64_t>(columns) * static_cast<std::uint64_t>(rows) * sizeof(glm::vec3);
}

}  // namespace

std::size_t pictures_ahead(int columns, int rows) {
  return static_cast<std::size_t>(
      std::clamp<std::uint64_t>(kClipBytesAhead / light_bytes(columns, rows), 2, kClipsAhead));
}

ClipFeed::ClipFeed(std::unique_ptr<Clip> clip, const fixtures::Display& display, ClipPace pace)
    : clip_(std::move(clip)),
      curve_(light_curve(display.video->gamma)),
      columns_(display.columns),
      rows_(display.rows),
      ahead_(pace == ClipPace::kAhead ? pictures_ahead(columns_, rows_) : 1),
      video_(*display.video),
      count_(clip_->count()),
      duration_ns_(clip_->duration_ns()) {}

Result<std::unique_ptr<ClipFeed>> ClipFeed::open(const fixtures::Display& display, ClipPace pace) {
  FL_ASSIGN(auto clip, Clip::open(display.video->path));
  std::unique_ptr<ClipFeed> feed(new ClipFeed(std::move(clip), display, pace));
  if (pace == ClipPace::kAhead) feed->start();
  return feed;
}

ClipFeed::~ClipFeed() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void ClipFeed::start() {
  const NoSignals no_signals;
  thread_ = std::thread([this] { work(); });
}

std::uint64_t ClipFeed::bytes_most() const { return (ahead_ + 1) * light_bytes(columns_, rows_); }

std::size_t ClipFeed::replaced() const {
  const std::lock_guard lock(mutex_);
  return replaced_;
}

Result<ClipLight> ClipFeed::make(std::size_t index) {
  FL_ASSIGN(const drivers::Picture* const picture, clip_->picture(index));
  return ClipLight{index, images_.light_of(*picture, curve_, columns_, rows_)};
}

Result<ClipLight> ClipFeed::at(DurationNs show_ns) { return at_clip(clip_time_ns(video_, show_ns, duration_ns_)); }

Result<ClipLight> ClipFeed::at_clip(DurationNs clip_ns) {
  const std::size_t index = clip_->index_at(clip_ns);
  if (!thread_.joinable()) {
    if (!last_.pixels || last_.index != index) {
      FL_ASSIGN(last_, make(index));
      replaced_ = clip_->replaced();
    }
    return last_;
  }
  const std::lock_guard lock(mutex_);
  if (error_) return tl::unexpected<Error>(*error_);
  wanted_ = index;
  auto shown = std::find_if(ready_.begin(), ready_.end(), [&](const ClipLight& one) { return one.index == index; });
  // If the picture is late, the newest one before it; none from ahead of a time that has jumped back.
  if (shown == ready_.end() && !ready_.empty() && ready_.back().index < index) shown = std::prev(ready_.end());
  if (shown != ready_.end()) {
    ready_.erase(ready_.begin(), shown);
    last_ = ready_.front();
  }
  wake_.notify_one();
  return last_;
}

// Called with the lock. nullopt: enough is ready.
std::optional<std::size_t> ClipFeed::next_to_make() const {
  if (!wanted_) return std::nullopt;
  const bool has_wanted =
      std::any_of(ready_.begin(), ready_.end(), [&](const ClipLight& one) { return one.index == *wanted_; });
  if (!has_wanted) return wanted_;
  if (ready_.size() >= std::min(ahead_, count_)) return std::nullopt;
  if (ready_.back().index + 1 < count_) return ready_.back().index + 1;
  return video_.loop ? std::optional<std::size_t>(0) : std::nullopt;
}

void ClipFeed::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return ends_ || next_to_make(); });
    if (ends_) return;
    const std::size_t index = *next_to_make();
    lock.unlock();
    auto made = make(index);
    const std::size_t replaced = clip_->replaced();
    lock.lock();
    if (!made) {
      error_ = made.error();
      return;
    }
    replaced_ = replaced;
    // What is not the next one after those that are ready comes of a jump of the time.
    const bool follows = !ready_.empty() && (ready_.back().index + 1) % count_ == index;
    if (!follows) ready_.clear();
    ready_.push_back(std::move(*made));
  }
}

}  // namespace footlight::tools

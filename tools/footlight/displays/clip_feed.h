// The light of a video on a display, for any time of the show.
//
// Exact: each call decodes what it needs. Ahead: a thread decodes pictures_ahead() before they are due, and calls never
// wait; if the picture is not ready, the newest one before it, or the last one, stays. While the time
// stands still, the picture of that time comes.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "fixtures/displays/display.h"
#include "tools/footlight/displays/clip.h"
#include "tools/footlight/displays/picture_light.h"

namespace footlight::tools {

inline constexpr std::size_t kClipsAhead = 4;
inline constexpr std::uint64_t kClipBytesAhead = std::uint64_t{160} << 20;  // of light
// With the one that is due, of a display with so many pixels: at most kClipsAhead and kClipBytesAhead, but two, so that
// the next one is decoded while one is shown.
[[nodiscard]] std::size_t pictures_ahead(int columns, int rows);

enum class ClipPace { kExact, kAhead };

struct ClipLight {
  std::size_t index = 0;  // of the picture in its file
  std::shared_ptr<const fixtures::PaneImage> pixels;
};

class ClipFeed {
 public:
  // Errors: those of Clip::open().
  [[nodiscard]] static Result<std::unique_ptr<ClipFeed>> open(const fixtures::Display& display, ClipPace pace);
  ~ClipFeed();
  ClipFeed(const ClipFeed&) = delete;
  ClipFeed& operator=(const ClipFeed&) = delete;

  // pixels is null before the first picture is ready; only with kAhead. One thread.
  [[nodiscard]] Result<ClipLight> at(DurationNs show_ns);
  // The same at a time of the file.
  [[nodiscard]] Result<ClipLight> at_clip(DurationNs clip_ns);
  [[nodiscard]] DurationNs duration_ns() const { return duration_ns_; }
  // Of light that this has at most: of pictures that are ready, and of one that is made, or whose memory waits for it.
  [[nodiscard]] std::uint64_t bytes_most() const;
  // Pictures so far that are damaged or missing, so that another one stands in their place.
  [[nodiscard]] std::size_t replaced() const;

 private:
  ClipFeed(std::unique_ptr<Clip> clip, const fixtures::Display& display, ClipPace pace);
  [[nodiscard]] Result<ClipLight> make(std::size_t index);
  void start();
  void work();
  [[nodiscard]] std::optional<std::size_t> next_to_make() const;

  // Of the thread, if there is one.
  std::unique_ptr<Clip> clip_;
  LightCurve256 curve_;
  LightImages images_;
  int columns_;
  int rows_;
  std::size_t ahead_;  // kExact: 1

  fixtures::DisplayVideo video_;
  std::size_t count_;  // of the clip
  DurationNs duration_ns_;
  ClipLight last_;  // given by at()

  // For both.
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<ClipLight> ready_;  // one after the other in the file
  std::optional<std::size_t> wanted_;
  std::size_t replaced_ = 0;
  std::optional<Error> error_;
  bool ends_ = false;
  std::thread thread_;  // joinable: kAhead
};

}  // namespace footlight::tools

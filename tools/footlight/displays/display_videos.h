// The videos of all displays of a rig, and what media servers show on them, for a frame.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "render/frame.h"
#include "tools/footlight/displays/clip_feed.h"
#include "tools/footlight/displays/media_pictures.h"

namespace footlight::tools {

class DisplayVideos {
 public:
  // Opens the videos. Displays that show the same one in the same way share it. Errors: those of Clip::open(), with the
  // name of the display.
  [[nodiscard]] static Result<DisplayVideos> open(const fixtures::Rig& rig, ClipPace pace);

  // Gives the frame, which is of the same rig, what the displays show at a time of the show. Times may go back. Error:
  // of the first video that cannot be decoded; it is closed, its displays keep their picture, and the others go on.
  Status show(DurationNs show_ns, render::Frame& frame);
  // The same for any taker: called once for each display whose pixels have changed since the last call.
  using GivePixels = footlight::tools::GivePixels;
  Status give_changes(DurationNs show_ns, const GivePixels& give);
  // The next show() gives everything again: for another frame of the same rig.
  void show_all_again();
  // One line for each video in which pictures were found damaged or missing since the last call; a video has one line.
  [[nodiscard]] std::vector<std::string> take_news();

 private:
  struct Feed {
    std::unique_ptr<ClipFeed> feed;
    std::string path;
    std::vector<std::size_t> displays;
    std::shared_ptr<const fixtures::PaneImage> shown;
    bool told = false;
  };
  std::vector<Feed> feeds_;
  MediaPictures media_;
};

// Whether both rigs have the same videos, in the same pixels, at the same displays.
[[nodiscard]] bool same_videos(const fixtures::Rig& a, const fixtures::Rig& b);

// Replaces the videos of displays by the picture of each at a time of the show, which then stands: for the judge.
[[nodiscard]] Status hold_videos(fixtures::Rig& rig, DurationNs show_ns);

}  // namespace footlight::tools

// Makes small pictures of a log with the frame of the stage, between its pictures (decision 0155).
//
//   if (thumbnails.is_due(now_ns, index, duration_ns, paused)) FL_TRY(thumbnails.begin(...));
//   FL_ASSIGN(const bool done, thumbnails.done());
//   if (done) FL_TRY(thumbnails.finish(now_ns, frame));
//
// A picture begins at a moment of the index: the states of the fixtures are put aside, those of the moment take their
// place for 20 ms of the log, and come back in finish(), to the bit. Until then nothing may step the frame. Its own
// images are small, everything else is that of the frame.
//
// Threads: one, the window's. Device and frame outlive it; drop_frame() before another frame.
#pragma once

#include <memory>
#include <optional>

#include "render/frame.h"
#include "tools/footlight/pictures/seek_index.h"
#include "tools/footlight/preview/stage_picture.h"
#include "tools/footlight/preview/ui/thumbnails.h"

namespace footlight::tools {

class LogThumbnails {
 public:
  // What pictures show.
  struct Scene {
    fixtures::Camera camera;
    double work_light_lx = 0;
  };

  [[nodiscard]] const Thumbnails& pictures() const { return pictures_; }
  // Whether a picture can be made, and enough time has passed since the last one: 16 times as long as it took, so that
  // they take at most 6 % of the time; 4 times, 20 %, while the log is paused.
  [[nodiscard]] bool is_due(TimeNs now_ns, const SeekIndex* index, DurationNs duration_ns, bool paused) const;
  // How long the last one took, until it was seen to be done; 0: there was none.
  [[nodiscard]] DurationNs took_ns() const { return took_ns_; }
  // Begins one; in_flight() unless there is no moment for it.
  Status begin(TimeNs now_ns, render::vk::Device& device, render::Frame& frame, const SeekIndex& index,
               DurationNs duration_ns, const Scene& scene);
  [[nodiscard]] bool in_flight() const { return picture_ && picture_->in_flight(); }
  [[nodiscard]] Result<bool> done(std::uint64_t patience_ns = 0) { return picture_->done(patience_ns); }
  Status finish(TimeNs now_ns, render::Frame& frame);
  // Before the frame is replaced, or its settings change. None may be in flight, but on a lost device.
  void drop_frame();
  // Those of a rig from before.
  void clear();

 private:
  Thumbnails pictures_;
  std::unique_ptr<render::Frame> small_;  // beside the frame
  std::unique_ptr<StagePicture> picture_;  // destroyed before what its commands use
  render::FrameState shown_;               // of the frame, while one is in flight
  TimeNs at_ns_ = 0;                       // of the log, of the one in flight
  TimeNs begun_ns_ = 0;
  TimeNs ended_ns_ = 0;
  DurationNs took_ns_ = 0;
};

}  // namespace footlight::tools

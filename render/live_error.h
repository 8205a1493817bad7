// The error of a picture while it is shown: a few of its pixels once more by the general path, on the GPU.
//
// A pass of its own behind the frame's, with its pipeline and twice 6 KiB of memory; who does not make one has none of
// it. It shares with the frame the beams' rows, what a pixel shows, and the formulas of one beam and one ray. It shares
// no mask, no tile, no polynomial and no table (render/shaders/recheck.comp). So it does not see errors of what a pixel
// shows: levels of bodies, and resolution. It has no judge in double either: what the general path itself leaves is in
// docs/numerics.md.
//
//   FL_ASSIGN(auto live, LiveError::create(device, frame, needs));
//   frame.record(commands, view, ev);
//   if (live) live->record(commands);
//   ... when these commands are finished:
//   if (live) live->take(now_ns);
//   live->estimate().rel_l2
//
// Frame::change() ends it: make another one.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>

#include "render/frame.h"
#include "sim/core/clock.h"

namespace footlight::render {

// The error of pictures from samples of the last second. Sums of squares of all samples, bright ones drawn more often
// and counted less; the interval is that of their ratio by its linearised residuals, as in reference/pixel_sample.h,
// without the strata: somewhat wide.
class ErrorWindow {
 public:
  static constexpr DurationNs kWindowNs = kNsPerS;
  static constexpr std::size_t kPicturesMax = 1024;

  struct Estimate {
    double rel_l2 = 0;
    double low = 0;  // of the 95 % interval
    double high = 0;
    std::size_t samples = 0;  // 0: there is none yet
  };

  // samples_min: where a second has fewer, those of pictures before it count as well.
  explicit ErrorWindow(std::size_t samples_min = 0) : samples_min_(samples_min) {}

  // The samples of one picture.
  void add(TimeNs now_ns, std::span<const RecheckRow> rows);
  // Of the pictures within kWindowNs before the last one, and of earlier ones as above.
  [[nodiscard]] Estimate estimate() const;

 private:
  struct Sample {
    double error = 0;   // weighted, squared
    double square = 0;  // of the reference
  };
  struct Picture {
    TimeNs at_ns;
    std::vector<Sample> samples;
  };
  std::deque<Picture> pictures_;
  std::size_t samples_ = 0;  // of all of them
  std::size_t samples_min_;
};

class LiveError {
 public:
  // needs: of the rig. Null where there is nothing to measure: no beams and no surfaces; and where floors mirror, which
  // the general path does not.
  [[nodiscard]] static Result<std::unique_ptr<LiveError>> create(vk::Device& device, Frame& frame,
                                                                 const fixtures::Needs& needs);
  // Begins to compile what create() needs for a frame of these settings, as Frame::compile_ahead() does.
  static void compile_ahead(vk::Device& device, const FrameSettings& settings, const fixtures::Needs& needs);
  ~LiveError();
  LiveError(const LiveError&) = delete;
  LiveError& operator=(const LiveError&) = delete;

  // After Frame::record() into the same commands. Each call draws other pixels, in a fixed order.
  void record(VkCommandBuffer commands);
  // Adds the samples of the last record(), whose commands are finished.
  Status take(TimeNs now_ns);
  [[nodiscard]] ErrorWindow::Estimate estimate() const { return window_.estimate(); }
  // The samples of the last take().
  [[nodiscard]] std::span<const RecheckRow> rows() const;
  // GPU time of the last take(); 0 on a device without time stamps.
  [[nodiscard]] double gpu_ms() const { return gpu_ms_; }

 private:
  explicit LiveError(vk::Device& device) : device_(device) {}
  static Result<std::shared_ptr<const vk::Pipeline>> begin_pipeline(vk::Device& device, const FrameSettings& settings,
                                                                    const fixtures::Needs& needs);

  vk::Device& device_;
  std::shared_ptr<const vk::Pipeline> pipeline_;
  vk::Buffer rechecked_, read_;  // on the GPU, and where the host reads
  vk::BindingSet set_;
  VkQueryPool times_ = VK_NULL_HANDLE;
  std::uint32_t cells_ = 0;  // of each record()
  std::uint32_t seed_ = 0;
  double gpu_ms_ = 0;
  ErrorWindow window_{256};
};

}  // namespace footlight::render

// Error and time of each knob on this machine, measured on generated scenes and kept in a file from run to run.
//
// The file is text, is replaced as a whole, and has a checksum. One that is damaged, or of another device, driver or
// program, is ignored, and the curves are measured again.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "render/frame.h"
#include "render/quality.h"
#include "tools/footlight/report/report_scenes.h"

namespace footlight::tools {

// A scene on which knobs are measured one after the other.
class KnobBench {
 public:
  // settings: size, bodies and so on; its knobs do not matter. The scene must outlive it.
  [[nodiscard]] static Result<KnobBench> make(render::vk::Device& device, const Scene& scene,
                                              const render::FrameSettings& settings);
  // Relative L2 error of all pixels against the same frame with general_settings().
  [[nodiscard]] Result<double> error_of(const render::Knobs& knobs);
  // Least GPU time of `runs` frames; by the clock where the device has no time stamps. The divisor counts. The least,
  // because other programs can only make it longer.
  [[nodiscard]] Result<double> ms_of(const render::Knobs& knobs, int runs);

 private:
  KnobBench(const Scene& scene, const render::FrameSettings& settings);
  Status draw();

  render::FrameSettings settings_;
  render::View view_;
  double exposure_ev_;
  std::unique_ptr<render::Frame> frame_;
  render::RadianceImage general_;
};

struct KnobCurveOptions {
  int width = 1920;
  int height = 1080;
  int beams = 1000;        // of the scene without gobos
  int gobo_divisor = 2;    // pixels a side of one of the scene with gobos, which takes the longest
  int gobo_beams = 64;     // of that scene
  int whole_width = 1920;  // of whole pictures of the demo
  int whole_height = 1080;
  int runs = 5;  // timed frames of each knob, taken in turn; 2 or more, since the first compiles
  // Optional. Called before each knob; false ends the measurement with an error.
  std::function<bool(double done, double all)> go_on;
};
// What takes a CPU seconds, and a GPU no longer.
[[nodiscard]] KnobCurveOptions suited_curve_options(const render::vk::Device& device);

[[nodiscard]] Result<render::KnobCurves> measure_knob_curves(render::vk::Device& device,
                                                             const KnobCurveOptions& options);

// The version of this program and a checksum of its shaders, whose errors and times these are.
[[nodiscard]] std::string curves_program();

// In `folder`, named by the device's UUID and the driver's version.
[[nodiscard]] std::string knob_curves_path(const std::string& folder, const render::vk::DeviceFacts& facts);
// What write_knob_curves() was given; nothing where the file is missing, damaged, or of another driver or program.
[[nodiscard]] std::optional<render::KnobCurves> read_knob_curves(const std::string& path,
                                                                 const render::vk::DeviceFacts& facts,
                                                                 std::string_view program);
Status write_knob_curves(const std::string& path, const render::vk::DeviceFacts& facts, std::string_view program,
                         const render::KnobCurves& curves);

// From the file in `folder`, or else measured and written there; an empty folder: measured. A file that cannot be
// written is no error. `on_measure` is called before measuring starts.
[[nodiscard]] Result<render::KnobCurves> machine_knob_curves(render::vk::Device& device, const std::string& folder,
                                                             const KnobCurveOptions& options,
                                                             const std::function<void()>& on_measure);

}  // namespace footlight::tools

// Which settings a picture gets for an error or a time that is asked for: curves and a request in, knobs out. No GPU,
// no clock, no file. Curves are measured by tools/footlight/pictures/knob_curves.h; docs/decisions/0106.
//
// The error is the relative L2 error of the light of a picture against the same picture by the general path
// (general_settings()). It is that of the knobs: what the general path itself leaves against the judge is in
// docs/numerics.md. Bodies are off by pixels and not by light, so their knob follows from the error that is asked for
// (body_error_for()).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "render/settings.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::render {

// The settings that trade error for time.
struct Knobs {
  double tile_error = FrameSettings{}.tile_error;
  std::uint32_t nodes = FrameSettings{}.nodes;
  GoboMethod gobo_method = FrameSettings{}.gobo_method;
  std::uint32_t gobo_taps = FrameSettings{}.gobo_taps;
  double body_error_px = FrameSettings{}.body_error_px;
  // False: left out, whatever the settings ask for; true: as they ask.
  bool smooth_edges = true;
  bool bounce = true;  // with what shiny things mirror of it
  bool shadows = true;
  int divisor = 1;  // pixels of the window a side of one that is computed; the caller sets the size of the frame
  bool operator==(const Knobs&) const = default;
};
[[nodiscard]] Knobs knobs_of(const FrameSettings& settings);
[[nodiscard]] FrameSettings with_knobs(FrameSettings settings, const Knobs& knobs);
// Every beam pixel by pixel with 8 nodes and 1024 samples of gobos, and whole models: no tiles, no tables.
[[nodiscard]] FrameSettings general_settings(FrameSettings settings);
// "tile error 0.004, 3 nodes, gobo tables, bodies 0.5 px", with "half resolution" and so on.
[[nodiscard]] std::string text_of(const Knobs& knobs);
// One JSON object: what a replay needs for an equal picture. error: that was asked for; 0: none.
[[nodiscard]] std::string json_of(const FrameSettings& settings, std::string_view version, double error);

// One of the two is above 0; neither where nothing was asked for.
struct QualityRequest {
  double error = 0;  // share: 0.001 is 0.1 %
  double ms = 0;     // of GPU time of a frame
  [[nodiscard]] bool any() const { return error > 0 || ms > 0; }
};
// 0.001 of "0.1%" or "0.001"; nothing if it is no finite number.
[[nodiscard]] std::optional<double> share_of(std::string_view text);
// error: "0.1%" or "0.001"; ms: "8"; empty: not given. kBadInput names the option and what is expected.
[[nodiscard]] Result<QualityRequest> parse_quality(const std::string& error, const std::string& ms);

struct KnobPoint {
  Knobs knobs;
  double error = 0;
  double ms = 0;
};

// Groups of knobs, each measured with the others as they are by default (times) or at their best (errors).
struct KnobCurves {
  std::vector<KnobPoint> beams;   // tile_error and nodes
  std::vector<KnobPoint> gobos;   // gobo_method and gobo_taps
  std::vector<KnobPoint> bodies;  // body_error_px; only their times count
  // What a whole picture leaves out, in this order, with the cheapest of the others; nothing first. Only times count.
  std::vector<KnobPoint> left_out;
};

// Pixels that bodies may be off beside an error of the light: half a pixel, below 1e-3 a quarter, below 3e-4 none.
[[nodiscard]] double body_error_for(double error);

// What a picture leaves out by and by where the cheapest knobs are still too slow: each of these and all before it. In
// the order of what is lost (docs/decisions/0198-what-a-slow-machine-leaves-out.md), but edges before bounce, which
// takes a tenth of their time on a CPU.
[[nodiscard]] std::span<const Knobs> left_out_knobs();
// The same knobs, of which just that is left out, and the resolution lowered, that `leaves` says.
[[nodiscard]] Knobs without(Knobs knobs, const Knobs& leaves);
// With nothing left out and every pixel.
[[nodiscard]] Knobs with_everything(Knobs knobs);

// Every setting that is worth its time for such a rig: from the least error to the least time, each at least a tenth
// cheaper than the one before. Bodies are those for the error that is asked for, without one the default. Errors of
// groups add as squares, times as they are. Behind the cheapest of these come plainer bodies, and last what is left out
// of whole pictures: the error there is still that of the beams that are computed. Empty without points of beams.
[[nodiscard]] std::vector<KnobPoint> ladder_of(const KnobCurves& curves, const fixtures::Needs& needs,
                                               const QualityRequest& request = {});

// The place in the ladder for a request. An error: the cheapest that leaves nothing out, with the bodies that the
// ladder begins with, that keeps it, or else the first. A time: the first that takes at most so long when each takes
// `scale` times its ms, or else the last. The ladder is not empty.
[[nodiscard]] std::size_t choose(std::span<const KnobPoint> ladder, const QualityRequest& request, double scale = 1);
// The place that is nearest in time, of those that leave nothing out. The ladder is not empty.
[[nodiscard]] std::size_t nearest(std::span<const KnobPoint> ladder, double ms);
// What the curves say of these knobs, as a place of a ladder; nothing where they were not measured. kSuited is what the
// curves have: tables, or else samples.
[[nodiscard]] std::optional<KnobPoint> predicted(const KnobCurves& curves, const fixtures::Needs& needs, Knobs knobs);

// The knobs that `footlight render` takes for an error: a table, so that no measurement of time changes a picture. With
// the error that was measured for them. kBadInput below the least error in the table.
[[nodiscard]] Result<KnobPoint> fixed_knobs(double error);
[[nodiscard]] std::span<const KnobPoint> fixed_table();

// The first pictures of a window whose device is the CPU, for about half a second: `whole` without what can be left out
// for that long. All that they leave out is here. They have the tables of whole ones, and step the fixtures alike.
// - Fewer pixels, so that pixels x beams stay below some 10 million.
// - No smooth edges: 0.2 s a picture, and two pipelines.
// - No reflected light: how much each part of the scene reflects to each other one takes 0.15 s.
// - With more than kRoughBeamsMax beams no shadows, and one node of light in the air: these take most of the time of
//   2,000 beams, and what is compiled for them alone takes less. With fewer beams whole pictures share their pipelines.
// beams: CompiledRig::beams_max.
inline constexpr std::uint32_t kRoughBeamsMax = 500;
[[nodiscard]] FrameSettings rough_settings(const FrameSettings& whole, std::uint32_t beams);

// Moves along a ladder so that a picture takes at most budget_ms, with hysteresis. Its clock is the times it is given:
// equal ones give equal knobs.
//
// The median of the last pictures with the present knobs decides, without the first two, which may have compiled
// pipelines. Above the budget for a quarter of a second: cheaper knobs, as the ladder predicts them. Better ones only
// where they are predicted to take 3/4 of the budget, and after a pause, which doubles each time that better knobs had
// to be taken back soon.
class TimeKeeper {
 public:
  static constexpr DurationNs kSettleNs = 250 * kNsPerMs;
  static constexpr DurationNs kPauseNs = 2 * kNsPerS;
  static constexpr DurationNs kPauseMaxNs = 64 * kNsPerS;
  static constexpr DurationNs kRegretNs = 5 * kNsPerS;  // taken back sooner: the pause doubles
  static constexpr std::size_t kPicturesMax = 15;       // that the median is of
  static constexpr std::size_t kPicturesMin = 3;

  // ladder: not empty.
  TimeKeeper(std::vector<KnobPoint> ladder, double budget_ms, std::size_t start);

  // A picture with the present knobs was finished at now_ns and took gpu_ms. True: the knobs have changed.
  bool take(TimeNs now_ns, double gpu_ms);
  [[nodiscard]] const KnobPoint& point() const { return ladder_[at_]; }
  [[nodiscard]] std::size_t at() const { return at_; }
  // Median of the last pictures; 0: there were too few.
  [[nodiscard]] double ms() const;

 private:
  bool move(std::size_t to, TimeNs now_ns);

  std::vector<KnobPoint> ladder_;
  double budget_ms_;
  std::size_t at_;
  std::vector<double> recent_ms_;  // at most kPicturesMax
  std::size_t pictures_ = 0;       // with the present knobs
  std::optional<TimeNs> since_ns_;
  std::optional<TimeNs> raised_ns_;  // when better knobs were taken
  DurationNs pause_ns_ = kPauseNs;
};

}  // namespace footlight::render

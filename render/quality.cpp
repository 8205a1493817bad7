#include "render/quality.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "render/display.h"
#include "sim/core/check.h"

namespace footlight::render {
namespace {

constexpr double kStep = 0.9;       // each place of a ladder takes at most this share of the time before
constexpr double kAfterDown = 0.9;  // of the budget: what knobs are predicted to take that are chosen
constexpr double kAfterUp = 0.75;
constexpr double kOver = 1.05;         // of the budget: more than that is above it
constexpr std::size_t kFirstOnes = 2;  // pictures after a change that do not count

const char* word_of(TriangleMethod method) {
  switch (method) {
    case TriangleMethod::kRasteriser: return "rasteriser";
    case TriangleMethod::kCompute: return "compute";
    case TriangleMethod::kTwoRounds: return "two rounds";
    case TriangleMethod::kSuited: break;
  }
  return "suited";
}

const char* word_of(GoboMethod method) {
  switch (method) {
    case GoboMethod::kMidpoints: return "midpoints";
    case GoboMethod::kTaps: return "taps";
    case GoboMethod::kTables: return "tables";
    case GoboMethod::kSuited: break;
  }
  return "suited";
}

// The whole text is a number, with `unit` behind it or not.
std::optional<double> number_of(std::string_view text, char unit, bool& has_unit) {
  has_unit = text.ends_with(unit);
  if (has_unit) text.remove_suffix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// `points` plus each of `more`, whose knobs `take` copies.
template <class Take>
std::vector<KnobPoint> combined(const std::vector<KnobPoint>& points, const std::vector<KnobPoint>& more, Take take) {
  if (more.empty()) return points;
  double least_ms = std::numeric_limits<double>::infinity();
  for (const KnobPoint& one : more) least_ms = std::min(least_ms, one.ms);
  std::vector<KnobPoint> all;
  all.reserve(points.size() * more.size());
  for (const KnobPoint& point : points) {
    for (const KnobPoint& one : more) {
      KnobPoint both{point.knobs, std::hypot(point.error, one.error), point.ms + one.ms - least_ms};
      take(both.knobs, one.knobs);
      all.push_back(both);
    }
  }
  return all;
}

}  // namespace

Knobs knobs_of(const FrameSettings& settings) {
  return {.tile_error = settings.tile_error,
          .nodes = settings.nodes,
          .gobo_method = settings.gobo_method,
          .gobo_taps = settings.gobo_taps,
          .body_error_px = settings.body_error_px};
}

FrameSettings with_knobs(FrameSettings settings, const Knobs& knobs) {
  settings.method = BeamMethod::kGauss;
  settings.tile_error = knobs.tile_error;
  settings.nodes = knobs.nodes;
  settings.gobo_method = knobs.gobo_method;
  settings.gobo_taps = knobs.gobo_taps;
  settings.body_error_px = knobs.body_error_px;
  if (!knobs.smooth_edges) settings.edge_samples = 0;
  settings.bounce = settings.bounce && knobs.bounce;
  settings.probes = settings.probes && knobs.bounce;
  settings.shadows = settings.shadows && knobs.shadows;
  return settings;
}

FrameSettings general_settings(FrameSettings settings) {
  return with_knobs(
      settings, {.tile_error = 0, .nodes = 8, .gobo_method = GoboMethod::kTaps, .gobo_taps = 1024, .body_error_px = 0});
}

std::string text_of(const Knobs& knobs) {
  std::string text = fmt::format("tile error {:g}, {} nodes, ", knobs.tile_error, knobs.nodes);
  if (knobs.gobo_method == GoboMethod::kTaps || knobs.gobo_method == GoboMethod::kMidpoints) {
    text += fmt::format("{} gobo {}", knobs.gobo_taps, word_of(knobs.gobo_method));
  } else {
    text += knobs.gobo_method == GoboMethod::kTables ? "gobo tables" : "gobos as suit the device";
  }
  text += fmt::format(", bodies {:g} px", knobs.body_error_px);
  if (!knobs.smooth_edges) text += ", jagged edges";
  if (!knobs.bounce) text += ", no reflected light";
  if (!knobs.shadows) text += ", no shadows";
  if (knobs.divisor > 1) text += fmt::format(", 1/{} of the resolution", knobs.divisor);
  return text;
}

std::string json_of(const FrameSettings& settings, std::string_view version, double error) {
  return fmt::format(
      R"({{"footlight":"{}","error":{},"width":{},"height":{},"supersample":{},"method":"{}","nodes":{},)"
      R"("tile_error":{},"tile_beams":{},"gobo_method":"{}","gobo_taps":{},"gobo_gates":{},"gobo_px":{},)"
      R"("body_error_px":{},"triangles":"{}",)"
      R"("edge_samples":{},"glare":{},"bodies":{},"haze":{},"shadows":{},"shadow_map_px":{},"penumbra":{},"bounce":{},)"
      R"("dark_lm":{},"widen_thin":{},)"
      R"("white_balance_k":{},"tone":"{}","auto_exposure":{}}})",
      version, error, settings.width, settings.height, settings.supersample,
      settings.method == BeamMethod::kGauss ? "gauss" : "march", settings.nodes, settings.tile_error,
      settings.tile_beams, word_of(settings.gobo_method), settings.gobo_taps, settings.gobo_gates, settings.gobo_px,
      settings.body_error_px, word_of(settings.triangles), settings.edge_samples, settings.glare, settings.bodies,
      settings.haze, settings.shadows, settings.shadow_map_px, settings.penumbra, settings.bounce, settings.dark_lm,
      settings.widen_thin, settings.white_k, word_of(settings.tone), settings.auto_exposure);
}

std::optional<double> share_of(std::string_view text) {
  bool percent = false;
  const std::optional<double> value = number_of(text, '%', percent);
  return value && percent ? *value * 0.01 : value;
}

Result<QualityRequest> parse_quality(const std::string& error, const std::string& ms) {
  QualityRequest request;
  if (!error.empty() && !ms.empty()) {
    return fail(ErrorCode::kBadInput, "--error {} and --ms {}: each chooses all knobs; leave out one of them", error,
                ms);
  }
  if (!error.empty()) {
    request.error = share_of(error).value_or(0);
    if (!(request.error > 0 && request.error < 1)) {
      return fail(ErrorCode::kBadInput, "--error {}: expected a share of the light above 0 and below 100%, as in 0.1%",
                  error);
    }
  }
  if (!ms.empty()) {
    bool unit = false;
    request.ms = number_of(ms, '\0', unit).value_or(0);
    if (!(request.ms > 0 && request.ms <= 60'000)) {
      return fail(ErrorCode::kBadInput, "--ms {}: expected milliseconds of GPU time a picture, above 0, as in 8", ms);
    }
  }
  return request;
}

double body_error_for(double error) { return error < 3e-4 ? 0 : error < 1e-3 ? 0.25 : 0.5; }

namespace {

// Time of bodies above that of the plainest.
double body_ms(const KnobCurves& curves, const fixtures::Needs& needs, double error_px) {
  double least_ms = std::numeric_limits<double>::infinity();
  double own_ms = least_ms;
  for (const KnobPoint& one : curves.bodies) {
    least_ms = std::min(least_ms, one.ms);
    if (one.knobs.body_error_px == error_px) own_ms = one.ms;
  }
  return needs.fixtures && std::isfinite(own_ms) ? own_ms - least_ms : 0;
}

// Every combination of the groups that matter for such a rig, with these bodies.
std::vector<KnobPoint> combinations(const KnobCurves& curves, const fixtures::Needs& needs, double body_error_px) {
  std::vector<KnobPoint> all = curves.beams;
  if (needs.gobo && needs.haze) {
    all = combined(all, curves.gobos, [](Knobs& knobs, const Knobs& own) {
      knobs.gobo_method = own.gobo_method;
      knobs.gobo_taps = own.gobo_taps;
    });
  }
  for (KnobPoint& point : all) {
    point.knobs.body_error_px = body_error_px;
    point.ms += body_ms(curves, needs, body_error_px);
  }
  return all;
}

}  // namespace

Knobs without(Knobs knobs, const Knobs& leaves) {
  knobs.smooth_edges = leaves.smooth_edges;
  knobs.bounce = leaves.bounce;
  knobs.shadows = leaves.shadows;
  knobs.divisor = leaves.divisor;
  return knobs;
}

Knobs with_everything(Knobs knobs) { return without(knobs, {}); }

std::span<const Knobs> left_out_knobs() {
  static constexpr Knobs kLeftOut[] = {
      {.smooth_edges = false},
      {.smooth_edges = false, .bounce = false},
      {.smooth_edges = false, .bounce = false, .shadows = false},
      {.smooth_edges = false, .bounce = false, .shadows = false, .divisor = 2},
      {.smooth_edges = false, .bounce = false, .shadows = false, .divisor = 4},
  };
  return kLeftOut;
}

std::optional<KnobPoint> predicted(const KnobCurves& curves, const fixtures::Needs& needs, Knobs knobs) {
  if (!needs.gobo || !needs.haze) {  // groups that are left out keep what they are by default
    knobs.gobo_method = Knobs{}.gobo_method;
    knobs.gobo_taps = Knobs{}.gobo_taps;
  } else if (knobs.gobo_method == GoboMethod::kSuited) {
    const bool has_tables = std::any_of(curves.gobos.begin(), curves.gobos.end(), [](const KnobPoint& one) {
      return one.knobs.gobo_method == GoboMethod::kTables;
    });
    knobs.gobo_method = has_tables ? GoboMethod::kTables : GoboMethod::kTaps;
  }
  knobs = with_everything(knobs);
  for (const KnobPoint& point : combinations(curves, needs, knobs.body_error_px)) {
    if (point.knobs == knobs) return point;
  }
  return std::nullopt;
}

std::vector<KnobPoint> ladder_of(const KnobCurves& curves, const fixtures::Needs& needs,
                                 const QualityRequest& request) {
  const double body_error_px = request.error > 0 ? body_error_for(request.error) : Knobs{}.body_error_px;
  std::vector<KnobPoint> all = combinations(curves, needs, body_error_px);
  std::stable_sort(all.begin(), all.end(), [](const KnobPoint& a, const KnobPoint& b) {
    return a.error != b.error ? a.error < b.error : a.ms < b.ms;
  });
  std::vector<KnobPoint> ladder;
  for (const KnobPoint& point : all) {
    if (ladder.empty() || point.ms <= kStep * ladder.back().ms) ladder.push_back(point);
  }
  if (ladder.empty()) return ladder;
  const auto push_cheaper = [&](const KnobPoint& point) {
    if (point.ms <= kStep * ladder.back().ms) ladder.push_back(point);
  };
  const KnobPoint light = ladder.back();
  for (const KnobPoint& bodies : curves.bodies) {
    KnobPoint point = light;
    point.knobs.body_error_px = bodies.knobs.body_error_px;
    point.ms += body_ms(curves, needs, bodies.knobs.body_error_px) - body_ms(curves, needs, light.knobs.body_error_px);
    if (bodies.knobs.body_error_px > light.knobs.body_error_px) push_cheaper(point);
  }
  const KnobPoint cheapest = ladder.back();
  for (const KnobPoint& one : curves.left_out) {
    KnobPoint point = cheapest;
    point.knobs = without(point.knobs, one.knobs);
    point.ms *= one.ms / curves.left_out.front().ms;
    if (one.knobs != curves.left_out.front().knobs) push_cheaper(point);
  }
  return ladder;
}

std::size_t choose(std::span<const KnobPoint> ladder, const QualityRequest& request, double scale) {
  FL_CHECK(!ladder.empty());
  if (request.error > 0) {
    std::size_t chosen = 0;
    for (std::size_t i = 0; i < ladder.size(); ++i) {
      const Knobs& knobs = ladder[i].knobs;
      if (knobs != with_everything(knobs) || knobs.body_error_px != ladder.front().knobs.body_error_px) break;
      if (ladder[i].error <= request.error) chosen = i;
    }
    return chosen;
  }
  for (std::size_t i = 0; i < ladder.size(); ++i) {
    if (ladder[i].ms * scale <= request.ms) return i;
  }
  return ladder.size() - 1;
}

std::size_t nearest(std::span<const KnobPoint> ladder, double ms) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < ladder.size() && ladder[i].knobs == with_everything(ladder[i].knobs); ++i) {
    if (std::abs(ladder[i].ms - ms) < std::abs(ladder[best].ms - ms)) best = i;
  }
  return best;
}

namespace {

constexpr KnobPoint fixed_row(double error, double tile_error, std::uint32_t nodes, std::uint32_t gobo_taps,
                              double body_error_px) {
  return {{.tile_error = tile_error,
           .nodes = nodes,
           .gobo_method = GoboMethod::kTaps,
           .gobo_taps = gobo_taps,
           .body_error_px = body_error_px},
          error,
          0};
}

// docs/numerics.md, "Knobs for an error", with the command that measures a row.
constexpr KnobPoint kFixed[] = {
    fixed_row(1e-4, 0, 8, 1024, 0),       // the general path
    fixed_row(5e-4, 1e-3, 4, 256, 0.25),  //
    fixed_row(3e-3, 4e-3, 3, 128, 0.5),   // the defaults, with samples of gobos on every device
    fixed_row(1.5e-2, 4e-3, 3, 64, 0.5),  //
    fixed_row(5e-2, 2e-2, 2, 32, 0.5),    //
    fixed_row(1e-1, 2e-2, 2, 16, 0.5),    //
};

}  // namespace

std::span<const KnobPoint> fixed_table() { return kFixed; }

Result<KnobPoint> fixed_knobs(double error) {
  const KnobPoint* chosen = nullptr;
  for (const KnobPoint& row : kFixed) {
    if (row.error <= error) chosen = &row;
  }
  if (chosen != nullptr) return *chosen;
  return fail(ErrorCode::kBadInput, "--error {:g}%: expected {:g}% or more, the least error of the table", 100 * error,
              100 * kFixed[0].error);
}

FrameSettings rough_settings(const FrameSettings& whole, std::uint32_t beams) {
  constexpr double kPixelsTimesBeams = 10e6;  // less than a second of software on two cores
  FrameSettings rough = whole;
  const double work = static_cast<double>(whole.width) * whole.height * beams;
  const int divisor = static_cast<int>(std::clamp(std::ceil(std::sqrt(work / kPixelsTimesBeams)), 2.0, 6.0));
  rough.width = std::max(whole.width / divisor, 1);
  rough.height = std::max(whole.height / divisor, 1);
  rough.edge_samples = 0;
  rough.bounce = false;
  rough.probes = false;
  if (beams > kRoughBeamsMax) {
    rough.shadows = false;
    rough.nodes = 1;
  }
  return rough;
}

TimeKeeper::TimeKeeper(std::vector<KnobPoint> ladder, double budget_ms, std::size_t start)
    : ladder_(std::move(ladder)), budget_ms_(budget_ms), at_(start) {
  FL_CHECK(start < ladder_.size());
}

double TimeKeeper::ms() const { return recent_ms_.size() < kPicturesMin ? 0 : median_of(recent_ms_); }

bool TimeKeeper::move(std::size_t to, TimeNs now_ns) {
  if (to == at_) return false;
  if (to < at_) {
    raised_ns_ = now_ns;
  } else if (raised_ns_) {
    const bool regrets = now_ns - *raised_ns_ < kRegretNs;
    pause_ns_ = regrets ? std::min(2 * pause_ns_, kPauseMaxNs) : kPauseNs;
    raised_ns_.reset();
  }
  at_ = to;
  recent_ms_.clear();
  pictures_ = 0;
  since_ns_ = now_ns;
  return true;
}

bool TimeKeeper::take(TimeNs now_ns, double gpu_ms) {
  if (!since_ns_) since_ns_ = now_ns;
  if (++pictures_ <= kFirstOnes) return false;
  if (recent_ms_.size() == kPicturesMax) recent_ms_.erase(recent_ms_.begin());
  recent_ms_.push_back(gpu_ms);
  const DurationNs for_ns = now_ns - *since_ns_;
  if (recent_ms_.size() < kPicturesMin || for_ns < kSettleNs) return false;
  const double median_ms = median_of(recent_ms_);
  const auto fits = [&](std::size_t i, double share) {
    return ladder_[i].ms / ladder_[at_].ms * median_ms <= share * budget_ms_;
  };
  if (median_ms > kOver * budget_ms_) {
    std::size_t to = at_;
    while (to + 1 < ladder_.size() && (to == at_ || !fits(to, kAfterDown))) ++to;
    return move(to, now_ns);
  }
  if (for_ns < pause_ns_) return false;
  for (std::size_t to = 0; to < at_; ++to) {
    if (fits(to, kAfterUp)) return move(to, now_ns);
  }
  return false;
}

}  // namespace footlight::render

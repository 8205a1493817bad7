#include "tools/footlight/vrsl/video_log.h"

#include <algorithm>

#include "drivers/vrsl/vrsl_options.h"

namespace footlight::tools {
namespace {

class GridVideoLog final : public VideoLog {
 public:
  GridVideoLog(std::string path, std::unique_ptr<VideoReader> video, const drivers::VrslOptions& options)
      : path_(std::move(path)), video_(std::move(video)), reader_(options) {}

  [[nodiscard]] LogFormat format() const override { return LogFormat::kVideo; }
  [[nodiscard]] const std::string& path() const override { return path_; }
  [[nodiscard]] TimeNs end_ns() const override { return end_ns_; }
  [[nodiscard]] std::uint64_t damage_count() const override {
    return video_->counters().damaged + (video_->counters().cut_off ? 1 : 0);
  }
  [[nodiscard]] std::vector<std::string> notes() const override;
  Result<bool> next(FrameView& frame) override;
  [[nodiscard]] VideoLogReport report() const override {
    return {video_->facts(), video_->counters(), reader_.counters(), grid_.empty() ? std::nullopt : reader_.codec(),
            universes_,      other_grids_,       reader_.refusal(),  longest_gap_ns_};
  }

 private:
  Result<bool> read_picture();

  std::string path_;
  std::unique_ptr<VideoReader> video_;
  drivers::VrslReader reader_;
  drivers::Picture picture_;
  std::array<UniverseConfidence, drivers::kGridUniversesMax> universes_;
  int next_universe_ = 0;  // of this picture, from 1; 0: none is left
  TimeNs stamp_ns_ = 0;
  TimeNs end_ns_ = 0;
  std::string grid_;  // of the first picture that was used
  std::uint64_t other_grids_ = 0;
  DurationNs longest_gap_ns_ = 0;
};

Result<bool> GridVideoLog::read_picture() {
  while (true) {
    std::optional<DurationNs> time_ns;
    FL_ASSIGN(const drivers::PictureStep step, video_->next(picture_, time_ns, 0));
    if (step == drivers::PictureStep::kEnd) return false;
    if (step == drivers::PictureStep::kNothing) continue;
    const TimeNs before_ns = stamp_ns_;
    stamp_ns_ = std::max<TimeNs>(time_ns.value_or(0), 0);
    if (video_->counters().pictures > 1) longest_gap_ns_ = std::max(longest_gap_ns_, stamp_ns_ - before_ns);
    end_ns_ = std::max(end_ns_, stamp_ns_);
    if (!reader_.read(picture_.view())) continue;
    const std::string grid = drivers::text_of(*reader_.codec());
    if (grid_.empty()) grid_ = grid;
    if (grid != grid_) ++other_grids_;
    next_universe_ = 1;
    return true;
  }
}

Result<bool> GridVideoLog::next(FrameView& frame) {
  while (true) {
    if (next_universe_ == 0) {
      FL_ASSIGN(const bool more, read_picture());
      if (!more && !grid_.empty()) return false;
      if (!more) {
        return fail(ErrorCode::kBadInput, "{}: no grid in its {} pictures{}{}", path_, video_->counters().pictures,
                    reader_.refusal().empty() ? "" : ": ", reader_.refusal());
      }
    }
    const int universe = next_universe_;
    next_universe_ = universe < reader_.codec()->universe_count() ? universe + 1 : 0;
    const auto at = static_cast<std::size_t>(universe - 1);
    const int slots = reader_.codec()->slot_count(universe);
    if (slots == 0) continue;
    const double confidence = reader_.reading().confidence[at];
    UniverseConfidence& known = universes_[at];
    known.lowest = std::min(known.lowest, confidence);
    ++known.frames;
    known.mean += (confidence - known.mean) / static_cast<double>(known.frames);
    if (confidence < drivers::kGridConfidenceMin) {
      ++known.left_out;
      continue;
    }
    frame = {};
    frame.universe = universe;
    frame.stamp_ns = stamp_ns_;
    frame.sender = 1;
    frame.slots = reader_.levels().subspan(at * kSlotCountMax, static_cast<std::size_t>(slots));
    return true;
  }
}

std::vector<std::string> GridVideoLog::notes() const {
  std::vector<std::string> notes;
  if (!grid_.empty()) notes.push_back("the grid is " + grid_);
  for (const std::string& open : reader_.open()) notes.push_back(open);
  for (std::size_t i = 0; i < universes_.size(); ++i) {
    const UniverseConfidence& known = universes_[i];
    if (known.frames == 0) continue;
    notes.push_back(fmt::format("universe {}: confidence {:.2f} in the mean, {:.2f} at least; {} of {} frames left out",
                                i + 1, known.mean, known.lowest, known.left_out, known.frames));
  }
  const drivers::VrslReaderCounters& read = reader_.counters();
  if (read.no_grid > 0) {
    notes.push_back(fmt::format("{} pictures without a grid were left out: {}", read.no_grid, reader_.refusal()));
  }
  if (read.damaged > 0) notes.push_back(fmt::format("{} pictures with a wrong check row were left out", read.damaged));
  if (read.lost > 0) notes.push_back(fmt::format("{} pictures are missing by their check rows", read.lost));
  if (other_grids_ > 0)
    notes.push_back(fmt::format("{} pictures have their grid in another place or form", other_grids_));
  const VideoCounters& video = video_->counters();
  if (video.damaged > 0) {
    notes.push_back(fmt::format("{} pictures were damaged, or build on one that was; left out", video.damaged));
  }
  if (video.cut_off) notes.emplace_back("the video ends early: it was cut off or is damaged");
  return notes;
}

}  // namespace

Result<std::unique_ptr<VideoLog>> open_video_log(const std::string& path, const std::string& format,
                                                 const std::string& option) {
  FL_ASSIGN(const Endpoint endpoint, parse_endpoint("vrsl:1@video" + (format.empty() ? "" : "?" + format), {}));
  FL_ASSIGN(drivers::VrslOptions options, drivers::vrsl_in_options(endpoint));
  if (!options.target.options.empty()) {
    return fail(ErrorCode::kBadInput, "{} {}: \"{}\" is not an option of the grid", option, format,
                options.target.options.front().key);
  }
  options.universes.clear();  // each universe has its own confidence here
  FL_ASSIGN(auto video, VideoReader::open(path));
  return std::unique_ptr<VideoLog>(std::make_unique<GridVideoLog>(path, std::move(video), options));
}

}  // namespace footlight::tools

// Moments and other logs that the preview compares its levels with.
#include <algorithm>
#include <chrono>
#include <future>
#include <utility>

#include "sim/core/no_signals.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/sound/sound_log.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {

// Opens the panel that shows the comparison.
void Preview::compare_from_here() {
  keep_this_moment();
  if (desk_->comparison().a) (void)panels_.open_words("universes", *desk_);
}

void Preview::keep_this_moment() {
  if (desk_->compiled().universes.empty()) return;
  const std::optional<TimeNs> log_ns = player_ ? controls_.transport.levels_ns() : std::nullopt;
  desk_->comparison() = {keep_levels(desk_->compiled().universes, panel_levels(), log_ns), std::nullopt};
}

// Another log at the time of the one that plays; without one it plays from when it is read. A thread reads it: captures
// and sounds are converted first, and armed outputs go on.
Status Preview::compare_with(const std::string& path) {
  const std::vector<Universe>& own = edited_->scene()->own_universes;
  if (own.empty()) {
    return fail(ErrorCode::kBadInput, "{}: no fixture of the rig has an address, so there is nothing to compare", path);
  }
  if (reading_compared_.valid()) {
    return fail(ErrorCode::kBadInput, "{}: {} is still being read", path, compared_path_);
  }
  compared_path_ = path;
  const NoSignals no_signals;
  reading_compared_ = std::async(std::launch::async, [this, path] {
    return read_level_log(path, {}, [this] { return closed_.load(); });
  });
  return {};
}

// Waits for it.
Status Preview::take_compared_log() {
  FL_ASSIGN(LogReader reader, reading_compared_.get());
  const std::vector<Universe> own = logged_universes(*edited_->scene());
  FL_ASSIGN(ComparedLog log, ComparedLog::open(std::move(reader), compared_path_, own));
  compared_ = std::make_unique<ComparedLog>(std::move(log));
  compared_watch_.reset();
  compared_since_ns_ = last_ns_;
  const LogInfo& info = compared_->info();
  const bool shares = std::any_of(info.universes.begin(), info.universes.end(), [&](const LogUniverseInfo& one) {
    return std::binary_search(own.begin(), own.end(), one.universe);
  });
  if (!shares) tell(trf("{} has none of the universes of the rig: {}", compared_->name(), show_universes(own)), true);
  if (!info.recovered()) {
    compared_watch_.emplace(compared_->again());
  } else {
    tell(trf("{} is damaged or was cut; `footlight log info` says where", compared_->name()), true);
  }
  KeptLevels kept;
  kept.log = compared_->name();
  kept.number = next_kept_number();
  desk_->comparison() = {std::move(kept), std::nullopt};
  if (both_.on() || options_.compare_stage != "off") return {};  // it would be over the stage
  return panels_.open_words("universes", *desk_);
}

// Of the log that plays; without one since the comparison began.
TimeNs Preview::compared_time_ns() const {
  return player_ ? controls_.transport.now_ns : last_ns_ - compared_since_ns_;
}

// Until the user ends the comparison, or compares with something else.
void Preview::follow_compared_log() {
  if (reading_compared_.valid() && reading_compared_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    if (const Status taken = take_compared_log(); !taken) tell(taken.error());
  }
  if (!compared_) return;
  tell_damage(compared_watch_);
  std::optional<KeptLevels>& kept = desk_->comparison().a;
  if (!kept || kept->log.empty()) return compared_.reset();
  if (player_ && player_->seeking()) return;  // the levels are those from before
  Status read;
  if (const auto own = logged_universes(*edited_->scene()); compared_->moment().universes != own) {
    read = compared_->set_universes(own);
  }
  const TimeNs now_ns = compared_time_ns();
  const TimeNs at_ns = std::clamp<TimeNs>(now_ns + kept->offset_ns, 0, compared_->duration_ns());
  if (read) read = compared_->go_to(at_ns);
  if (read) {
    kept->moment = compared_->moment();
    kept->when = at_ns == now_ns + kept->offset_ns ? time_text(at_ns)
                 : at_ns == 0                      ? std::string(tr("before its start"))
                                                   : trf("{}, its end", time_text(at_ns));
    return;
  }
  tell(read.error());
  desk_->comparison() = {};
  compared_.reset();
}

}  // namespace footlight::tools

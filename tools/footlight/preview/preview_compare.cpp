// Moments and other logs that the preview compares its levels with.
#include <algorithm>
#include <utility>

#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {

// Opens the panel that shows the comparison.
void Preview::compare_from_here() {
  if (desk_->compiled().universes.empty()) return;
  const std::optional<TimeNs> log_ns = player_ ? controls_.transport.levels_ns() : std::nullopt;
  desk_->comparison() = {keep_levels(desk_->compiled().universes, panel_levels(), log_ns), std::nullopt};
  (void)panels_.open_words("universes", *desk_);
}

// Another log at the time of the one that plays; without one it plays from now on.
Status Preview::compare_with(const std::string& path) {
  const std::vector<Universe>& own = edited_->scene()->own_universes;
  if (own.empty()) {
    return fail(ErrorCode::kBadInput, "{}: no fixture of the rig has an address, so there is nothing to compare", path);
  }
  FL_ASSIGN(ComparedLog log, ComparedLog::open(path, desk_->compiled().universes));
  compared_ = std::make_unique<ComparedLog>(std::move(log));
  compared_since_ns_ = last_ns_;
  const LogInfo& info = compared_->info();
  const bool shares = std::any_of(info.universes.begin(), info.universes.end(), [&](const LogUniverseInfo& one) {
    return std::binary_search(own.begin(), own.end(), one.universe);
  });
  if (!shares) tell(trf("{} has none of the universes of the rig: {}", compared_->name(), show_universes(own)), true);
  if (info.recovered()) {
    tell(trf("{} is damaged or was cut; `footlight log info` says where", compared_->name()), true);
  }
  KeptLevels kept;
  kept.log = compared_->name();
  desk_->comparison() = {std::move(kept), std::nullopt};
  return panels_.open_words("universes", *desk_);
}

// Until the user ends the comparison, or compares with something else.
void Preview::follow_compared_log() {
  if (!compared_) return;
  std::optional<KeptLevels>& kept = desk_->comparison().a;
  if (!kept || kept->log.empty()) return compared_.reset();
  if (player_ && player_->seeking()) return;  // the levels are those from before
  Status read;
  if (compared_->moment().universes != desk_->compiled().universes) {
    read = compared_->set_universes(desk_->compiled().universes);
  }
  const TimeNs now_ns = player_ ? controls_.transport.now_ns : last_ns_ - compared_since_ns_;
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

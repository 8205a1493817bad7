// A recording of what the fixtures get: its key, its mark and its end.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "sim/core/no_signals.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

Status Preview::start_recording(const std::string& path) {
  if (ended_.valid()) {
    return fail(ErrorCode::kBadInput,
                "the recording before is still being written; try again when its end is reported");
  }
  const std::int64_t unix_ns = wall_clock_unix_ns();
  const std::string file = path.empty() ? recording_path(options_.recordings, options_.files.rig, unix_ns) : path;
  FL_ASSIGN(recording_, Recording::start(file, framed_->compiled.universes, clock_, unix_ns));
  recorded_.clear();
  tell(trf("recording to {}; Ctrl+R ends it", file));
  return {};
}

void Preview::toggle_recording() {
  if (recording_) return end_recording();
  if (const Status started = start_recording(""); !started) tell(started.error());
}

// On another thread: a slow disk must not keep levels from armed outputs.
void Preview::end_recording() {
  if (!recording_) return;
  ended_path_ = recording_->path();
  const NoSignals no_signals;
  ended_ = std::async(std::launch::async, [ends = std::move(recording_)] { return ends->end(); });
}

// What the end of a recording reports, once it is on the disk.
void Preview::report_recording(bool waits) {
  using std::chrono::seconds;
  if (!ended_.valid() || (!waits && ended_.wait_for(seconds(0)) != std::future_status::ready)) return;
  const auto done = ended_.get();
  const std::string& news = done ? *done : done.error().message;
  if (!options_.json || !done) std::fputs(("footlight: " + news + "\n").c_str(), stderr);
  tell(tr_known(news), !done);
  recording_failed_ = recording_failed_ || !done;
  if (done && !waits) offer_recording();
}

// The file is among the recent logs, too.
void Preview::offer_recording() {
  std::error_code trouble;
  recorded_ = std::filesystem::absolute(ended_path_, trouble).lexically_normal().string();
  settings_.add_recent_log(recorded_);
  desk_->list_recent(settings_.recent_rigs, settings_.recent_logs);
}

// Until the user answers, or records again.
void Preview::draw_recorded_line() {
  if (recorded_.empty() || lost_) return;
  const auto answer = draw_recorded(std::filesystem::path(recorded_).filename().string(), window_->ui_scale());
  if (!answer) return;
  const std::string path = std::exchange(recorded_, {});
  if (*answer == RecordedAnswer::kPlay) ask_to_open({"", path, false, saved_as_});
}

// After the steps of a turn.
void Preview::keep_recording() {
  if (!recording_) return;
  // The steps of a log are also those of seeks: it is recorded as pictures show it.
  if (player_) recording_->take(last_ns_, desk_->compiled().universes, panel_levels());
  if (!recording_->trouble().empty()) end_recording();
}

}  // namespace footlight::tools

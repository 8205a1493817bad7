// What the window of the preview remembers from session to session.
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "tools/footlight/paths.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

// Before the window opens. Options hold for this session; what is changed in the window is saved.
Status Preview::open_settings() {
  settings_path_ = window_settings_path(state_folder());
  if (auto settings = load_window_settings(settings_path_)) {
    settings_ = std::move(*settings);
  } else {
    fmt::print(stderr, "footlight: the window's settings are not saved: {}\n", settings.error().message);
    settings_path_.clear();
  }
  saved_settings_ = settings_;
  if (!options_.theme.empty()) {
    FL_ASSIGN(settings_.theme, theme_of(options_.theme));
  }
  settings_.views = options_.views.value_or(settings_.views);
  settings_.ui_percent = options_.ui_percent.value_or(settings_.ui_percent);
  return {};
}

// The rig and the log that were opened are the newest of the recent ones.
void Preview::note_recent() {
  const auto whole = [](const std::string& path) {
    std::error_code trouble;
    const std::filesystem::path absolute = std::filesystem::absolute(path, trouble);
    return path.empty() || trouble ? std::string() : absolute.lexically_normal().string();
  };
  if (const std::string rig = whole(options_.files.rig); !rig.empty()) settings_.add_recent(rig);
  if (const std::string log = whole(options_.files.log); !log.empty()) settings_.add_recent_log(log);
  desk_->list_recent(settings_.recent_rigs, settings_.recent_logs);
  if (!options_.news.empty()) tell(options_.news, true);
}

void Preview::show_look() {
  window_->set_ui_look(static_cast<float>(settings_.ui_percent) / 100, settings_.theme);
  shown_settings_ = settings_;
}

// Once between two pictures. A failure is told once for each change.
void Preview::follow_settings() {
  WindowSettings kept = saved_settings_;
  if (settings_.theme != shown_settings_.theme) kept.theme = settings_.theme;
  if (settings_.ui_percent != shown_settings_.ui_percent) kept.ui_percent = settings_.ui_percent;
  if (settings_.views != shown_settings_.views) kept.views = settings_.views;
  kept.recent_rigs = settings_.recent_rigs;
  kept.recent_logs = settings_.recent_logs;
  if (settings_ != shown_settings_) show_look();
  if (settings_path_.empty() || kept == saved_settings_) return;
  saved_settings_ = std::move(kept);
  if (const Status saved = save_window_settings(settings_path_, saved_settings_); !saved) {
    tell(trf("the window's settings are not saved: {}", tr_known(saved.error().message)), true);
  }
}

}  // namespace footlight::tools

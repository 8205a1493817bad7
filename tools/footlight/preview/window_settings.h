// What the window remembers from session to session: its looks, and the rigs that were opened. Kept in
// $XDG_STATE_HOME/footlight/window.toml. Knows no window.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/core/result.h"

namespace footlight::tools {

enum class UiTheme { kDark, kLight };
[[nodiscard]] constexpr const char* word_of(UiTheme theme) { return theme == UiTheme::kDark ? "dark" : "light"; }
// Of --theme: "dark" or "light".
[[nodiscard]] Result<UiTheme> theme_of(std::string_view word);

inline constexpr int kUiPercentMin = 75;
inline constexpr int kUiPercentMax = 300;
// The next step up (1) or down (-1): 75, 100, 125, 150, 200, 250, 300.
[[nodiscard]] int next_ui_percent(int percent, int direction);

// The size of the user interface, 1 to 4 in quarters, for a window on a screen of so many pixels in height of which no
// desktop says how large it is: 1 up to 1440, 3 at 4320. The window then still has a height of 480 units.
[[nodiscard]] float ui_scale_for(int screen_height_px, int window_height_px);

struct WindowSettings {
  static constexpr std::size_t kRecentMax = 10;
  UiTheme theme = UiTheme::kDark;
  int ui_percent = 100;                  // of the size that suits the screen
  int views = 1;                         // of the stage: 1, 2 or 4
  std::vector<std::string> recent_rigs;  // absolute paths, the newest first
  std::vector<std::string> recent_logs;  // the same
  bool operator==(const WindowSettings&) const = default;
  // Puts a rig, or a log, in front of the others.
  void add_recent(const std::string& path) { put_first(recent_rigs, path); }
  void add_recent_log(const std::string& path) { put_first(recent_logs, path); }

 private:
  static void put_first(std::vector<std::string>& paths, const std::string& path);
};

// In the folder of paths.h state_folder(); empty: there is none.
[[nodiscard]] std::string window_settings_path(const std::string& state_folder);
[[nodiscard]] std::string text_of(const WindowSettings& settings);
[[nodiscard]] Result<WindowSettings> parse_window_settings(std::string_view text, const std::string& path);
// A file that does not exist gives the defaults.
[[nodiscard]] Result<WindowSettings> load_window_settings(const std::string& path);
// Makes the folder, if it is not there.
[[nodiscard]] Status save_window_settings(const std::string& path, const WindowSettings& settings);

}  // namespace footlight::tools

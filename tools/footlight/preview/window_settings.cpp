#include "tools/footlight/preview/window_settings.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/archive.h"
#include "fixtures/files/toml/toml_reader.h"
#include "fixtures/files/toml/toml_text.h"
#include "tools/footlight/preview/preview.h"
#include "tools/footlight/preview/ui/stage_views.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kSettingsBytesMax = 1u << 20;
constexpr std::array kPercents{75, 100, 125, 150, 200, 250, 300};

}  // namespace

Result<UiTheme> theme_of(std::string_view word) {
  if (word == "dark") return UiTheme::kDark;
  if (word == "light") return UiTheme::kLight;
  return fail(ErrorCode::kBadInput, "theme '{}': expected dark or light", word);
}

int next_ui_percent(int percent, int direction) {
  int less = kUiPercentMin;
  for (const int one : kPercents) {
    if (direction > 0 && one > percent) return one;
    if (one < percent) less = one;
  }
  return direction > 0 ? kUiPercentMax : less;
}

float ui_scale_for(int screen_height_px, int window_height_px) {
  constexpr int kScreenPx = 1440;  // of scale 1
  constexpr int kWindowPx = 480;   // likewise, at least
  const int quarters = std::min(4 * screen_height_px / kScreenPx, 4 * window_height_px / kWindowPx);
  return static_cast<float>(std::clamp(quarters, 4, 16)) / 4;
}

void WindowSettings::put_first(std::vector<std::string>& paths, const std::string& path) {
  std::erase(paths, path);
  paths.insert(paths.begin(), path);
  if (paths.size() > kRecentMax) paths.resize(kRecentMax);
}

std::string window_settings_path(const std::string& state_folder) {
  return state_folder.empty() ? std::string() : state_folder + "/window.toml";
}

std::string text_of(const WindowSettings& settings) {
  std::string text = fmt::format("# Settings of the window of 'footlight preview'.\ntheme = \"{}\"\nui_percent = {}\n"
                                 "views = {}\n",
                                 word_of(settings.theme), settings.ui_percent, settings.views);
  for (const auto& [name, paths] :
       {std::pair("recent_rigs", &settings.recent_rigs), std::pair("recent_logs", &settings.recent_logs)}) {
    if (paths->empty()) continue;  // an empty list is an error of a file
    text += fmt::format("{} = [\n", name);
    for (const std::string& path : *paths) text += fmt::format("  {},\n", fixtures::toml_text(path));
    text += "]\n";
  }
  return text;
}

Result<WindowSettings> parse_window_settings(std::string_view text, const std::string& path) {
  FL_ASSIGN(const fixtures::TomlNode root, fixtures::parse_toml(std::string(text), path));
  fixtures::TomlReader reader(root, path, "");
  WindowSettings settings;
  const std::string theme = reader.text("theme", word_of(settings.theme));
  settings.ui_percent =
      static_cast<int>(reader.integer("ui_percent", kUiPercentMin, kUiPercentMax, settings.ui_percent));
  settings.views = static_cast<int>(reader.integer("views", 1, kViewsMax, settings.views));
  for (const auto& [name, paths] :
       {std::pair("recent_rigs", &settings.recent_rigs), std::pair("recent_logs", &settings.recent_logs)}) {
    if (!reader.has(name)) continue;
    for (auto& [path_of_one, at] : reader.texts(name)) paths->push_back(std::move(path_of_one));
    if (paths->size() > WindowSettings::kRecentMax) paths->resize(WindowSettings::kRecentMax);
  }
  FL_TRY(reader.finish());
  if (auto known = theme_of(theme)) {
    settings.theme = *known;
  } else {
    return fail(ErrorCode::kBadInput, "{}:{}: {}", path, reader.place_of("theme"), known.error().message);
  }
  if (!is_view_count(settings.views)) {
    return fail(ErrorCode::kBadInput, "{}:{}: views {}: expected 1, 2 or 4", path, reader.place_of("views"),
                settings.views);
  }
  return settings;
}

Result<WindowSettings> load_window_settings(const std::string& path) {
  if (path.empty()) return WindowSettings{};
  const auto bytes = fixtures::read_whole_file(path, kSettingsBytesMax);
  if (!bytes && bytes.error().code == ErrorCode::kNotFound) return WindowSettings{};
  if (!bytes) return tl::unexpected<Error>(bytes.error());
  return parse_window_settings(fixtures::text_of(*bytes), path);
}

Status save_window_settings(const std::string& path, const WindowSettings& settings) {
  if (path.empty()) return {};
  std::error_code trouble;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), trouble);
  return fixtures::write_file(path, text_of(settings));
}

void keep_look(PreviewOptions& options, const WindowSettings& settings) {
  if (!options.theme.empty()) options.theme = word_of(settings.theme);
  if (options.ui_percent) options.ui_percent = settings.ui_percent;
  if (options.views) options.views = settings.views;
}

}  // namespace footlight::tools

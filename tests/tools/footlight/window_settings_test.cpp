// What the window remembers, and what files that are dropped on it are.
#include "tools/footlight/preview/window_settings.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include "fixtures/files/export/rig_toml.h"
#include "fixtures/files/import/import_rig.h"
#include "sim/dmx_log/dmx_log.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/dropped_file.h"
#include "tools/footlight/preview/next_window.h"
#include "tools/footlight/preview/preview.h"

namespace footlight::tools {
namespace {

using footlight::testing::TempFolder;

TEST_CASE("settings are read as they were written, in a folder that is made, and the newest files are the first") {
  const TempFolder folder;
  const std::string path = window_settings_path(folder.file("state"));
  CHECK(*load_window_settings(path) == WindowSettings{});
  WindowSettings settings;
  REQUIRE(save_window_settings(path, settings));  // before any rig was opened
  CHECK(load_window_settings(path) == settings);
  settings.theme = UiTheme::kLight;
  settings.ui_percent = 150;
  settings.views = 4;
  for (int i = 0; i < 14; ++i) settings.add_recent("/shows/a \"" + std::to_string(i) + "\".toml");
  settings.add_recent("/shows/a \"9\".toml");
  CHECK(settings.recent_rigs.size() == WindowSettings::kRecentMax);
  CHECK(settings.recent_rigs[0] == "/shows/a \"9\".toml");
  CHECK(settings.recent_rigs[1] == "/shows/a \"13\".toml");
  CHECK(std::count(settings.recent_rigs.begin(), settings.recent_rigs.end(), settings.recent_rigs[0]) == 1);
  settings.add_recent_log("/shows/monday.dmxlog");
  settings.add_recent_log("/shows/tuesday.dmxlog");
  settings.add_recent_log("/shows/monday.dmxlog");
  CHECK(settings.recent_logs == std::vector<std::string>{"/shows/monday.dmxlog", "/shows/tuesday.dmxlog"});
  REQUIRE(save_window_settings(path, settings));
  const auto again = load_window_settings(path);
  REQUIRE_MESSAGE(again, again.error().message);
  CHECK(*again == settings);
  CHECK(window_settings_path("").empty());
  CHECK(save_window_settings("", settings));
}

TEST_CASE("the next window looks as the user left the one before, where options set it") {
  WindowSettings settings;
  settings.theme = UiTheme::kLight;
  settings.ui_percent = 150;
  settings.views = 2;
  PreviewOptions options;
  keep_look(options, settings);
  CHECK(options.theme.empty());
  CHECK(!options.ui_percent);
  CHECK(!options.views);
  options.theme = "dark";
  options.ui_percent = 200;
  options.views = 4;
  keep_look(options, settings);
  CHECK(options.theme == "light");
  CHECK(options.ui_percent == 150);
  CHECK(options.views == 2);
}

TEST_CASE("lost edits are recovered in a window of the same rig, log and inputs, another rig leaves the log") {
  PreviewOptions before;
  before.files.rig = "club.toml";
  before.files.log = "monday.dmxlog";
  before.ins = {"osc:9000"};
  before.camera = "stalls";
  before.camera_words.focus_m = 5;
  before.hold_to_live = true;
  const PreviewOptions again = options_for(before, {"", "", true});
  CHECK(again.recover);
  CHECK(again.files.rig == "club.toml");
  CHECK(again.files.log == "monday.dmxlog");
  CHECK(again.ins == before.ins);
  CHECK(again.camera == "stalls");
  CHECK(again.camera_words.focus_m == 5);
  const PreviewOptions other = options_for(before, {"tour.mvr", ""});
  CHECK(!other.recover);
  CHECK(other.files.rig == "tour.mvr");
  CHECK(other.files.log.empty());
  CHECK(other.camera.empty());
  CHECK(!other.camera_words.focus_m);  // a distance in the rig from before
  CHECK(other.hold_to_live);
  before.ins.push_back("sacn:1");
  const PreviewOptions both = options_for(before, {"tour.mvr", "tour.dmxlog"});
  CHECK(both.files.rig == "tour.mvr");
  CHECK(both.files.log == "tour.dmxlog");
  CHECK(both.ins == std::vector<std::string>{"osc:9000"});
  const PreviewOptions with_log = options_for(before, {"", "tuesday.dmxlog"});
  CHECK(with_log.files.rig == "club.toml");
  CHECK(with_log.files.log == "tuesday.dmxlog");
  CHECK(with_log.ins == std::vector<std::string>{"osc:9000"});
}

TEST_CASE("settings that are wrong name the line and what is expected") {
  const auto trouble = [](const char* text) {
    const auto settings = parse_window_settings(text, "window.toml");
    REQUIRE(!settings);
    return settings.error().message;
  };
  CHECK(trouble("theme = \"pink\"").find("theme 'pink': expected dark or light") != std::string::npos);
  CHECK(trouble("ui_percent = 500").find("300") != std::string::npos);
  CHECK(trouble("theme = \"dark\"\nviews = 3").find("views 3: expected 1, 2 or 4") != std::string::npos);
  CHECK(!parse_window_settings("theme =", "window.toml"));
  CHECK(parse_window_settings("", "window.toml"));
}

TEST_CASE("on a screen that states no size text grows with its pixels, as far as the window has room for it") {
  CHECK(ui_scale_for(768, 768) == 1);
  CHECK(ui_scale_for(1080, 1080) == 1);
  CHECK(ui_scale_for(1440, 1440) == 1);
  CHECK(ui_scale_for(2160, 2160) == 1.5f);
  CHECK(ui_scale_for(2880, 2880) == 2);
  CHECK(ui_scale_for(4320, 4320) == 3);
  CHECK(ui_scale_for(20'000, 20'000) == 4);
  CHECK(ui_scale_for(4320, 720) == 1.5f);  // panels of a small window keep their room
  CHECK(ui_scale_for(4320, 360) == 1);
  CHECK(ui_scale_for(0, 720) == 1);
}

TEST_CASE("sizes go up and down in steps and stop at 75 and 300 per cent") {
  int percent = 75;
  for (const int next : {100, 125, 150, 200, 250, 300, 300}) CHECK((percent = next_ui_percent(percent, 1)) == next);
  for (const int next : {250, 200, 150, 125, 100, 75, 75}) CHECK((percent = next_ui_percent(percent, -1)) == next);
  CHECK(next_ui_percent(110, 1) == 125);
  CHECK(next_ui_percent(110, -1) == 100);
}

TEST_CASE("a rig and a log that are dropped together open both, of several the last one, and the others are named") {
  const TempFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder.file(name), std::ios::binary) << text;
    return folder.file(name);
  };
  const std::string rig = write("rig.toml", testing::kUiRig);
  const std::string log = write("show.osf", "OLA Show\n1 0\n");
  const std::string par = FOOTLIGHT_SOURCE_DIR "/fixtures/builtin/par.toml";
  DroppedFiles dropped = sort_dropped({log, par, rig});
  CHECK(dropped.rig == rig);
  CHECK(dropped.log == log);
  CHECK(dropped.definitions == std::vector<std::string>{par});
  CHECK(dropped.refused.empty());
  const std::string second = write("second.toml", testing::kUiRig);
  dropped = sort_dropped({rig, write("notes.txt", "nothing of that"), second});
  CHECK(dropped.rig == second);
  CHECK(dropped.log.empty());
  REQUIRE(dropped.refused.size() == 2);
  CHECK(dropped.refused[0].message.find("notes.txt") != std::string::npos);
  CHECK(dropped.refused[1].message == rig + ": is not opened, since " + second + " was dropped with it");
}

TEST_CASE("a dropped file is a definition, a rig or a log by its content, and others are refused with their name") {
  const TempFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder.file(name), std::ios::binary) << text;
    return folder.file(name);
  };
  CHECK(kind_of_dropped(write("rig.toml", testing::kUiRig)) == DroppedKind::kRig);
  CHECK(kind_of_dropped(FOOTLIGHT_SOURCE_DIR "/fixtures/builtin/par.toml") == DroppedKind::kDefinition);
  CHECK(kind_of_dropped(write("show.mvr", "PK\x03\x04")) == DroppedKind::kRig);
  CHECK(kind_of_dropped(write("head.gdtf", "PK\x03\x04")) == DroppedKind::kDefinition);
  CHECK(kind_of_dropped(write("show.osf", "OLA Show\n1 0\n")) == DroppedKind::kLog);
  const auto other = kind_of_dropped(write("notes.txt", "nothing of that"));
  REQUIRE(!other);
  CHECK(other.error().message.find("notes.txt: is no definition") != std::string::npos);
  CHECK(!kind_of_dropped(folder.file("missing.mvr")));
}

}  // namespace
}  // namespace footlight::tools

// The window as users see it. Runs under Xvfb if that and a Vulkan device are installed; else it is skipped with a
// message.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/headless_vulkan.h"
#include "tests/tools/footlight/display.h"
#include "tests/tools/footlight/one_par.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string read(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// True if a window can be opened here; else prints why not.
bool can_open_window() {
  const HeadlessVulkan vulkan;  // the same device, with the validation layer
  if (!vulkan) return false;
  const bool has_display = std::system("command -v xvfb-run > /dev/null") == 0;  // NOLINT: a fixed command
  if (!has_display) MESSAGE("skipped: needs xvfb-run; 'sudo apt-get install xvfb xauth'");
  return has_display;
}

// Runs the preview on a separate display with the validation layer; returns the exit code. The check for leaks is off,
// because drivers that the Vulkan loader has closed leak some memory (tests/support/headless_vulkan.cpp).
// dpi: of the screen, as a desktop states it; 0: it states none.
int preview(const TempFolder& folder, const std::string& arguments, const std::string& variables = "", int dpi = 0) {
  const std::string desktop =
      dpi > 0 ? "xprop -root -f RESOURCE_MANAGER 8s -set RESOURCE_MANAGER 'Xft.dpi: " + std::to_string(dpi) + "' && "
              : "";
  std::ofstream(folder.file("start.sh")) << desktop << "exec " FOOTLIGHT_BINARY " preview " << arguments << "\n";
  const std::string line =
      variables +
      "FOOTLIGHT_VALIDATION=1 ASAN_OPTIONS=detect_leaks=0 xvfb-run -a -s '-screen 0 1024x768x24 -noreset' sh " +
      folder.file("start.sh") + " > " + folder.file("out") + " 2> " + folder.file("err");
  const int status = std::system(line.c_str());  // arguments of this test only
  INFO(read(folder.file("err")));
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// The last line of standard output.
nlohmann::json summary(const TempFolder& folder) {
  const std::string out = read(folder.file("out"));
  REQUIRE(out.size() > 2);
  const std::size_t before = out.rfind('\n', out.size() - 2);
  return nlohmann::json::parse(out.substr(before == std::string::npos ? 0 : before + 1));
}

TEST_CASE("without a display the preview fails with a message that names footlight render") {
  const Outcome outcome = Footlight({"preview", "--demo"}, {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}}).wait();
  CHECK(outcome.exit_code == 1);
  CHECK((contains(outcome.err, "no window") || contains(outcome.err, "libglfw3-dev")));
  CHECK(contains(outcome.err, "footlight render"));
}

TEST_CASE("a log and a live input at once are refused before a window opens") {
  const Outcome outcome = footlight({"preview", "--demo", "--log", "a.dmxlog", "--in", "sacn:1"});
  if (contains(outcome.err, "libglfw3-dev")) return;  // a build without a window
  CHECK(outcome.exit_code == 2);
  CHECK(contains(outcome.err, "--log and --in"));
}

TEST_CASE("an output that cannot be one is refused before a window opens") {
  const Outcome outcome = footlight({"preview", "--demo", "--output", "gpio:mock/2=1.25"});
  if (contains(outcome.err, "libglfw3-dev")) return;  // a build without a window
  CHECK(outcome.exit_code == 2);
  CHECK(contains(outcome.err, "gpio:mock/2=1.25: this is an input"));
}

TEST_CASE("the demo opens, draws, saves a picture and closes without a message from the validation layer") {
  if (!can_open_window()) return;
  const TempFolder folder;
  const int code =
      preview(folder, "--demo --at 12s --seconds 1 --size 320x180 --json --output log:" + folder.file("sent.dmxlog") +
                          " --panels devices --screenshot " + folder.file("a.png"));
  const std::string err = read(folder.file("err"));
  if (contains(err, "libglfw3-dev")) return;
  INFO(err);
  REQUIRE(code == 0);
  CHECK(err.empty());
  CHECK(!std::filesystem::exists(folder.file("sent.dmxlog")));  // an output that was not armed
  const nlohmann::json line = summary(folder);
  CHECK(line["event"] == "summary");
  CHECK(line["validation_messages"] == 0);
  CHECK(line["frames"].get<int>() >= 1);
  // Panels turn while the software renderer draws a picture of the stage.
  CHECK(line["ui_frames"].get<int>() > 2 * line["frames"].get<int>());
  CHECK(line["ui_frame_ms_p99"].get<double>() >= line["ui_frame_ms_p50"].get<double>());
  CHECK(line["live"].get<int>() > 0);
  CHECK(line["shadows"].get<int>() > 0);
  CHECK(line["shadows_lost"] == 0);
  CHECK(line["width"] == 320);
  // A window this narrow begins without the panel, so the error is not measured.
  CHECK(!line.contains("error"));
  CHECK(!line["pass_gpu_ms"].contains("error"));
  // The window shows a text before the first picture.
  CHECK(read(folder.file("out")).starts_with("{\"event\":\"loading\""));
  CHECK(line["first_text_ms"].get<double>() > 0);
  CHECK(line["first_text_ms"].get<double>() < line["first_picture_ms"].get<double>());
  // In software the first picture is a rough one. A short session shows a whole one, too.
  CHECK(line["first_picture_ms"].get<double>() < line["first_whole_picture_ms"].get<double>());
  CHECK(line["start_ms"]["stage_device"].get<double>() < line["start_ms"]["frame"].get<double>());
  const std::string png = read(folder.file("a.png"));
  REQUIRE(png.size() > 1000);
  CHECK(png.substr(1, 3) == "PNG");
}

TEST_CASE("the panel has the error of the pictures, measured at samples of them") {
  if (!can_open_window()) return;
  const TempFolder folder;
  const Display display(1024, 768);
  Footlight window(
      {"preview", "--demo", "--at", "12s", "--size", "900x160", "--views", "2", "--json", "--period", "100ms"},
      {{"DISPLAY", display.name()},
       {"WAYLAND_DISPLAY", ""},
       {"XDG_STATE_HOME", folder.file("state")},
       {"FOOTLIGHT_VALIDATION", "1"},
       {"ASAN_OPTIONS", "detect_leaks=0"}});
  // Until 8 samples were measured, and both views were drawn several times.
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(240);
  for (nlohmann::json figures; std::chrono::steady_clock::now() < until;) {
    figures = nlohmann::json::parse(window.last_line(), nullptr, false);
    if (figures.is_object() && figures.contains("error") && figures["error"]["samples"] >= 8 &&
        figures["view_pictures"][1] >= 3) {
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  window.signal(SIGTERM);
  const Outcome outcome = window.wait();
  INFO(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  const std::size_t last = outcome.out.rfind('\n', outcome.out.size() - 2);
  const nlohmann::json line = nlohmann::json::parse(outcome.out.substr(last + 1));
  CHECK(line["event"] == "summary");
  CHECK(line["validation_messages"] == 0);
  REQUIRE(line.contains("error"));
  const nlohmann::json& error = line["error"];
  CHECK(error["samples"].get<int>() >= 8);
  CHECK(error["rel_l2"].get<double>() > 1e-6);
  CHECK(error["rel_l2"].get<double>() < 0.1);
  CHECK(error["low"] <= error["rel_l2"]);
  CHECK(error["high"] >= error["rel_l2"]);
  CHECK(line["pass_gpu_ms"]["error"].get<double>() > 0);
  // There are two views. Both were drawn, the active one more often.
  const auto views = line["view_pictures"].get<std::vector<int>>();
  REQUIRE(views.size() == 2);
  CHECK(views[1] > 0);
  CHECK(views[0] > views[1]);
}

TEST_CASE("a log that is cut while it plays stands still with the reason, and the window stays") {
  if (!can_open_window()) return;
  const TempFolder folder;
  REQUIRE(footlight({"samples", folder.file("s")}).exit_code == 0);
  const std::string log = folder.file("s/show.dmxlog");
  const Display display(640, 480);
  Footlight window({"preview", folder.file("s/rig.toml"), "--log", log, "--size", "320x180", "--edges", "off",
                    "--bounce", "off", "--shadows", "off", "--json", "--period", "100ms"},
                   {{"DISPLAY", display.name()},
                    {"WAYLAND_DISPLAY", ""},
                    {"XDG_STATE_HOME", folder.file("state")},
                    {"ASAN_OPTIONS", "detect_leaks=0"}});
  window.wait_for(R"("event":"frames")");
  std::filesystem::resize_file(log, 100);
  window.wait_for(R"("stands":true)");
  window.signal(SIGTERM);
  CHECK(window.wait().exit_code == 0);
}

TEST_CASE("an error or a time that is none, or two at once, is refused before a window opens") {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"--error", "0"}, "--error 0: expected"},
      {{"--error", "200%"}, "--error 200%: expected"},
      {{"--error", "abc"}, "--error abc: expected"},
      {{"--ms", "-1"}, "--ms -1: expected"},
      {{"--error", "1%", "--ms", "8"}, "leave out one of them"},
      {{"--ms", "8", "--nodes", "3"}, "--ms and --nodes: expected one of them"}};
  for (const auto& [words, message] : cases) {
    for (const char* command : {"preview", "report"}) {
      if (words.back() == "3" && std::string_view(command) == "report") continue;  // it has no --nodes
      std::vector<std::string> line = {command, "--demo"};
      line.insert(line.end(), words.begin(), words.end());
      const Outcome outcome = footlight(line);
      if (contains(outcome.err, "libglfw3-dev")) continue;
      CHECK(outcome.exit_code == 2);
      INFO(outcome.err);
      CHECK(contains(outcome.err, message));
    }
  }
}

TEST_CASE("a rig without input opens with its fixtures lit") {
  if (!can_open_window()) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar;
  const int code = preview(folder, folder.file("rig.toml") + " --seconds 1 --size 320x180 --json");
  const std::string err = read(folder.file("err"));
  if (contains(err, "libglfw3-dev")) return;
  INFO(err);
  REQUIRE(code == 0);
  CHECK(summary(folder)["live"] == 1);
  CHECK(summary(folder)["validation_messages"] == 0);
}

// A strobe at 25 Hz, with which a picture depends on the time of its exposure, has no difference with itself.
TEST_CASE("two logs are compared on the stage beside each other and as a difference, which a log and itself have not") {
  if (!can_open_window()) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar << kFrontCamera;
  std::ofstream(folder.file("lit.show")) << "OLA Show\n3 255,0,255,255,255\n20000\n";
  std::ofstream(folder.file("strobe.show")) << "OLA Show\n3 255,255,255,255,255\n20000\n";
  std::ofstream(folder.file("dark.show")) << "OLA Show\n3 0,0,0,0,0,0\n20000\n";
  const auto compared = [&](const std::string& log, const std::string& other, const std::string& mode) {
    const int code = preview(folder, folder.file("rig.toml") + " --log " + folder.file(log) + " --compare " +
                                         folder.file(other) + " --compare-stage " + mode +
                                         " --seconds 1 --size 320x180 --edges off --bounce off --shadows off --json");
    const std::string err = read(folder.file("err"));
    INFO(err);
    REQUIRE((code == 0 || contains(err, "libglfw3-dev")));
    return code == 0 ? summary(folder) : nlohmann::json();
  };
  const nlohmann::json different = compared("lit.show", "dark.show", "difference");
  if (different.is_null()) return;
  CHECK(different["difference_largest"].get<double>() > 0.1);
  CHECK(different["difference_mean"].get<double>() > 0);
  CHECK(different["validation_messages"] == 0);
  CHECK(compared("strobe.show", "strobe.show", "difference")["difference_largest"] == 0);
  const nlohmann::json beside = compared("lit.show", "dark.show", "beside");
  REQUIRE(beside["view_pictures"].size() == 2);
  CHECK(beside["view_pictures"][0].get<int>() > 0);
  CHECK(beside["view_pictures"][1].get<int>() > 0);
  CHECK(beside["validation_messages"] == 0);
}

TEST_CASE("an X server that goes away ends the window with a message, and its recording is whole") {
  if (!can_open_window()) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar;
  Display display(320, 200);
  REQUIRE(!display.name().empty());
  Footlight window(
      {"preview", folder.file("rig.toml"), "--size", "160x90", "--json", "--record", folder.file("kept.dmxlog")},
      {{"DISPLAY", display.name()},
       {"WAYLAND_DISPLAY", ""},
       {"XDG_STATE_HOME", folder.file("state")},
       {"ASAN_OPTIONS", "detect_leaks=0"}});
  window.wait_for("\"event\":\"frames\"");
  display.end(SIGKILL);
  const Outcome outcome = window.wait();
  if (contains(outcome.err, "libglfw3-dev")) return;
  INFO(outcome.err);
  CHECK(outcome.exit_code == 1);
  CHECK(contains(outcome.err, "the window's display has gone"));
  CHECK(!std::filesystem::exists(folder.file("kept.dmxlog.part")));
  CHECK(footlight({"log", "info", folder.file("kept.dmxlog")}).exit_code == 0);
}

TEST_CASE("a window whose recording could not be written ends with the exit code of a failure") {
  if (!can_open_window()) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar;
  std::filesystem::create_directory(folder.file("gone"));
  Display display(320, 200);
  REQUIRE(!display.name().empty());
  Footlight window({"preview", folder.file("rig.toml"), "--size", "160x90", "--json", "--record",
                    folder.file("gone/kept.dmxlog")},
                   {{"DISPLAY", display.name()},
                    {"WAYLAND_DISPLAY", ""},
                    {"XDG_STATE_HOME", folder.file("state")},
                    {"ASAN_OPTIONS", "detect_leaks=0"}});
  window.wait_for("\"event\":\"frames\"");
  std::filesystem::remove_all(folder.file("gone"));
  window.signal(SIGINT);
  const Outcome outcome = window.wait();
  if (contains(outcome.err, "libglfw3-dev")) return;
  INFO(outcome.err);
  CHECK(outcome.exit_code == 1);
  CHECK(contains(outcome.err, "kept.dmxlog"));
}

TEST_CASE("a device that refuses memory ends a picture with a message that says how much it refused") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const Outcome outcome = Footlight({"render", "--demo", "--at", "1s", "-o", folder.file("a.png")},
                                    {{"FOOTLIGHT_REFUSE_MEMORY_MIB", "1"}, {"ASAN_OPTIONS", "detect_leaks=0"}})
                              .wait();
  INFO(outcome.err);
  CHECK(outcome.exit_code == 1);
  CHECK(contains(outcome.err, "has no memory left"));
  CHECK(contains(outcome.err, "MiB more were refused"));
  CHECK(!std::filesystem::exists(folder.file("a.png")));
}

TEST_CASE("all panels draw in a small window, twice as large on a screen of 192 dpi, and the picture keeps its size") {
  if (!can_open_window()) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar;
  const std::string line = folder.file("rig.toml") + " --seconds 1 --size 640x360 --json --screenshot ";
  const std::string all =
      " --panels universes,fixtures,inspector,timeline,devices,library,messages,report,keys --select Par";
  const int code = preview(folder, line + folder.file("a.png") + all, "", 192);
  const std::string err = read(folder.file("err"));
  if (contains(err, "libglfw3-dev")) return;
  INFO(err);
  REQUIRE(code == 0);
  CHECK(err.empty());
  const nlohmann::json with = summary(folder);
  CHECK(with["validation_messages"] == 0);
  CHECK(with["ui_scale"] == 2);
  CHECK(with["live"] == 1);
  CHECK(with["ui_ms_p50"].get<double>() > 0);
  CHECK(with["width"] == 640);  // the most that software renders in full resolution at first
  CHECK(with["height"] == 360);
}

TEST_CASE("a number of views that there is not is refused with those that there are") {
  const Outcome outcome = footlight({"preview", "--demo", "--views", "3"});
  CHECK(outcome.exit_code == 2);
  CHECK(contains(outcome.err, "--views 3: expected 1, 2 or 4"));
}

TEST_CASE("a panel or a selection that is none is refused with what there is") {
  const Outcome wrong_panel = footlight({"preview", "--demo", "--panels", "universes,nonsense"});
  if (contains(wrong_panel.err, "libglfw3-dev")) return;
  CHECK(wrong_panel.exit_code == 2);
  CHECK(contains(wrong_panel.err, "nonsense"));
  CHECK(contains(wrong_panel.err, "inspector"));
  if (!can_open_window()) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar;
  CHECK(preview(folder, folder.file("rig.toml") + " --seconds 1 --size 320x180 --select Nobody") != 0);
  CHECK(contains(read(folder.file("err")), "--select Nobody"));
}

TEST_CASE("a GPU that is lost is replaced, for the stage and for the window, at the same time of the log") {
  if (!can_open_window()) return;
  const TempFolder folder;
  const int code = preview(folder,
                           "--demo --at 12s --seconds 3 --size 160x90 --json --panels inspector,universes "
                           "--select 'Profile 2'",
                           "FOOTLIGHT_LOSE_DEVICE=0 FOOTLIGHT_LOSE_WINDOW=0 ");
  const std::string err = read(folder.file("err"));
  if (contains(err, "libglfw3-dev")) return;
  INFO(err);
  REQUIRE(code == 0);
  const std::string out = read(folder.file("out"));
  CHECK(contains(out, "\"device\":\"stage\",\"event\":\"device-lost\""));
  CHECK(contains(out, "\"device\":\"window\",\"event\":\"device-lost\""));
  CHECK(contains(out, "device lost"));
  const nlohmann::json line = summary(folder);
  CHECK(line["event"] == "summary");
  CHECK(line["validation_messages"] == 0);
  CHECK(line["frames"].get<int>() >= 1);
  CHECK(line["live"].get<int>() > 0);
}

}  // namespace
}  // namespace footlight::testing

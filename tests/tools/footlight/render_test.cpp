// footlight render and report as users run them; on lavapipe if it is installed.
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "fixtures/gobos/png.h"
#include "render/frame.h"
#include "render/quality.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tests/tools/footlight/one_par.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/demo_show/demo_assets.h"
#include "tools/footlight/pictures/timeline.h"

namespace footlight::testing {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string read(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Drivers leak some memory after the Vulkan loader closes them (tests/support/headless_vulkan.cpp).
const std::map<std::string, std::string> kNoLeaks = {{"ASAN_OPTIONS", "detect_leaks=0"}};

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes.at(at + i));
  return value;
}

// Duration of the only track of an MP4, from its media header (ISO/IEC 14496-12, version 0).
double seconds_of(const std::string& path) {
  const std::string bytes = read(path);
  const std::size_t header = bytes.find("mdhd");
  REQUIRE(header != std::string::npos);
  REQUIRE(bytes.at(header + 4) == 0);
  return static_cast<double>(big_endian(bytes, header + 20)) / big_endian(bytes, header + 16);
}

bool no_encoder(const Outcome& outcome) {
  return contains(outcome.err, "libav") && contains(outcome.err, "frame_%04d.png");
}

TEST_CASE("pictures from a time after the last one are refused, and no file is written") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const std::vector<std::string> spans[] = {{"--from", "1.5s", "--until", "1s"}, {"--from", "100m"}};
  for (const std::vector<std::string>& span : spans) {
    std::vector<std::string> words{"render", "--demo", "--every", "40ms", "--size", "32x18",
                                   "-o",     folder.file("late_%d.png")};
    words.insert(words.end(), span.begin(), span.end());
    const Outcome outcome = Footlight(words, kNoLeaks).wait();
    CHECK(outcome.exit_code == 2);
    CHECK(contains(outcome.err, "--from"));
    CHECK(contains(outcome.err, "expected an earlier time"));
    CHECK_FALSE(std::filesystem::exists(folder.file("late_0.png")));
    CHECK_FALSE(std::filesystem::exists(folder.file("late_1.png")));
  }
}

TEST_CASE("--error takes fixed knobs, which the file states and with which the picture can be made again") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const auto render = [&](const std::vector<std::string>& more, const std::string& name) {
    std::vector<std::string> words = {"render", "--demo", "--at", "12s", "--size", "64x36", "-o", folder.file(name)};
    words.insert(words.end(), more.begin(), more.end());
    return Footlight(words, kNoLeaks).wait();
  };
  const auto settings_in = [&](const std::string& name) {
    const std::string bytes = read(folder.file(name));
    return nlohmann::json::parse(fixtures::png_text(std::as_bytes(std::span(bytes)), "footlight/settings"));
  };
  const auto pixels_in = [&](const std::string& name) {
    const std::string bytes = read(folder.file(name));
    return fixtures::rgba_of(64, 36, std::as_bytes(std::span(bytes)));
  };
  const Outcome chosen = render({"--error", "2%", "--json"}, "chosen.png");
  REQUIRE(chosen.exit_code == 0);
  const nlohmann::json settings = settings_in("chosen.png");
  const render::Knobs knobs = must(render::fixed_knobs(0.02)).knobs;
  CHECK(settings.at("error") == 0.02);
  CHECK(settings.at("footlight") == "0.1.0");
  CHECK(settings.at("nodes") == knobs.nodes);
  CHECK(settings.at("tile_error") == knobs.tile_error);
  CHECK(settings.at("gobo_method") == "taps");
  CHECK(settings.at("gobo_taps") == knobs.gobo_taps);
  CHECK(settings.at("body_error_px") == knobs.body_error_px);
  CHECK(nlohmann::json::parse(chosen.out.substr(0, chosen.out.find('\n'))).at("settings") == settings);

  const auto text = [&](const char* name) { return settings.at(name).dump(); };
  const Outcome again =
      render({"--nodes", text("nodes"), "--tile-error", text("tile_error"), "--gobos", "samples", "--gobo-taps",
              text("gobo_taps"), "--gobo-px", text("gobo_px"), "--body-error", text("body_error_px")},
             "again.png");
  REQUIRE(again.exit_code == 0);
  CHECK(!pixels_in("chosen.png").empty());
  CHECK(pixels_in("again.png") == pixels_in("chosen.png"));
  nlohmann::json same = settings_in("again.png");
  CHECK(same.at("error") == 0);
  same["error"] = 0.02;
  CHECK(same == settings);

  for (const std::vector<std::string>& words : {std::vector<std::string>{"--error", "0"},
                                                {"--error", "200%"},
                                                {"--error", "abc"},
                                                {"--error", "1e-9"},
                                                {"--error", "1%", "--nodes", "3"},
                                                {"--error", "1%", "--gobo-px", "512"},
                                                {"--gobo-px", "500"},
                                                {"--gobos", "many"}}) {
    const Outcome refused = render(words, "none.png");
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, words[0]));
    CHECK(contains(refused.err, "expected"));
  }
  for (const char* ms : {"8", "-1"}) {
    const Outcome refused = render({"--ms", ms}, "none.png");
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, "does not depend on time; use --error"));
  }
  CHECK(!std::filesystem::exists(folder.file("none.png")));
}

TEST_CASE("the camera's words are stated in the file, and wrong ones are refused with a list of the right ones") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const auto render = [&](const std::vector<std::string>& more, const std::string& name) {
    std::vector<std::string> words = {"render", "--demo", "--at", "6s", "--size", "16x9", "-o", folder.file(name)};
    words.insert(words.end(), more.begin(), more.end());
    return Footlight(words, kNoLeaks).wait();
  };
  const Outcome done =
      render({"--tone", "filmic", "--white-balance", "3200K", "--auto-exposure", "--json"}, "camera.png");
  INFO(done.err);
  REQUIRE(done.exit_code == 0);
  CHECK(contains(done.out, R"("white_balance_k":3200,"tone":"filmic","auto_exposure":true)"));
  CHECK(!contains(done.out, R"("ev":4.6,)"));  // that of the camera
  for (const auto& [words, message] :
       {std::pair<std::vector<std::string>, std::string>{{"--tone", "film"},
                                                         "--tone film: expected agx, filmic, reinhard or linear"},
        {{"--white-balance", "warm"}, "--white-balance warm: expected off or 1500K to 20000K"},
        {{"--white-balance", "320K"}, "--white-balance 320K: expected off or 1500K to 20000K"},
        {{"--f-stop", "0.1"}, "--f-stop 0.1: expected camera, off or 0.5 to 64"},
        {{"--f-stop", "wide"}, "--f-stop wide: expected camera, off or 0.5 to 64"},
        {{"--plumes", "some"}, "--plumes some: expected on or off"},
        {{"--auto-exposure", "--ev", "3"}, "each sets the exposure; leave out one of them"}}) {
    const Outcome refused = render(words, "none.png");
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, message));
  }
}

TEST_CASE("--show writes false colours and says what they mean, and refuses what is no picture of them") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const auto render = [&](const std::vector<std::string>& more, const std::string& name) {
    std::vector<std::string> words = {"render", "--demo", "--at", "12s", "--size", "32x18", "-o", folder.file(name)};
    words.insert(words.end(), more.begin(), more.end());
    return Footlight(words, kNoLeaks).wait();
  };
  const Outcome lux = render({"--show", "lux", "--probe", "16,15", "--probe", "0,0"}, "lux.png");
  CHECK(lux.exit_code == 0);
  CHECK(contains(lux.out, "16,15: "));
  CHECK(contains(lux.out, "0,0: "));
  CHECK(contains(lux.out, "lx; blue to red"));
  CHECK(contains(render({"--show", "classes"}, "classes.png").out, "red: pixel by pixel"));
  CHECK(contains(render({"--show", "error"}, "error.png").out, "of the light"));
  CHECK(std::filesystem::exists(folder.file("error.png")));
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--show", "lux", "--probe", "1,x"},
                                                {"--show", "lux", "--probe", "99999999999,1"},
                                                {"--show", "lux", "--probe", "32,0"},
                                                {"--probe", "1,1"},
                                                {"--show", "heat"}}) {
    const Outcome refused = render(words, "none.png");
    CHECK(refused.exit_code != 0);
    CHECK(contains(refused.err, "expected"));
    CHECK(!std::filesystem::exists(folder.file("none.png")));
  }
  CHECK(contains(render({"--show", "lux"}, "lux.exr").err, "expected .png or .mp4"));
}

TEST_CASE("a video of 0.4 s lasts 0.4 s, and numbered pictures include one at its end") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const std::string video = folder.file("a.mp4");
  const Outcome outcome = Footlight({"render", "--demo", "--every", "40ms", "--from", "1s", "--until", "1.4s", "--size",
                                     "32x18", "--json", "-o", video},
                                    kNoLeaks)
                              .wait();
  if (no_encoder(outcome)) return;
  INFO(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  CHECK(seconds_of(video) == doctest::Approx(0.4).epsilon(1e-6));
  const Outcome pictures = Footlight({"render", "--demo", "--every", "200ms", "--from", "1s", "--until", "1.4s",
                                      "--size", "32x18", "-o", folder.file("p_%d.png")},
                                     kNoLeaks)
                               .wait();
  CHECK(pictures.exit_code == 0);
  CHECK(std::filesystem::exists(folder.file("p_2.png")));
  CHECK(!std::filesystem::exists(folder.file("p_3.png")));
}

TEST_CASE("a GPU that is lost ends render with exit code 1 and a message") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const char* submits : {"0", "5"}) {
    const TempFolder folder;
    std::map<std::string, std::string> environment = kNoLeaks;
    environment["FOOTLIGHT_LOSE_DEVICE"] = submits;
    const Outcome outcome = Footlight({"render", "--demo", "--every", "40ms", "--until", "400ms", "--size", "32x18",
                                       "-o", folder.file("p_%d.png")},
                                      environment)
                                .wait();
    INFO(outcome.err);
    CHECK(outcome.exit_code == 1);
    CHECK(contains(outcome.err, "device lost"));
    CHECK(!std::filesystem::exists(folder.file("p_9.png")));
  }
}

TEST_CASE("compiled pipelines are kept in the cache folder unless the cache is off") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  std::map<std::string, std::string> environment = kNoLeaks;
  environment["XDG_CACHE_HOME"] = folder.file("cache");
  const auto render = [&] {
    return Footlight({"render", "--demo", "--at", "1s", "--size", "32x18", "-o", folder.file("a.png")}, environment)
        .wait()
        .exit_code;
  };
  environment["FOOTLIGHT_PIPELINE_CACHE"] = "off";
  CHECK(render() == 0);
  CHECK(!std::filesystem::exists(folder.file("cache") + "/footlight"));
  environment.erase("FOOTLIGHT_PIPELINE_CACHE");
  CHECK(render() == 0);
  CHECK(std::filesystem::exists(folder.file("cache") + "/footlight"));
}

TEST_CASE("Ctrl-C in render ends with exit code 0, and the video contains the pictures so far") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const int number : {SIGINT, SIGTERM}) {
    const TempFolder folder;
    const std::string video = folder.file("a.mp4");
    Footlight render({"render", "--demo", "--every", "40ms", "--size", "32x18", "--json", "-o", video}, kNoLeaks);
    render.wait_for("\"number\":2,");
    render.signal(number);
    const Outcome outcome = render.wait();
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(!std::filesystem::exists(video + ".part"));
    std::size_t pictures = 0;
    for (std::size_t at = 0; (at = outcome.out.find("\"event\":\"picture\"", at)) != std::string::npos; ++at)
      ++pictures;
    CHECK(pictures >= 3);
    CHECK(contains(outcome.out, "\"event\":\"stopped\",\"pictures\":" + std::to_string(pictures)));
    CHECK(seconds_of(video) == doctest::Approx(0.04 * static_cast<double>(pictures)).epsilon(1e-6));
  }
}

TEST_CASE("Ctrl-C in render leaves complete PNGs") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  Footlight render({"render", "--demo", "--every", "40ms", "--size", "32x18", "--json", "-o", folder.file("p_%d.png")},
                   kNoLeaks);
  render.wait_for("\"number\":1,");
  render.signal(SIGINT);
  const Outcome outcome = render.wait();
  CHECK(outcome.exit_code == 0);
  CHECK(contains(outcome.out, "\"event\":\"stopped\""));
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.file(""))) {
    CHECK(entry.path().extension() == ".png");
    const std::string png = read(entry.path());
    CHECK(contains(png.substr(png.size() < 12 ? 0 : png.size() - 12), "IEND"));
    ++files;
  }
  CHECK(files >= 2);
}

TEST_CASE("a trace equals the GPU's states at the same times") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Outcome traced =
      Footlight({"trace", "--demo", "--every", "500ms", "--from", "10s", "--until", "14s", "--json"}, kNoLeaks).wait();
  REQUIRE(traced.exit_code == 0);
  std::istringstream lines(traced.out);
  fixtures::Rig rig = fixtures::demo_rig();
  const auto bytes = demo::demo_log_bytes();
  auto log = LogReader::open_bytes({bytes.begin(), bytes.end()}, "the built-in show");
  REQUIRE(log);
  auto driven = tools::compile_driven(rig, std::move(*log));
  REQUIRE(driven);
  render::FrameSettings settings;
  settings.width = 16;
  settings.height = 16;
  auto frame = render::Frame::create(vulkan.device(), rig, driven->compiled, settings);
  REQUIRE(frame);
  const auto step = [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
    (*frame)->step(levels, dt_ns, new_exposure);
    if ((*frame)->pending_steps() >= 512) REQUIRE((*frame)->run_steps());
  };
  double brightest = 0;
  for (int half = 20; half <= 28; ++half) {
    REQUIRE(driven->timeline->advance(half * 500 * kNsPerMs, 500 * kNsPerMs, step));
    REQUIRE((*frame)->run_steps());
    const auto states = (*frame)->read_states();
    REQUIRE(states);
    for (const auto& state : *states) {
      std::string line;
      REQUIRE(std::getline(lines, line));
      CAPTURE(line);
      const auto row = nlohmann::json::parse(line);
      const auto near = [&](const char* name, double value, double scale) {
        CHECK(row[name].get<double>() == doctest::Approx(value).epsilon(2e-6).scale(scale));
      };
      constexpr double kDegree = 180 / 3.14159265358979323846;
      if (!row["pan_deg"].is_null()) near("pan_deg", state.pan * kDegree, 100);
      if (!row["tilt_deg"].is_null()) near("tilt_deg", state.tilt * kDegree, 100);
      near("zoom_deg", 2 * state.zoom * kDegree, 10);
      near("red", state.red, 1);
      near("green", state.green, 1);
      near("blue", state.blue, 1);
      brightest = std::max(brightest, row["light"].get<double>());
    }
  }
  CHECK(brightest > 0.1);
}

TEST_CASE("report refuses a rig without levels, and measures it with --lit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << kOnePar << kFrontCamera;
  const std::vector<std::string> small = {"--pictures", "--quick", "--runs",         "3",  "--size",
                                          "64x36",      "--json",  "--judge-pixels", "400"};
  const auto report = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"report", folder.file("rig.toml")});
    words.insert(words.end(), small.begin(), small.end());
    return Footlight(words, kNoLeaks).wait();
  };
  const Outcome black = report({});
  CHECK(black.exit_code == 2);
  CHECK(contains(black.err, "--lit"));
  CHECK(black.out.empty());
  const Outcome dark = report({"--set", "Dimmer=0"});
  CHECK(dark.exit_code == 2);
  CHECK(contains(dark.err, "no beam is lit"));
  for (const char* words : {"tiles,gaus_", "tiles,"}) {
    const Outcome wrong = report({"--lit", "--methods", words});
    CHECK(wrong.exit_code == 2);
    CHECK(contains(wrong.err, "expected some of: tiles, gauss, march"));
    CHECK(wrong.out.empty());
  }
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--lit"}, std::vector<std::string>{"--set", "Dimmer=0.5", "--methods", "til,march"}}) {
    const Outcome lit = report(words);
    INFO(lit.err);
    REQUIRE(lit.exit_code == 0);
    const auto row = nlohmann::json::parse(lit.out.substr(0, lit.out.find('\n')));
    CHECK(row["rel_l2"].get<double>() > 1e-9);
    CHECK(row["rel_l2"].get<double>() < 1e-2);
    CHECK(row["rel_l2_low"].get<double>() < row["rel_l2"].get<double>());
    CHECK(row["rel_l2_high"].get<double>() > row["rel_l2"].get<double>());
    CHECK(row["flip"].is_null());
    CHECK(contains(lit.out, "\"whole-frame\""));
    CHECK(contains(lit.out, "\"method\":\"tiles\""));
    CHECK(contains(lit.out, "\"method\":\"march\""));
    CHECK(contains(lit.out, "\"method\":\"gauss\"") == (words.size() == 1));
    CHECK(contains(lit.out, "\"need\":\"blades\""));
    CHECK(!contains(lit.out, "\"mirrored\""));  // nothing is shiny
    CHECK(contains(lit.out, "\"pass\":\"probes\""));
  }
}

TEST_CASE("report measures displays that shine in a rig that nothing drives, and says when they are dark") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const auto report = [&](const std::string& display, std::vector<std::string> more) {
    std::ofstream(folder.file("rig.toml")) << kOnePar << kFrontCamera
                                           << "[[display]]\nposition = [0, 4, 2]\nwidth_m = 4\nheight_m = 2\n"
                                           << display;
    more.insert(more.begin(), {"report", folder.file("rig.toml"), "--pictures", "--quick", "--runs", "3", "--size",
                               "64x36", "--json", "--judge-pixels", "100", "--methods", "tiles"});
    return Footlight(more, kNoLeaks).wait();
  };
  const Outcome lit = report("", {});
  INFO(lit.err);
  REQUIRE(lit.exit_code == 0);
  CHECK(contains(lit.err, "no lamp is lit: the report is of displays alone"));
  const auto row = nlohmann::json::parse(lit.out.substr(0, lit.out.find('\n')));
  CHECK(row["rel_l2"].get<double>() > 0);
  CHECK(row["rel_l2"].get<double>() < 1e-1);
  const Outcome dark = report("universe = 9\n", {});
  CHECK(dark.exit_code == 2);
  CHECK(contains(dark.err, "nothing in it shines by itself (1 fixture, 1 display); use --log, --lit or --set"));
  CHECK(dark.out.empty());
  const Outcome black = report("universe = 9\n", {"--set", "Dimmer=0"});
  CHECK(black.exit_code == 2);
  CHECK(contains(black.err, "no beam is lit and no display shines (1 fixture, 1 display, all dark)"));
}

TEST_CASE("report measures a rig that has only lasers, and lasers beside beams") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  for (const bool par : {false, true}) {
    CAPTURE(par);
    std::ofstream(folder.file("rig.toml"))
        << (par ? kOnePar : "[rig]\nname = \"Lasers\"\n") << kFrontCamera
        << "[[fixture]]\nname = \"Laser\"\ntype = \"generic/laser\"\nuniverse = 1\naddress = 1\n"
           "position = [0, 4, 3]\naim = [0, -2, 2]\n";
    const std::vector<std::string> words = {"report",
                                            folder.file("rig.toml"),
                                            "--pictures",
                                            "--quick",
                                            "--runs",
                                            "3",
                                            "--size",
                                            "64x36",
                                            "--judge-pixels",
                                            "100",
                                            "--json",
                                            "--methods",
                                            "tiles",
                                            "--csv",
                                            folder.file("rows.csv")};
    std::vector<std::string> dark = words;
    dark.insert(dark.end(), {"--set", "Dimmer=0"});
    const Outcome black = Footlight(dark, kNoLeaks).wait();
    CHECK(black.exit_code == 2);
    CHECK(contains(black.err, "no beam is lit"));
    std::vector<std::string> lit = words;
    lit.emplace_back("--lit");
    const Outcome outcome = Footlight(lit, kNoLeaks).wait();
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    std::istringstream lines(outcome.out);
    int rows = 0;
    nlohmann::json lasers;
    for (std::string line; std::getline(lines, line);) {
      const auto row = nlohmann::json::parse(line);
      if (!row.contains("method")) continue;
      ++rows;
      if (row["method"] == "lasers") lasers = row;
    }
    CHECK((par ? rows > 1 : rows == 1));
    REQUIRE(lasers.is_object());
    CHECK(lasers["rel_l2"].get<double>() > 1e-6);
    CHECK(lasers["rel_l2"].get<double>() < 1e-2);
    CHECK(lasers["flip"].is_null());
    CHECK(contains(outcome.out, "\"event\":\"lasers\",\"lit\":1,"));
    CHECK(contains(outcome.out, "\"whole-frame\""));
    std::ifstream csv(folder.file("rows.csv"));
    const std::string text{std::istreambuf_iterator<char>(csv), {}};
    CHECK(contains(text, ",lasers,"));
    CHECK(!contains(text, "nan"));
  }
}

TEST_CASE("report measures a rig with a floor that mirrors, in the picture and outside of it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  for (const char* target : {"0, 0, 0", "0, -9, 9"}) {
    std::ofstream(folder.file("rig.toml"))
        << kOnePar << "[[box]]\nname = \"floor\"\nmin = [-4, -4, -1]\nmax = [4, 4, 0]\ngloss = 0.5\n"
        << "[[camera]]\nname = \"c\"\nposition = [0, -8, 2]\ntarget = [" << target << "]\nfov_deg = 40\n";
    const Outcome lit = Footlight({"report", folder.file("rig.toml"), "--lit", "--pictures", "--quick", "--runs", "3",
                                   "--size", "64x36", "--json", "--judge-pixels", "100", "--methods", "tiles"},
                                  kNoLeaks)
                            .wait();
    INFO(lit.err);
    REQUIRE(lit.exit_code == 0);
    CHECK(contains(lit.out, "\"whole-frame\""));
    const auto row = nlohmann::json::parse(lit.out.substr(0, lit.out.find('\n')));
    CHECK(row["rel_l2"].get<double>() < 1e-2);  // without what the floor mirrors, as the judge
  }
}

TEST_CASE("report has the error of what a shiny floor mirrors, and lists probes as left out by no rig that has them") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  std::ofstream(folder.file("rig.toml"))
      << kOnePar << "material = \"lacquer\"\n[[box]]\nname = \"wall\"\nmin = [-3, 3, 0]\nmax = [3, 3.2, 4]\n"
      << "[[fixture]]\nname = \"Spot\"\ntype = \"generic/par\"\nuniverse = 3\naddress = 101\nposition = [0, 0, 4]\n"
      << "aim = [0.5, 3, 1]\n" << kFrontCamera;
  const auto report = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"report", folder.file("rig.toml"), "--lit",          "--pictures", "--quick",
                                      "--runs", "3",                     "--row-seconds",  "0",          "--size",
                                      "48x27",  "--json",                "--judge-pixels", "100",
                                      "--methods", "tiles"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome done = Footlight(words, kNoLeaks).wait();
    INFO(done.err);
    REQUIRE(done.exit_code == 0);
    CHECK(!contains(done.out, "\"pass\":\"probes\""));
    CHECK(!contains(done.out, "\"pass\":\"bounce\""));
    CHECK(!contains(done.out, "\"need\":\"sheen\""));
    return done.out;
  };
  const auto row_in = [](const std::string& out) {
    const std::size_t at = out.find("{\"event\":\"mirrored\"");
    REQUIRE(at != std::string::npos);
    return nlohmann::json::parse(out.substr(at, out.find('\n', at) - at));
  };
  auto row = row_in(report({}));
  CHECK(row["pixels"].get<int>() > 100);
  CHECK(row["judged"].get<int>() <= row["pixels"].get<int>());
  CHECK(row["rel_l2"].get<double>() > 0.02);
  CHECK(row["rel_l2"].get<double>() < 0.35);
  CHECK(row["rel_l2_low"].get<double>() <= row["rel_l2"].get<double>());
  CHECK(row["rel_l2_high"].get<double>() >= row["rel_l2"].get<double>());
  CHECK(row["own_rel_l2"].get<double>() < 0.1);
  CHECK(row["picture_rel_l2"].get<double>() < row["rel_l2"].get<double>());
  CHECK(std::abs(row["sum"].get<double>() - 1) < 0.2);
  CHECK(row["probes_ms"].get<double>() > 0);
  CHECK(row["reflections_ms"].get<double>() > 0);
  auto again = row_in(report({}));
  for (const char* time : {"probes_ms", "reflections_ms"}) row[time] = again[time] = 0;
  CHECK(row == again);
  CHECK(!contains(report({"--reflections", "off"}), "\"mirrored\""));
}

}  // namespace
}  // namespace footlight::testing

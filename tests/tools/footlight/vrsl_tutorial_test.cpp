// Every line of docs/vrsl_tutorial.md, run in the order of the page in a folder with its files.
#include <filesystem>
#include <fstream>
#include <map>

#include <doctest/doctest.h>

#include "tests/drivers/net/private_network.h"
#include "tests/sim/sound/tones.h"
#include "tests/support/wav_bytes.h"
#include "tests/tools/footlight/doc_lines.h"

namespace footlight::testing {
namespace {

const std::string kTutorial = FOOTLIGHT_SOURCE_DIR "/docs/vrsl_tutorial.md";

constexpr const char* kUntilStopped = "it runs until it is stopped";
constexpr const char* kWindow =
    "a window needs a display (vrsl_window_test.cpp); the model of a device takes its place";
constexpr const char* kSmall = "--size 48x27";
constexpr const char* kLarge = "a large picture takes long without a GPU";

constexpr Special kSpecials[] = {
    {"footlight monitor sacn:1-3", nullptr, "--once", 0, kUntilStopped},
    {"footlight record --in audio:beat.toml -o club.dmxlog --for 5s",
     "footlight record --in audio:beat.toml -o club.dmxlog", "--for 2500ms", 0, "two and a half seconds are enough"},
    {"footlight run --in sacn:1-3 --out vrsl:1-3@window", "footlight run --in sacn:1-3 --out vrsl:1-3@mock",
     "--for 200ms", 0, kWindow},
    {"footlight replay club.dmxlog --loop --out vrsl:1-3@window",
     "footlight replay club.dmxlog --loop --out vrsl:1-3@mock", "--for 200ms", 0, kWindow},
    {"footlight run --in sacn:1-3 --out vrsl:1-3@/dev/video9", nullptr, "--for 100ms", 3, "the device is not there"},
    {"footlight run --in sacn:1-3 --out 'vrsl:1-3@-?fps=60' | mpv -",
     "footlight run --in sacn:1-3 --out 'vrsl:1-3@-?fps=60'", "--for 200ms", 0, "mpv needs a display"},
    {"footlight run --in sacn:1-3 --out vrsl:1-3@mock", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight monitor vrsl:1-3@mock", nullptr, "--once", 0, kUntilStopped},
    {"footlight vrsl round-trip --way yuv420", nullptr, "", 0, ""},
    {"footlight preview club.toml --in sacn:1-3", "footlight rig check club.toml", "", 0,
     "a window needs a display (preview_test.cpp); the rig loads"},
    {"footlight render club.toml --log club.dmxlog --at 2.1s --vrsl-compat -o club.png", nullptr, kSmall, 0, kLarge},
    {"footlight render club.toml --log captured.dmxlog --at 2.1s -o captured.png", nullptr, kSmall, 0, kLarge},
    {"footlight run --in sacn:1-3 --out vrsl-osc:1-3@127.0.0.1", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight run --in vrsl-osc:1-3 --out sacn:1-3", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight run --in audio:beat.toml --out vrsl:1-3@window",
     "footlight run --in audio:beat.toml --out vrsl:1-3@mock", "--for 300ms", 0, kWindow},
    {"footlight run --in audio:alsa:default=1.1 --out vrsl:1-3@window",
     "footlight run --in audio:mock=1.1 --out vrsl:1-3@mock", "--for 300ms", 0, "no sound device is there"},
    {"footlight run --in audio:track.wav=1.1 --out 'vrsl:1-3@dance.mkv?overwrite=yes'", nullptr, "--for 300ms", 0,
     kUntilStopped},
    {"footlight audio texture audio:mock=1.1 --every 20ms --scale 8 --for 5s -o mock",
     "footlight audio texture audio:mock=1.1 --every 20ms --scale 8 -o mock", "--for 300ms", 0, "shorter"},
};

TEST_CASE("every line of the VRSL tutorial runs, in its order, from the console to the world and to sound") {
  if (!enter_private_network()) return;
  const Words lines = doc_lines(kTutorial);
  REQUIRE(lines.size() > 25);
  check_specials(kSpecials, lines);
  const TempFolder folder;
  const WorkingFolder in(folder.file(""));
  const auto files = doc_files(kTutorial);
  CHECK(files.size() == 2);
  for (const auto& [name, text] : files) folder.write(name, text);
  folder.write("track.wav", wav_bytes(clicks(120, 3, 16'000), 16'000, 1));
  std::map<std::string, std::string> environment;
  for (const std::string& line : lines) {
    const auto [words, special] = command_of(line, kSpecials);
    if (words[0] == "render") {
      if (FOOTLIGHT_HAS_PICTURES == 0) continue;
      environment["ASAN_OPTIONS"] = "detect_leaks=0";  // drivers of GPUs leak (tests/support/headless_vulkan.cpp)
    }
    const Outcome outcome = Footlight(words, environment).wait();
    CAPTURE(line);
    INFO("what it needs here: ", special.reason);
    CAPTURE(outcome.err);
    CHECK((outcome.exit_code == 0 || outcome.exit_code == special.exit_code));
  }
  // The stream carried the levels of the beat.
  const Outcome info = footlight({"log", "info", "captured.dmxlog", "--json"});
  CHECK(info.exit_code == 0);
  CHECK(info.out.find("\"frames\":0") == std::string::npos);
}

}  // namespace
}  // namespace footlight::testing

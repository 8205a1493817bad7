// Every `footlight ...` line of the README, run in a folder of `footlight samples`. A line that is not listed below
// runs unchanged and must end with 0, so a new line that does not work fails here.
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/drivers/net/private_network.h"
#include "tests/support/long_tests.h"
#include "tests/tools/footlight/doc_lines.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;
const std::string kReadme = FOOTLIGHT_SOURCE_DIR "/README.md";

constexpr const char* kSmall = "--size 48x27";
constexpr const char* kReport = "--pictures --size 32x18 --judge-pixels 100 --runs 3";
// Compiles the shaders of every method and rival for many scenes, so only `tools/test --long` runs it. The line with a
// rig always runs the same command.
constexpr const char* kLongLine = "footlight report --quick";
constexpr const char* kUntilStopped = "it runs until it is stopped";
constexpr const char* kOtherBridges = "other bridges may run on this machine, those of other tests as well";
constexpr const char* kThatBridge = "--socket ../run/footlight/run.sock";
constexpr const char* kNoDongle = "no dongle is plugged in; the model of one is";
constexpr const char* kWindow = "a window needs a display and its own time (preview_test.cpp); the rig is drawn";

constexpr Special kSpecials[] = {
    {"footlight devices", nullptr, "", 3, "nothing is plugged in"},
    {"footlight discover", nullptr, "--for 50ms", 3, "there is no sender in the private network"},
    {"footlight rdm list --port enttec-pro", "footlight rdm list --port mock:enttec-pro", "", 0, kNoDongle},
    {"footlight run --in sacn:1 --out enttec-pro", "footlight run --in sacn:1 --out mock:enttec-pro", "--for 100ms", 0,
     kNoDongle},
    {"footlight run --in enttec-pro --out artnet:1@10.0.0.7",
     "footlight run --in mock:enttec-pro --out artnet:1@10.0.0.7", "--for 100ms", 0, kNoDongle},
    {"footlight run --in sacn:1 --out mock:enttec-pro", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight run --in sacn:1 --out enttec-pro:EN1 --backup enttec-pro:EN2",
     "footlight run --in sacn:1 --out mock:enttec-pro/EN1 --backup mock:enttec-pro/EN2", "--for 100ms", 0, kNoDongle},
    {"footlight run show.toml --json", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight monitor sacn:1-9", nullptr, "--once", 0, kUntilStopped},
    {"footlight monitor", nullptr, "--once --socket ../run/footlight/run.sock", 0, kOtherBridges},
    {"footlight run --out enttec-pro --rig rig.toml", "footlight run --out mock:enttec-pro --rig rig.toml",
     "--for 100ms", 0, kNoDongle},
    {"footlight set 1.17=255 1.1-12=50%", nullptr, kThatBridge, 0, kOtherBridges},
    {"footlight fade 'Profile 1:Tilt=30' --over 3s", nullptr, "--rig rig.toml --socket ../run/footlight/run.sock", 0,
     kOtherBridges},
    {"footlight release 1.1-12", nullptr, kThatBridge, 0, kOtherBridges},
    {"footlight scene store Warm", nullptr, "--file scenes.toml --socket ../run/footlight/run.sock", 0, kOtherBridges},
    {"footlight scene recall Warm --over 3s", nullptr, "--file scenes.toml --socket ../run/footlight/run.sock", 0,
     kOtherBridges},
    {"footlight blackout", nullptr, kThatBridge, 0, kOtherBridges},
    {"footlight blackout off", nullptr, kThatBridge, 0, kOtherBridges},
    {"footlight run --in osc:8000 --out enttec-pro", "footlight run --in osc:8000 --out mock:enttec-pro", "--for 100ms",
     0, kNoDongle},
    {"footlight run --in midi:mock=1.1 --out mock:enttec-pro", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight reload", nullptr, "--socket ../run/footlight/run.sock", 0, kOtherBridges},
    {"footlight monitor sacn:1-9 --json --period 200ms", nullptr, "--once", 0, kUntilStopped},
    {"footlight run show.toml --metrics 127.0.0.1:9477", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight run show.toml --flashes limit --rig rig.toml", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight run show.toml --log-format json", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight preview", "footlight preview --help", "", 0, kWindow},
    {"footlight preview --demo", "footlight render --demo --at 1s -o preview1.png", kSmall, 0, kWindow},
    {"footlight preview rig.toml --in sacn:1-9", "footlight render rig.toml --at 1s -o preview2.png", kSmall, 0,
     kWindow},
    {"footlight preview rig.toml --in sacn:1-9 --ms 8", "footlight render rig.toml --at 1s --error 5% -o preview5.png",
     kSmall, 0, kWindow},
    {"footlight preview rig.toml --output enttec-pro", "footlight render rig.toml --at 1s -o preview6.png", kSmall, 0,
     kWindow},
    {"footlight preview show.mvr", "footlight render show.mvr --at 1s -o preview3.png", kSmall, 0, kWindow},
    {"footlight preview head.gdtf", "footlight render head.gdtf --at 1s -o preview4.png", kSmall, 0, kWindow},
    {"footlight render rig.toml --log show.dmxlog --at 12.5s --size 1920x1080 -o frame.png",
     "footlight render rig.toml --log show.dmxlog --at 12.5s --size 48x27 -o frame.png", "", 0,
     "a large picture takes long without a GPU"},
    {"footlight fixtures find robe pointe", nullptr, "", 3, "no library of fixtures is installed"},
    {"footlight record --in sacn:1-9 -o new.dmxlog", nullptr, "--for 100ms", 3, kUntilStopped},
    {"footlight log compare show.dmxlog --at 10s --with 25s --rig rig.toml", nullptr, "", 1,
     "the show goes on between the two times"},
    {"footlight mvr stations", nullptr, "--station 127.0.0.1:9", 3, "no station is in the private network"},
    {"footlight mvr get -o desk.mvr", nullptr, "--station 127.0.0.1:9", 3, "no station is in the private network"},
    {"footlight mvr share show.mvr", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight mvr watch", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight replay show.dmxlog --at 12.5s --loop --out sacn:1-9", nullptr, "--for 100ms", 0, kUntilStopped},
    {"footlight render rig.toml --log show.dmxlog --at 12.5s -o frame.exr", nullptr, kSmall, 0,
     "1280x720 pixels take long without a GPU"},
    {"footlight render rig.toml --log show.dmxlog --every 40ms -o show.mp4", nullptr, "--until 80ms --size 48x26", 0,
     "the whole show takes minutes without a GPU"},
    {"footlight render rig.toml --log show.dmxlog --every 20ms -o calm.mp4 --flashes limit", nullptr,
     "--until 80ms --size 48x26", 0, "the whole show takes minutes without a GPU"},
    {"footlight report --quick", nullptr, kReport, 0, "it takes minutes"},
    {"footlight report --quick rig.toml --log show.dmxlog --at 12.5s --svg beams.svg --csv beams.csv", nullptr, kReport,
     0, "it takes minutes"},
    {"footlight report --time", "footlight report --time --worst --quick", "", 0,
     "it takes minutes; report_time_test.cpp runs it with --quick"},
    {"footlight report --time --worst", nullptr, "--quick", 0, "it takes minutes"},
};

bool draws(const Words& words) { return words[0] == "render" || (words[0] == "report" && words[1] != "--time"); }

TEST_CASE("samples writes every file once, the same each time, and replaces none") {
  const TempFolder folder;
  const WorkingFolder in(folder.file(""));
  const Outcome first = footlight({"samples", "a"});
  CHECK(first.exit_code == 0);
  REQUIRE(footlight({"samples", "deep/b"}).exit_code == 0);
  std::size_t files = 0;
  const auto text_of = [](const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  for (const auto& entry : fs::directory_iterator("a")) {
    ++files;
    CAPTURE(entry.path());
    CHECK(first.out.find(entry.path().string()) != std::string::npos);
    const std::string text = text_of(entry.path());
    CHECK(!text.empty());
    CHECK(text == text_of(fs::path("deep/b") / entry.path().filename()));
  }
  CHECK(files == 15);

  std::ofstream("a/foh.show") << "mine";
  const Outcome again = footlight({"samples", "a"});
  CHECK(again.exit_code == 2);
  CHECK(again.err.find("a/rig.toml: exists, and nothing was written") != std::string::npos);
  CHECK(text_of("a/foh.show") == "mine");
  fs::create_directory("c");
  std::ofstream("c/desk.sr") << "mine";
  CHECK(footlight({"samples", "c"}).exit_code == 2);
  CHECK(std::distance(fs::directory_iterator("c"), fs::directory_iterator()) == 1);
  CHECK(footlight({"samples"}).exit_code == 2);
}

TEST_CASE("the samples load without a warning, and their log, OLA show file and capture are equal") {
  const TempFolder folder;
  const WorkingFolder in(folder.file(""));
  REQUIRE(footlight({"samples", "."}).exit_code == 0);
  for (const Words& words : std::vector<Words>{{"fixtures", "check", "head.gdtf", "head.qxf"},
                                               {"rig", "check", "show.mvr", "show.qxw"},
                                               {"log", "diff", "--same-start", "sent.dmxlog", "capture.pcapng"},
                                               {"log", "diff", "--time-tolerance", "1ms", "sent.dmxlog", "foh.show"},
                                               {"log", "timing", "desk.sr"}}) {
    const Outcome outcome = footlight(words);
    CAPTURE(words[0] + " " + words[1]);
    CAPTURE(outcome.out);
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == 0);
    std::string text = outcome.out;
    const std::string none = ", 0 with warnings";  // of the summary
    if (const auto at = text.find(none); at != std::string::npos) text.erase(at, none.size());
    CHECK(text.find("warning") == std::string::npos);
    CHECK(outcome.out.find("error") == std::string::npos);
  }
}

TEST_CASE("the README's search finds a QLC+ definition") {
  if (!fs::exists("/usr/share/qlcplus/fixtures")) {
    MESSAGE("SKIPPED: the package qlcplus-data is not installed");
    return;
  }
  int searches = 0;
  for (const std::string& line : doc_lines(kReadme)) {
    if (!line.starts_with("footlight fixtures find ")) continue;
    Words words = words_of(line);
    words.erase(words.begin());
    CAPTURE(line);
    CHECK(footlight(words).exit_code == 0);
    ++searches;
  }
  CHECK(searches > 0);
}

TEST_CASE("every line of the README runs in a folder of samples") {
  if (!enter_private_network()) return;
  if (!add_interface("stage0", "10.0.0.2")) return;  // 10.0.0.7 is a neighbour
  const TempFolder folder;
  const Words lines = doc_lines(kReadme);
  REQUIRE(lines.size() > 40);
  REQUIRE(std::find(lines.begin(), lines.end(), "footlight samples samples") != lines.end());
  REQUIRE(std::find(lines.begin(), lines.end(), kLongLine) != lines.end());
  check_specials(kSpecials, lines);

  const WorkingFolder root(folder.file(""));
  REQUIRE(footlight({"samples", "samples"}).exit_code == 0);
  const WorkingFolder samples("samples");
  const std::string run_folder = folder.file("run");
  fs::create_directory(run_folder);
  fs::permissions(run_folder, fs::perms::owner_all);
  // No message bus: it leads out of the private network, to a daemon that announces what is shared.
  std::map<std::string, std::string> environment = {{"XDG_RUNTIME_DIR", run_folder},
                                                    {"DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nonexistent"}};
  // `monitor` and `reload` connect to a running bridge.
  Footlight bridge({"run", "show.toml", "--json"}, environment);
  bridge.wait_for(R"("event":"ready")");
  std::set<Words> ran;
  for (const std::string& line : lines) {
    if (line == "footlight samples samples") continue;
    if (line == kLongLine && !runs_long_tests()) continue;
    const auto [words, special] = command_of(line, kSpecials);
    if (!ran.insert(words).second) continue;  // two lines can become one command here
    if (draws(words)) {
      if (FOOTLIGHT_HAS_PICTURES == 0) continue;
      environment["ASAN_OPTIONS"] = "detect_leaks=0";  // drivers of GPUs leak (tests/support/headless_vulkan.cpp)
    }
    const Outcome outcome = Footlight(words, environment).wait();
    CAPTURE(line);
    INFO("what it needs here: ", special.reason);
    CAPTURE(outcome.err);
    CHECK((outcome.exit_code == 0 || outcome.exit_code == special.exit_code));
  }
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
}

}  // namespace
}  // namespace footlight::testing

// Recordings of the window, without a window: what is in the log, also when the program is killed or the disk is full.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include <sys/resource.h>

#include <doctest/doctest.h>

#include "sim/dmx_log/dmx_log.h"
#include "sim/system_clock.h"
#include "tests/support/temp_folder.h"
#include "tools/footlight/preview/recording.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;
using testing::TempFolder;

const std::vector<Universe> kRig{2, 5};

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::vector<std::uint8_t> levels_of(std::uint8_t first, std::uint8_t second) {
  std::vector<std::uint8_t> levels(2 * kSlotCountMax, first);
  std::fill(levels.begin() + kSlotCountMax, levels.end(), second);
  return levels;
}

struct Kept {
  DurationNs at_ns = 0;
  Universe universe = 0;
  int level = 0;
};
std::vector<Kept> kept_in(LogReader reader) {
  std::vector<Kept> all;
  LogFrame frame;
  while (reader.next(frame).value()) all.push_back({frame.time_ns, frame.universe, frame.levels[511]});
  return all;
}

TEST_CASE("a recording has each change of the levels with its time, and no repeats") {
  const TempFolder folder;
  SystemClock clock;
  const auto recording = Recording::start(folder.file("a.dmxlog"), kRig, clock, 1'000).value();
  const TimeNs start_ns = clock.now_ns();
  recording->take(start_ns + 10 * kNsPerMs, kRig, levels_of(1, 2));
  recording->take(start_ns + 20 * kNsPerMs, kRig, levels_of(1, 2));
  recording->take(start_ns + 35 * kNsPerMs, kRig, levels_of(1, 9));
  const std::vector<Universe> edited{2, 7};
  recording->take(start_ns + 40 * kNsPerMs, edited, levels_of(4, 4));
  const auto done = recording->end();
  REQUIRE(done.has_value());
  CHECK(contains(*done, "4 changes: "));
  CHECK(contains(*done, folder.file("a.dmxlog")));
  CHECK(contains(*done, "without the universes that an edit has added"));
  const auto kept = kept_in(LogReader::open(folder.file("a.dmxlog")).value());
  REQUIRE(kept.size() == 4);
  CHECK(kept[1].universe == 5);
  CHECK(kept[1].level == 2);
  CHECK(kept[1].at_ns == kept[0].at_ns);
  CHECK(kept[2].level == 9);
  CHECK(kept[2].at_ns - kept[0].at_ns == 25 * kNsPerMs);
  CHECK(kept[3].universe == 2);
  CHECK(kept[3].level == 4);
  CHECK(!recording->end().has_value());
}

TEST_CASE("what was recorded is in the file within seconds, also if the window gives nothing any more") {
  const TempFolder folder;
  SystemClock clock;
  const auto recording = Recording::start(folder.file("a.dmxlog"), kRig, clock, 1'000).value();
  recording->take(clock.now_ns(), kRig, levels_of(7, 8));
  const TimeNs end_ns = clock.now_ns() + 30 * kNsPerS;
  std::size_t found = 0;
  while (found < 2 && clock.now_ns() < end_ns) {  // what a program that is killed leaves
    std::this_thread::yield();
    if (auto reader = LogReader::open(folder.file("a.dmxlog.part"))) found = kept_in(std::move(*reader)).size();
  }
  CHECK(found == 2);
}

TEST_CASE("a recording replaces no file, and needs a folder and a universe") {
  const TempFolder folder;
  SystemClock clock;
  std::ofstream(folder.file("a.dmxlog")) << "keep";
  CHECK(!Recording::start(folder.file("a.dmxlog"), kRig, clock, 0).has_value());
  std::ifstream file(folder.file("a.dmxlog"));
  CHECK(std::string(std::istreambuf_iterator<char>(file), {}) == "keep");
  const auto nowhere = Recording::start(folder.file("none/a.dmxlog"), kRig, clock, 0);
  REQUIRE(!nowhere.has_value());
  CHECK(contains(nowhere.error().message, "none/a.dmxlog"));
  const auto empty = Recording::start(folder.file("b.dmxlog"), {}, clock, 0);
  REQUIRE(!empty.has_value());
  CHECK(contains(empty.error().message, "nothing to record"));
  CHECK(!fs::exists(folder.file("b.dmxlog")));
}

TEST_CASE("a full disk ends a recording with a message, and what was written stays readable") {
  const TempFolder folder;
  SystemClock clock;
  auto recording = Recording::start(folder.file("a.dmxlog"), kRig, clock, 0).value();
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before = {};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  rlimit tight = before;
  tight.rlim_cur = 20'000;
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &tight) == 0);
  const TimeNs end_ns = clock.now_ns() + 60 * kNsPerS;
  std::uint32_t noise = 1;
  std::vector<std::uint8_t> levels(2 * kSlotCountMax);
  while (recording->trouble().empty() && clock.now_ns() < end_ns) {
    for (std::uint8_t& level : levels)
      level = static_cast<std::uint8_t>((noise = noise * 1664525u + 1013904223u) >> 24);
    recording->take(clock.now_ns(), kRig, levels);
    std::this_thread::yield();
  }
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
  CHECK(contains(recording->trouble(), "a.dmxlog"));
  const auto done = recording->end();
  REQUIRE(!done.has_value());
  CHECK(contains(done.error().message, "stays readable"));
  recording.reset();
  CHECK(LogReader::open(folder.file("a.dmxlog.part")).has_value());
}

TEST_CASE("a recording is named after its rig and the time, and takes no name that there is") {
  const TempFolder folder;
  const std::string rig = folder.file("my show.mvr");
  const std::int64_t unix_ns = 1'700'000'000LL * kNsPerS;
  const std::string path = recording_path("", rig, unix_ns);
  CHECK(fs::path(path).parent_path() == fs::path(rig).parent_path());
  const std::string name = fs::path(path).filename().string();
  CHECK(name.starts_with("my show_2023-11-1"));
  CHECK(name.ends_with(".dmxlog"));
  std::ofstream(path + ".part") << "of a recorder that was killed";
  const std::string second = recording_path("", rig, unix_ns);
  CHECK(second == path.substr(0, path.size() - 7) + "_2.dmxlog");
  std::ofstream(second) << "there";
  CHECK(recording_path("", rig, unix_ns) == path.substr(0, path.size() - 7) + "_3.dmxlog");
  CHECK(recording_path("/else", rig, unix_ns) == "/else/" + name);
  CHECK(fs::path(recording_path("", "", unix_ns)).filename().string().starts_with("demo_2023"));
  CHECK(!fs::path(recording_path("", "", unix_ns)).has_parent_path());
}

}  // namespace
}  // namespace footlight::tools

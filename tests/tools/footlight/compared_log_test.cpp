// Another log that the window compares with its own.
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/sim/dmx_log/support.h"
#include "tests/support/must.h"
#include "tools/footlight/preview/compared_log.h"
#include "tools/footlight/sound/sound_log.h"

namespace footlight::tools {
namespace {

using testing::must;
using testing::OwnedFrame;
using testing::TempFolder;

// Universes 1 and 3; every 50 ms slot 1 of one of them counts on.
std::string log_file(const TempFolder& folder, DurationNs end_ns) {
  std::vector<OwnedFrame> frames;
  for (int i = 0; i * 50 * kNsPerMs < end_ns; ++i) {
    OwnedFrame frame;
    frame.time_ns = i * 50 * kNsPerMs;
    frame.universe = i % 2 == 0 ? 1 : 3;
    frame.slots = {static_cast<std::uint8_t>(i / 2), 7};
    frames.push_back(std::move(frame));
  }
  LogWriterOptions options;
  options.block_span_ns = 500 * kNsPerMs;
  const auto bytes = testing::log_bytes(frames, end_ns, options);
  std::string path = folder.file("monday.dmxlog");
  testing::write_bytes(path, std::string(bytes.begin(), bytes.end()));
  return path;
}

Result<ComparedLog> opened(const std::string& path, std::vector<Universe> universes) {
  FL_ASSIGN(LogReader reader, read_level_log(path));
  return ComparedLog::open(std::move(reader), path, std::move(universes));
}

TEST_CASE("a compared log has the levels of any time, whichever time was asked for before") {
  const TempFolder folder;
  ComparedLog log = must(opened(log_file(folder, 20 * kNsPerS), {1, 3}));
  CHECK(log.name() == "monday.dmxlog");
  CHECK(log.duration_ns() == 20 * kNsPerS);
  REQUIRE(log.moment().universes == std::vector<Universe>{1, 3});
  const auto check = [&](TimeNs at_ns) {
    CAPTURE(at_ns);
    must(log.go_to(at_ns));
    const auto last = static_cast<int>(std::clamp<TimeNs>(at_ns, 0, 20 * kNsPerS - kNsPerMs) / (50 * kNsPerMs));
    CHECK(log.moment().levels[0] == last / 2 % 256);
    CHECK(log.moment().levels[1] == 7);
    CHECK(log.moment().levels[kSlotCountMax] == (last == 0 ? 0 : (last - 1) / 2 % 256));
    CHECK(std::count_if(log.moment().levels.begin(), log.moment().levels.end(), [](int each) { return each > 0; }) <=
          4);
  };
  for (const int at_ms : {0, 10, 50, 49, 3333, 3334, 9000, 18'000, 2000, 1999, 30'000, -5, 19'999, 25'000, 100}) {
    check(at_ms * kNsPerMs);
  }
  for (TimeNs at_ns = 0; at_ns < 12 * kNsPerS; at_ns += 17 * kNsPerMs) check(at_ns);
}

TEST_CASE("a compared log leaves out universes that the rig has not, and follows the universes of an edited rig") {
  const TempFolder folder;
  ComparedLog log = must(opened(log_file(folder, 4 * kNsPerS), {2, 3}));
  must(log.go_to(2 * kNsPerS));
  CHECK(log.moment().levels[0] == 0);
  CHECK(log.moment().levels[kSlotCountMax] == 19);
  must(log.set_universes({1}));
  CHECK(log.moment().universes == std::vector<Universe>{1});
  CHECK(log.moment().levels.size() == kSlotCountMax);
  CHECK(log.moment().levels[0] == 20);
}

TEST_CASE("a compared log that is missing, is no log or is cut off while it is read is an error with its name") {
  const TempFolder folder;
  const auto missing = opened(folder.file("none.dmxlog"), {1});
  REQUIRE(!missing);
  CHECK(missing.error().message.find("none.dmxlog") != std::string::npos);
  testing::write_bytes(folder.file("text.dmxlog"), "levels of monday");
  const auto text = opened(folder.file("text.dmxlog"), {1});
  REQUIRE(!text);
  CHECK(text.error().message.find("text.dmxlog") != std::string::npos);

  const std::string path = log_file(folder, 20 * kNsPerS);
  ComparedLog log = must(opened(path, {1, 3}));
  must(log.go_to(kNsPerS));
  const std::vector<std::uint8_t> before = log.moment().levels;
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  const Status read = log.go_to(19 * kNsPerS);
  REQUIRE(!read);
  CHECK(read.error().message.find("monday.dmxlog") != std::string::npos);
  CHECK(log.moment().levels == before);
}

TEST_CASE("a recording of another format is compared as a log is") {
  const TempFolder folder;
  testing::write_bytes(folder.file("monday.show"), "OLA Show\n1 10,20\n500\n1 30,40\n500\n");
  ComparedLog log = must(opened(folder.file("monday.show"), {1}));
  CHECK(log.name() == "monday.show");
  must(log.go_to(100 * kNsPerMs));
  CHECK(log.moment().levels[0] == 10);
  must(log.go_to(900 * kNsPerMs));
  CHECK(log.moment().levels[0] == 30);
  CHECK(log.moment().levels[1] == 40);
}

}  // namespace
}  // namespace footlight::tools

// The window of a vrsl endpoint on a display of its own, whose pixels Xvfb writes into a file. Skipped without Xvfb.
#include <doctest/doctest.h>

#include <poll.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <random>

#include "drivers/vrsl/grid.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/support/must.h"
#include "tests/tools/footlight/display.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/vrsl/png_pictures.h"

namespace footlight::tools {
namespace {

using drivers::Picture;
using testing::must;
using testing::TempFolder;

constexpr int kWidth = 960, kHeight = 104;
constexpr int kScreenWidth = 1024, kScreenHeight = 128;

// The upper left part of the screen. XWD: a header of big-endian words, a table of colours of 12 bytes each, then rows
// of 32-bit pixels, blue first.
bool read_screen(const std::string& path, Picture& picture) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[4 * at + i]);
    return std::size_t{value};
  };
  if (bytes.size() < 100) return false;
  const std::size_t start = word(0) + 12 * word(19);
  const std::size_t stride = word(12);
  if (word(11) != 32 || bytes.size() < start + stride * kScreenHeight) return false;
  picture.clear(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::size_t at = start + stride * static_cast<std::size_t>(y) + 4 * static_cast<std::size_t>(x);
      for (std::size_t i = 0; i < 3; ++i) picture.at(x, y)[i] = static_cast<std::uint8_t>(bytes[at + 2 - i]);
    }
  }
  return true;
}

}  // namespace

TEST_CASE("the window shows every pixel of the grid with its own code") {
  const TempFolder folder;
  const testing::Display display(kScreenWidth, kScreenHeight, folder.path().string());
  if (display.name().empty()) {
    MESSAGE("skipped: needs Xvfb; 'sudo apt-get install xvfb'");
    return;
  }
  std::mt19937 random(5);  // NOLINT(bugprone-random-generator-seed)
  std::vector<std::uint8_t> levels(std::size_t{9} * kSlotCountMax);
  for (std::uint8_t& level : levels) level = static_cast<std::uint8_t>(random());
  Picture sent;
  must(drivers::GridCodec::make({.planes = drivers::GridPlanes::kRgb, .width = kWidth, .height = kHeight}))
      .encode(levels, sent);
  must(write_picture_file(folder.file("show.png"), sent.view()));
  testing::Footlight bridge({"run", "--in", "vrsl:1-9@" + folder.file("show.png") + "?layout=horizontal-bottom",
                             "--out", "vrsl:1-9@window?size=960x104", "--for", "60s"},
                            {{"DISPLAY", display.name()}, {"WAYLAND_DISPLAY", ""}, {"ASAN_OPTIONS", "detect_leaks=0"}});
  const TimeNs deadline_ns = testing::real_now_ns() + 30 * kNsPerS;
  Picture shown;
  while (!(read_screen(folder.file("Xvfb_screen0"), shown) && shown.rgb == sent.rgb)) {
    REQUIRE(testing::real_now_ns() < deadline_ns);
    REQUIRE(::poll(nullptr, 0, 20) == 0);
  }
  bridge.signal(SIGTERM);
  const testing::Outcome outcome = bridge.wait();
  CHECK(outcome.exit_code == 0);
}

TEST_CASE("a window without a display is refused with the other ways") {
  const testing::Outcome outcome = testing::Footlight({"run", "--in", "sacn:1%lo", "--out", "vrsl:1@window"},
                                                      {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}})
                                       .wait();
  CHECK(outcome.exit_code == 3);
  CHECK(outcome.err.find("vrsl:1-9@/dev/video9") != std::string::npos);
}

}  // namespace footlight::tools

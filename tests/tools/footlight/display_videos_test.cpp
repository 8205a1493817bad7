// The videos of all displays of a rig.
#include "tools/footlight/displays/display_videos.h"

#include <cstdio>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tools/footlight/vrsl/video_output.h"

namespace footlight::tools {
namespace {

using testing::must;

constexpr DurationNs kPictureNs = 40 * kNsPerMs;

// Ten pictures, each of one grey.
void write_clip(const std::string& path) {
  drivers::PictureTarget target;
  target.endpoint = target.name = path;
  target.pictures_hz = 25;
  target.width = 64;
  target.height = 36;
  target.options = {{"lossless", "yes"}};
  const auto output = must(open_video_output(target));
  for (int i = 0; i < 10; ++i) {
    drivers::Picture picture;
    picture.clear(target.width, target.height);
    picture.rgb.assign(picture.rgb.size(), static_cast<std::uint8_t>(20 * i));
    must(output->show(picture, i * kPictureNs));
  }
  must(output->finish());
}

TEST_CASE("a video that cannot be read any more is closed, and the videos of other displays go on") {
  const testing::TempFolder folder;
  fixtures::Rig rig;
  for (const char* name : {"a.mkv", "b.mkv"}) {
    write_clip(folder.file(name));
    fixtures::Display display;
    display.name = name;
    display.columns = 4;
    display.rows = 2;
    display.video = fixtures::DisplayVideo{};
    display.video->path = folder.file(name);
    rig.displays.push_back(display);
  }
  DisplayVideos videos = must(DisplayVideos::open(rig, ClipPace::kExact));
  std::vector<std::size_t> given;
  const auto give = [&](std::size_t display, const std::shared_ptr<const fixtures::PaneImage>&) {
    given.push_back(display);
  };
  REQUIRE(videos.give_changes(5 * kPictureNs, give).has_value());
  CHECK(given == std::vector<std::size_t>{0, 1});
  REQUIRE(std::remove(folder.file("a.mkv").c_str()) == 0);
  given.clear();
  const Status failed = videos.give_changes(0, give);  // to go back, files are opened again
  REQUIRE_FALSE(failed.has_value());
  CHECK(failed.error().message.find("a.mkv") != std::string::npos);
  CHECK(given == std::vector<std::size_t>{1});
  given.clear();
  CHECK(videos.give_changes(kPictureNs, give).has_value());
  CHECK(given == std::vector<std::size_t>{1});
}

}  // namespace
}  // namespace footlight::tools

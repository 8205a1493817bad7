// The videos of all displays of a rig.
#include "tools/footlight/displays/display_videos.h"

#include <cstdio>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/clip_files.h"

namespace footlight::tools {
namespace {

using testing::must;

TEST_CASE("a video that cannot be read any more is closed, and the videos of other displays go on") {
  const testing::TempFolder folder;
  fixtures::Rig rig;
  for (const char* name : {"a.mkv", "b.mkv"}) {
    write_clip(folder.file(name), 10);
    rig.displays.push_back(display_of(folder.file(name)));
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

TEST_CASE("a rig whose displays with videos have other indices, pixels or files has other videos") {
  fixtures::Rig rig;
  rig.displays = {display_of("a.mkv"), fixtures::Display{}, display_of("b.mkv")};
  CHECK(same_videos(rig, rig));
  fixtures::Rig other = rig;
  other.displays[1].nits = 7;  // no video
  CHECK(same_videos(rig, other));
  other.displays.erase(other.displays.begin() + 1);
  CHECK_FALSE(same_videos(rig, other));
  other = rig;
  other.displays[2].columns += 1;
  CHECK_FALSE(same_videos(rig, other));
  other = rig;
  other.displays.pop_back();
  CHECK_FALSE(same_videos(other, rig));
}

}  // namespace
}  // namespace footlight::tools

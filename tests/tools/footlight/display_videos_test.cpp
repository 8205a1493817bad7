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

TEST_CASE("a video that cannot be read any more is closed, and those of other displays and projectors go on") {
  const testing::TempFolder folder;
  fixtures::Rig rig;
  for (const char* name : {"a.mkv", "b.mkv"}) write_clip(folder.file(name), 10);
  rig.displays.push_back(display_of(folder.file("a.mkv")));
  rig.projections.push_back(display_of(folder.file("b.mkv")));
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
  other = rig;
  other.projections.push_back(display_of("b.mkv"));  // of a projector
  CHECK_FALSE(same_videos(other, rig));
  CHECK(same_videos(other, other));
  other.displays[1].video.emplace();  // so the film of the projector is one place later
  CHECK_FALSE(same_videos(other, rig));
}

TEST_CASE("the videos of projectors stand at a time of the show, for the judge") {
  const testing::TempFolder folder;
  write_clip(folder.file("a.mkv"), 10);
  fixtures::Rig rig;
  rig.projections.push_back(display_of(folder.file("a.mkv")));
  testing::must(hold_videos(rig, 4 * kPictureNs));
  REQUIRE(rig.projections[0].image);
  const auto feed = testing::must(ClipFeed::open(display_of(folder.file("a.mkv")), ClipPace::kExact));
  CHECK(rig.projections[0].image->texels == testing::must(feed->at(4 * kPictureNs)).pixels->texels);
}

}  // namespace
}  // namespace footlight::tools

// What media servers show on displays: pixels of images, videos and pixel maps, and a frame that plays them.
#include "tools/footlight/displays/media_pictures.h"

#include <cstdio>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/gobos/png.h"
#include "render/frame.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/clip_files.h"
#include "tools/footlight/displays/display_videos.h"

namespace footlight::tools {
namespace {

using footlight::testing::HeadlessVulkan;
using testing::must;

constexpr std::size_t kContent = 2, kPlay = 3, kSpeed = 4;

// A server with an image (1), a video of ten pictures (2), a pixel map of universe 2 (3) and even light (4).
fixtures::Rig rig_in(const testing::TempFolder& folder) {
  write_clip(folder.file("a.mkv"), 10);
  const auto png = fixtures::png_of(2, 1, 3, std::vector<std::uint8_t>{255, 0, 0, 0, 255, 0});
  std::ofstream(folder.file("a.png"), std::ios::binary)
      << std::string(reinterpret_cast<const char*>(png.data()), png.size());
  return must(fixtures::parse_rig(
      "[rig]\nname = \"x\"\n[[fixture]]\nname = \"Server\"\ntype = \"generic/media-server\"\nuniverse = 1\n"
      "address = 1\nposition = [0, 0, 0]\nmedia = [\n{ number = 1, image = \"a.png\" },\n"
      "{ number = 2, video = \"a.mkv\" },\n{ number = 3, columns = 2, rows = 1, universe = 2 },\n{ number = 4 }]\n"
      "[[display]]\nposition = [0, 2, 1]\nwidth_m = 2\nheight_m = 1\ncolumns = 16\nrows = 8\nsource = \"Server\"\n"
      "[[display]]\nposition = [3, 2, 1]\nwidth_m = 2\nheight_m = 1\ncolumns = 2\nrows = 1\nsource = \"Server\"\n",
      folder.file("rig.toml")));
}

std::vector<std::uint8_t> levels_of(int content, int play = 0) {
  std::vector<std::uint8_t> levels(2 * 512, 0);
  levels[0] = 255, levels[kContent] = static_cast<std::uint8_t>(content);
  levels[kPlay] = static_cast<std::uint8_t>(play), levels[kSpeed] = 128;
  levels[5] = levels[6] = levels[7] = 255;
  levels[512] = 255, levels[512 + 4] = 255;  // red and green of the two pixels of the map
  return levels;
}

class Taken {
 public:
  GivePixels give() {
    return [this](std::size_t shown, const std::shared_ptr<const fixtures::PaneImage>& pixels) {
      ++times;
      of[shown] = *pixels;
    };
  }
  std::map<std::size_t, fixtures::PaneImage> of;
  int times = 0;
};

TEST_CASE("displays get a content in their own pixels, and nothing while nothing changes") {
  const testing::TempFolder folder;
  const fixtures::Rig rig = rig_in(folder);
  const auto player = fixtures::MediaPlayer::make(rig, must(fixtures::compile(rig)));
  MediaPictures pictures = must(MediaPictures::open(rig, ClipPace::kExact));
  Taken taken;
  const auto show = [&](const std::vector<std::uint8_t>& levels, DurationNs dt_ns) {
    player->step(levels, dt_ns);
    taken.times = 0;
    must(pictures.give_changes(*player, taken.give()));
    return taken.times;
  };
  CHECK(show(levels_of(0), 0) == 2);  // black
  CHECK(taken.of[0].texels == std::vector<glm::vec3>(16 * 8, glm::vec3(0)));
  CHECK(show(levels_of(1), 0) == 2);
  CHECK(taken.of[1].texels == std::vector<glm::vec3>{{1, 0, 0}, {0, 1, 0}});
  CHECK(taken.of[0].texels[7] == glm::vec3(1, 0, 0));
  CHECK(taken.of[0].texels[8] == glm::vec3(0, 1, 0));
  CHECK(show(levels_of(1), kPictureNs) == 0);
  CHECK(show(levels_of(3), 0) == 2);
  CHECK(taken.of[1].texels == std::vector<glm::vec3>{{1, 0, 0}, {0, 1, 0}});
  CHECK(show(levels_of(4), 0) == 2);
  CHECK(taken.of[1].texels == std::vector<glm::vec3>(2, glm::vec3(1)));
  auto half = levels_of(4);
  half[0] = 51;
  CHECK(show(half, 0) == 2);
  CHECK(taken.of[1].texels[0].g == doctest::Approx(0.2));
}

TEST_CASE("a video of a media server plays from when it is chosen, and loops as its content or its channel says") {
  const testing::TempFolder folder;
  const fixtures::Rig rig = rig_in(folder);
  const auto player = fixtures::MediaPlayer::make(rig, must(fixtures::compile(rig)));
  MediaPictures pictures = must(MediaPictures::open(rig, ClipPace::kExact));
  fixtures::Display as_shown = display_of(folder.file("a.mkv"));
  as_shown.columns = 16, as_shown.rows = 8;
  const auto feed = must(ClipFeed::open(as_shown, ClipPace::kExact));
  Taken taken;
  const auto shows = [&](int picture, DurationNs dt_ns, int play = 0) {
    player->step(levels_of(2, play), dt_ns);
    must(pictures.give_changes(*player, taken.give()));
    return taken.of[0].texels == must(feed->at_clip(picture * kPictureNs)).pixels->texels;
  };
  player->step(levels_of(1), 3 * kPictureNs);
  CHECK(shows(0, 0));
  CHECK(shows(4, 4 * kPictureNs));
  CHECK(shows(2, 8 * kPictureNs));        // looped
  CHECK(shows(9, 10 * kPictureNs, 70));   // once: the last picture
  CHECK(shows(0, kPictureNs, 130));       // stop
  CHECK(shows(8, 2 * kPictureNs, 170));   // reverse
  fixtures::Rig held = rig;
  must(hold_media(held, *player));
  REQUIRE(held.displays[0].image);
  CHECK(held.displays[0].image->texels == taken.of[0].texels);
  // A video that is gone is an error before the first picture.
  REQUIRE(std::remove(folder.file("a.mkv").c_str()) == 0);
  const auto none = MediaPictures::open(rig, ClipPace::kExact);
  REQUIRE_FALSE(none);
  CHECK(none.error().message.starts_with("[[fixture]] Server: media: video: "));
}

TEST_CASE("a frame draws what its media server plays, and its state keeps how far that is") {
  const testing::TempFolder folder;
  const fixtures::Rig rig = rig_in(folder);
  const fixtures::CompiledRig compiled = must(fixtures::compile(rig));
  HeadlessVulkan vulkan;
  render::FrameSettings settings;
  settings.width = 96, settings.height = 54;
  const auto frame = must(render::Frame::create(vulkan.device(), rig, compiled, settings));
  DisplayVideos videos = must(DisplayVideos::open(rig, ClipPace::kExact));
  const auto draw = [&] {
    must(videos.show(0, *frame));
    must(frame->draw(render::view_of(rig.cameras[0]), 8));
    return must(frame->read_radiance()).rgb;
  };
  frame->step(levels_of(0), 0);
  const auto dark = draw();
  frame->step(levels_of(2), 3 * kPictureNs);
  const auto third = draw();
  CHECK(third != dark);
  const render::FrameState kept = must(frame->save_state());
  frame->step(levels_of(2), 3 * kPictureNs);
  CHECK(draw() != third);
  must(frame->load_state(kept));
  CHECK(draw() == third);
}

}  // namespace
}  // namespace footlight::tools

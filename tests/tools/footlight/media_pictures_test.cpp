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

void write_png(const std::string& path, int width, int height, const std::vector<std::uint8_t>& rgb) {
  const auto png = fixtures::png_of(width, height, 3, rgb);
  std::ofstream(path, std::ios::binary) << std::string(reinterpret_cast<const char*>(png.data()), png.size());
}

// A server with an image (1), a video of ten pictures (2), a pixel map of universe 2 (3) and even light (4).
fixtures::Rig rig_in(const testing::TempFolder& folder) {
  write_clip(folder.file("a.mkv"), 10);
  write_png(folder.file("a.png"), 2, 1, {255, 0, 0, 0, 255, 0});
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

TEST_CASE("contents that are not shown are dropped where all together have more bytes than are kept") {
  const testing::TempFolder folder;
  const fixtures::Rig rig = must(fixtures::parse_rig(
      "[rig]\nname = \"x\"\n[[fixture]]\nname = \"Server\"\ntype = \"generic/media-server\"\nuniverse = 1\n"
      "address = 1\nposition = [0, 0, 0]\nmedia = [{ number = 1 }, { number = 2 }, { number = 3 }]\n"
      "[[display]]\nposition = [0, 2, 1]\nwidth_m = 2\nheight_m = 1\ncolumns = 8\nrows = 4\nsource = \"Server\"\n",
      folder.file("rig.toml")));
  constexpr std::uint64_t kBytes = 8 * 4 * sizeof(glm::vec3);  // of a content
  for (const auto& [kept, after] : {std::pair(kSourceBytesKept, 3 * kBytes), {2 * kBytes, kBytes}}) {
    const auto player = fixtures::MediaPlayer::make(rig, must(fixtures::compile(rig)));
    MediaPictures pictures = must(MediaPictures::open(rig, ClipPace::kExact, kept));
    Taken taken;
    for (const int number : {1, 2, 3}) {
      player->step(levels_of(number), 0);
      must(pictures.give_changes(*player, taken.give()));
      CHECK(taken.of[0].texels == std::vector<glm::vec3>(8 * 4, glm::vec3(1)));
      CHECK(pictures.bytes() == (number == 3 ? after : static_cast<std::uint64_t>(number) * kBytes));
    }
  }
}

// A wall of 8 x 4 pixels, and a server with a picture of 16 x 8, of which each second pixel is white (1), the same in
// the quarter at the top right (2), even light (3) and a video (4).
fixtures::Rig placed_rig(const testing::TempFolder& folder) {
  write_clip(folder.file("a.mkv"), 3);
  std::vector<std::uint8_t> fine;
  for (int i = 0; i < 16 * 8; ++i) fine.insert(fine.end(), 3, (i + i / 16) % 2 == 0 ? 255 : 0);
  write_png(folder.file("a.png"), 16, 8, fine);
  return must(fixtures::parse_rig(
      "[rig]\nname = \"x\"\n[[fixture]]\nname = \"Server\"\ntype = \"generic/media-server\"\nmode = \"70 channels\"\n"
      "universe = 1\naddress = 1\nposition = [0, 0, 0]\nmedia = [\n{ number = 1, image = \"a.png\" },\n"
      "{ number = 2, image = \"a.png\", place = [0.25, 0.25], scale = 0.5 },\n{ number = 3 },\n"
      "{ number = 4, video = \"a.mkv\" }]\n"
      "[[display]]\nposition = [0, 2, 1]\nwidth_m = 2\nheight_m = 1\ncolumns = 8\nrows = 4\nsource = \"Server\"\n",
      folder.file("rig.toml")));
}

// Levels of "70 channels" with the first two layers.
struct LayerLevels {
  int content = 0, right = 128, up = 128, scale = 64, turn = 128, blend = 0, dimmer = 255;
};
std::vector<std::uint8_t> levels_of(const LayerLevels& below, const LayerLevels& above) {
  std::vector<std::uint8_t> levels(512, 0);
  levels[0] = 255;
  std::size_t at = 1;
  for (const LayerLevels* layer : {&below, &above}) {
    const auto set = [&](std::size_t slot, int level) { levels[at + slot] = static_cast<std::uint8_t>(level); };
    set(0, layer->dimmer), set(2, layer->content), set(4, 128), set(5, 255), set(6, 255), set(7, 255);
    set(8, layer->right), set(10, layer->up), set(12, layer->scale), set(14, layer->turn), set(16, layer->blend);
    at += 17;
  }
  return levels;
}

TEST_CASE("layers are where their channels place them, with all pixels of their content, over those below") {
  const testing::TempFolder folder;
  const fixtures::Rig rig = placed_rig(folder);
  const auto player = fixtures::MediaPlayer::make(rig, must(fixtures::compile(rig)));
  MediaPictures pictures = must(MediaPictures::open(rig, ClipPace::kExact));
  Taken taken;
  const auto show = [&](const LayerLevels& below, const LayerLevels& above = {}) {
    player->step(levels_of(below, above), 0);
    taken.times = 0;
    must(pictures.give_changes(*player, taken.give()));
    return taken.of[0].texels;
  };
  const auto grey = [](float light) { return std::vector<glm::vec3>(8 * 4, glm::vec3(light)); };
  CHECK(show({.content = 1}) == grey(0.5f));  // a pixel of the wall covers four of the image
  CHECK(show({.content = 1}) == grey(0.5f));
  CHECK(taken.times == 0);
  // Twice as large, each pixel of the wall is one of the image: the middle quarter.
  std::vector<glm::vec3> fine;
  for (int i = 0; i < 8 * 4; ++i) fine.emplace_back((i + i / 8) % 2 == 0 ? 1.0f : 0.0f);
  CHECK(show({.content = 1, .scale = 128}) == fine);
  // Half as large, and a quarter of a width to the right.
  const auto placed = show({.content = 3, .right = 160, .scale = 32});
  for (int i = 0; i < 8 * 4; ++i) {
    CHECK(placed[static_cast<std::size_t>(i)].r == (i % 8 >= 4 && i / 8 >= 1 && i / 8 < 3 ? 1.0f : 0.0f));
  }
  CHECK(show({.content = 3, .scale = 0}) == grey(0));
  CHECK(show({.content = 3, .right = 255, .scale = 32}) == grey(0));  // off the wall
  // A content with a place of its own, over even light of half.
  const auto over = show({.content = 3, .dimmer = 128}, {.content = 2});
  const float half = over[0].r;
  CHECK(half == doctest::Approx(128.0 / 255));
  for (int i = 0; i < 8 * 4; ++i) {
    CHECK(over[static_cast<std::size_t>(i)].r == (i % 8 >= 4 && i / 8 < 2 ? 0.5f : half));
  }
  // Its layer moves it as a whole: to the middle, twice as large, it fills the wall.
  CHECK(show({.content = 2, .right = 64, .up = 64, .scale = 128}) == grey(0.5f));
  const auto added = show({.content = 3, .dimmer = 128}, {.content = 2, .blend = 40});
  CHECK(added[7].r == doctest::Approx(1));
  CHECK(added[0].r == half);
  // Turned by half a turn it is at the bottom left.
  const auto turned = show({.content = 2, .turn = 192});
  CHECK(turned[3 * 8].r == doctest::Approx(0.5));
  CHECK(turned[7].r == 0);
}

TEST_CASE("a dimmer of a placed layer mixes pixels that stay, and a video in one has pixels to be enlarged") {
  const testing::TempFolder folder;
  const fixtures::Rig rig = placed_rig(folder);
  const auto player = fixtures::MediaPlayer::make(rig, must(fixtures::compile(rig)));
  MediaPictures pictures = must(MediaPictures::open(rig, ClipPace::kExact));
  Taken taken;
  const auto show = [&](const LayerLevels& layer) {
    player->step(levels_of(layer, {}), 0);
    must(pictures.give_changes(*player, taken.give()));
    return taken.of[0];
  };
  const auto whole = show({.content = 1, .scale = 40, .turn = 140});
  const auto dimmed = show({.content = 1, .scale = 40, .turn = 140, .dimmer = 51});
  for (std::size_t i = 0; i < whole.texels.size(); ++i) {
    CHECK(dimmed.texels[i].g == doctest::Approx(0.2 * whole.texels[i].g));
  }
  fixtures::Display as_shown = display_of(folder.file("a.mkv"));
  as_shown.columns = 960, as_shown.rows = 540;
  const auto feed = must(ClipFeed::open(as_shown, ClipPace::kExact));
  const auto large = show({.content = 4, .scale = 255});
  fixtures::PicturePlace place;
  place.scale = glm::dvec2(255 / 64.0);
  const auto expected = mapped(*must(feed->at_clip(0)).pixels, map_of(place, 2), 8, 4).light;
  CHECK(large.texels == expected.texels);
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

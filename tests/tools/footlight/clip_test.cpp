// Videos on displays: their light against a judge in double, their pictures at any time in any order, damaged files.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <thread>

#include <doctest/doctest.h>

#include "fixtures/model/srgb.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tests/support/wav_bytes.h"
#include "tests/tools/footlight/clip_files.h"
#include "tools/footlight/displays/clip.h"
#include "tools/footlight/displays/clip_feed.h"
#include "tools/footlight/displays/picture_light.h"

namespace footlight::tools {
namespace {

using drivers::Picture;
using fixtures::PaneImage;
using testing::must;
using testing::TempFolder;

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
void write_bytes(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }
bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
std::string error_of(const std::string& path) {
  const auto clip = Clip::open(path);
  return clip ? "no error" : clip.error().message;
}

// ---- Light against the judge ----

// The mean of the light of a rectangle of the picture, in double, by the area that it covers of each pixel.
glm::dvec3 judged(const Picture& picture, double gamma, double x0, double x1, double y0, double y1) {
  const auto light = [&](std::uint8_t code) {
    const double share = code / 255.0;
    return gamma > 0 ? std::pow(share, gamma) : fixtures::linear_of_srgb(share);
  };
  glm::dvec3 sum(0);
  double area = 0;
  for (int y = static_cast<int>(y0); y < std::min<double>(std::ceil(y1), picture.height); ++y) {
    for (int x = static_cast<int>(x0); x < std::min<double>(std::ceil(x1), picture.width); ++x) {
      const double part = (std::min<double>(x + 1, x1) - std::max<double>(x, x0)) *
                          (std::min<double>(y + 1, y1) - std::max<double>(y, y0));
      const std::uint8_t* const at = picture.view().at(x, y);
      sum += part * glm::dvec3(light(at[0]), light(at[1]), light(at[2]));
      area += part;
    }
  }
  return sum / area;
}

// The largest difference of a pixel from the judge, as a share of white.
double worst(const Picture& picture, double gamma, int columns, int rows) {
  const PaneImage light = light_of(picture, light_curve(gamma), columns, rows);
  REQUIRE(light.texels.size() == static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const double wide = static_cast<double>(picture.width) / columns, high = static_cast<double>(picture.height) / rows;
  double most = 0;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const glm::dvec3 is(light.texels[static_cast<std::size_t>(y * columns + x)]);
      const glm::dvec3 off = glm::abs(is - judged(picture, gamma, x * wide, (x + 1) * wide, y * high, (y + 1) * high));
      most = std::max({most, off.r, off.g, off.b});
    }
  }
  return most;
}

glm::dvec3 mean_of(const PaneImage& light) {
  glm::dvec3 sum(0);
  for (const glm::vec3& texel : light.texels) sum += glm::dvec3(texel);
  return sum / static_cast<double>(light.texels.size());
}

void print_error(const char* what, double error) {
  if (std::getenv("FOOTLIGHT_PRINT_ERRORS") != nullptr) std::printf("%-44s %.2e\n", what, error);
}

TEST_CASE("the light of a display's pixels is that of the picture within 1e-5 of white, for any number of pixels") {
  const Picture picture = picture_of(7, 160, 90);
  double most = 0;
  for (const double gamma : {0.0, 1.0, 2.4}) {
    for (const auto& [columns, rows] : {std::pair{160, 90}, {80, 45}, {48, 27}, {7, 5}, {1, 1}, {161, 91}, {400, 3}}) {
      CAPTURE(columns);
      const double error = worst(picture, gamma, columns, rows);
      CHECK(error < 1e-5);
      most = std::max(most, error);
    }
  }
  print_error("light of a picture, worst pixel", most);
  const double large = worst(picture_of(3, 1920, 1080), 0, 1, 1);
  CHECK(large < 1e-5);
  print_error("light of 1920x1080 as one pixel", large);
}

TEST_CASE("a lossless clip has the light of the pictures that it was made of, and a usual one nearly") {
  const TempFolder folder;
  write_clip(folder.file("a.mkv"), 3);
  write_clip(folder.file("b.mp4"), 3, 320, 180, {});
  const LightCurve256 curve = light_curve(0);
  for (const auto& [name, width, height, most] :
       {std::tuple{"a.mkv", 160, 90, 1e-5}, std::tuple{"b.mp4", 320, 180, 2e-2}}) {
    const auto clip = must(Clip::open(folder.file(name)));
    REQUIRE(clip->count() == 3);
    double worst = 0;
    for (int i = 0; i < 3; ++i) {
      const Picture& decoded = *must(clip->picture(static_cast<std::size_t>(i)));
      const glm::dvec3 mean = mean_of(light_of(decoded, curve, 32, 18));
      const glm::dvec3 off = glm::abs(mean - judged(picture_of(i, width, height), 0, 0, width, 0, height));
      worst = std::max({worst, off.r, off.g, off.b});
    }
    CHECK(worst < most);
    print_error(name, worst);
  }
}

TEST_CASE("times of pictures of 1920x1080") {
  const TempFolder folder;
  const int count = 6;
  write_clip(folder.file("a.mp4"), count, 1920, 1080, {});
  const auto clip = must(Clip::open(folder.file("a.mp4")));
  const LightCurve256 curve = light_curve(0);
  std::array<double, 3> ms{};
  const auto timed = [](double& sum, const auto& work) {
    const std::clock_t before = std::clock();
    work();
    sum += 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC / count;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Picture* picture = nullptr;
    timed(ms[0], [&] { picture = must(clip->picture(i)); });
    timed(ms[1], [&] { CHECK(light_of(*picture, curve, 480, 270).width == 480); });
    timed(ms[2], [&] { CHECK(light_of(*picture, curve, 1920, 1080).width == 1920); });
  }
  print_error("ms to decode 1920x1080", ms[0]);
  print_error("ms for the light of 480x270 pixels", ms[1]);
  print_error("ms for the light of 1920x1080 pixels", ms[2]);
  CHECK(clip->replaced() == 0);
}

// ---- Pictures in any order ----

TEST_CASE("a clip gives the same picture for a number in any order, and none is missed") {
  const TempFolder folder;
  for (const char* const name : {"a.mkv", "a.mp4", "a.ts"}) {
    CAPTURE(std::string(name));
    write_clip(folder.file(name), 70);  // key pictures: 0, 25, 50
    const auto clip = must(Clip::open(folder.file(name)));
    REQUIRE(clip->count() == 70);
    CHECK(std::abs(clip->duration_ns() - 70 * kPictureNs) <= kNsPerMs);
    std::mt19937 random(3);  // NOLINT(bugprone-random-generator-seed)
    std::vector<std::size_t> order = {0, 1, 2, 69, 68, 0, 30, 31, 29, 50, 49, 25, 24};
    for (int i = 0; i < 12; ++i) order.push_back(random() % 70);
    for (const std::size_t number : order) {
      CAPTURE(number);
      CHECK(must(clip->picture(number))->rgb == picture_of(static_cast<int>(number), 160, 90).rgb);
    }
    CHECK(clip->replaced() == 0);
    for (int i = 0; i < 70; ++i) {
      CHECK(clip->index_at(i * kPictureNs) == static_cast<std::size_t>(i));
      CHECK(clip->index_at(i * kPictureNs + kPictureNs - 2 * kNsPerMs) == static_cast<std::size_t>(i));
    }
    CHECK(clip->index_at(-kNsPerS) == 0);
    CHECK(clip->index_at(kNsPerS * 1000) == 69);
  }
}

TEST_CASE("the time of a clip follows that of the show by start_s, speed and loop") {
  const DurationNs length = 2 * kNsPerS;
  fixtures::DisplayVideo video;
  CHECK(clip_time_ns(video, 0, length) == 0);
  CHECK(clip_time_ns(video, length - 1, length) == length - 1);
  CHECK(clip_time_ns(video, length, length) == 0);
  CHECK(clip_time_ns(video, 3'600 * kNsPerS + 7, length) == 7);
  CHECK(clip_time_ns(video, -1, length) == length - 1);  // a log may begin before 0
  video.start_s = 1.5;
  CHECK(clip_time_ns(video, kNsPerS, length) == kNsPerS / 2);
  video.speed = 0.25;
  CHECK(clip_time_ns(video, kNsPerS, length) == 1'750 * kNsPerMs);
  video.speed = 0;
  CHECK(clip_time_ns(video, 1234 * kNsPerS, length) == 1'500 * kNsPerMs);
  video = {.path = "", .start_s = 0.5, .speed = 2, .loop = false, .gamma = 0};
  CHECK(clip_time_ns(video, kNsPerS / 2, length) == 1'500 * kNsPerMs);
  CHECK(clip_time_ns(video, 100 * kNsPerS, length) == length - 1);
  CHECK(clip_time_ns(video, -100 * kNsPerS, length) == 0);
}

TEST_CASE("a clip of one picture shows it at any time") {
  const TempFolder folder;
  write_clip(folder.file("one.mkv"), 1);
  const auto clip = must(Clip::open(folder.file("one.mkv")));
  CHECK(clip->count() == 1);
  CHECK(clip->duration_ns() > 0);
  for (const DurationNs time_ns : {DurationNs{0}, kNsPerS, 3'600 * kNsPerS}) {
    CHECK(must(clip->picture(clip->index_at(clip_time_ns({}, time_ns, clip->duration_ns()))))->rgb ==
          picture_of(0, 160, 90).rgb);
  }
}

// ---- Files that are wrong ----

TEST_CASE("a file that is no video of a display is said to be so, with its name and the next step") {
  const TempFolder folder;
  CHECK(has(error_of(folder.file("none.mp4")), "none.mp4: there is no such file"));
  write_bytes(folder.file("text.mp4"), std::string(5'000, 'x'));
  CHECK(has(error_of(folder.file("text.mp4")), "text.mp4: cannot be read as video"));
  write_bytes(folder.file("empty.mp4"), "");
  CHECK(has(error_of(folder.file("empty.mp4")), "empty.mp4: cannot be read as video"));
  write_bytes(folder.file("sound.wav"), testing::wav_bytes(std::vector<float>(4'800, 0.1f), 1, 48'000));
  CHECK(has(error_of(folder.file("sound.wav")), "sound.wav: has no video, only other streams; use a file with"));
  CHECK(error_of(folder.path().string()) != "no error");
  write_clip(folder.file("part.mkv"), 2);
  write_bytes(folder.file("list.mp4"), "ffconcat version 1.0\nfile part.mkv\n");
  CHECK(has(error_of(folder.file("list.mp4")), "list.mp4: a list of other files (concat): expected one file"));
}

TEST_CASE("damaged pictures are replaced by the last whole one before them, in any order, and counted") {
  const TempFolder folder;
  write_clip(folder.file("a.mkv"), 70);
  std::string bytes = bytes_of(folder.file("a.mkv"));
  for (std::size_t i = bytes.size() / 6; i < bytes.size() / 6 + 400; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  write_bytes(folder.file("b.mkv"), bytes);
  const auto in_order = must(Clip::open(folder.file("b.mkv")));
  std::vector<Picture> shown;
  for (std::size_t i = 0; i < in_order->count(); ++i) shown.push_back(*must(in_order->picture(i)));
  CHECK(in_order->replaced() > 0);
  CHECK(in_order->replaced() < 30);
  for (const Picture& picture : shown) {
    const bool known = std::any_of(std::begin(shown), std::end(shown), [&](const Picture&) {
      for (int i = 0; i < 70; ++i) {
        if (picture.rgb == picture_of(i, 160, 90).rgb) return true;
      }
      return false;
    });
    CHECK(known);
  }
  CHECK(shown.back().rgb == picture_of(69, 160, 90).rgb);
  const auto backwards = must(Clip::open(folder.file("b.mkv")));
  REQUIRE(backwards->count() == shown.size());
  for (std::size_t i = shown.size(); i-- > 0;) {
    CAPTURE(i);
    CHECK(must(backwards->picture(i))->rgb == shown[i].rgb);
  }
}

TEST_CASE("a clip that was cut off shows what it has") {
  const TempFolder folder;
  write_clip(folder.file("a.mkv"), 70);
  const std::string bytes = bytes_of(folder.file("a.mkv"));
  write_bytes(folder.file("cut.mkv"), bytes.substr(0, bytes.size() / 2));
  const auto clip = must(Clip::open(folder.file("cut.mkv")));
  REQUIRE(clip->count() > 10);
  CHECK(clip->count() < 60);
  for (std::size_t i = 0; i + 1 < clip->count(); ++i) {
    CHECK(must(clip->picture(i))->rgb == picture_of(static_cast<int>(i), 160, 90).rgb);
  }
  CHECK(clip->picture(clip->count() - 1).has_value());  // of it a part may be missing
}

TEST_CASE("no damage makes a clip fail in any other way than by an error") {
  const TempFolder folder;
  std::mt19937 random(7);  // NOLINT(bugprone-random-generator-seed)
  for (const char* const name : {"a.mp4", "a.mkv"}) {
    write_clip(folder.file(name), 30, 64, 36);
    const std::string whole = bytes_of(folder.file(name));
    for (int round = 0; round < 20; ++round) {
      std::string bytes = round % 2 == 0 ? whole : whole.substr(0, 1 + random() % whole.size());
      for (int i = 0; i < 1 + round; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
      write_bytes(folder.file("b.mkv"), bytes);
      const auto clip = Clip::open(folder.file("b.mkv"));
      if (!clip) {
        CHECK(has(clip.error().message, "b.mkv"));
        continue;
      }
      for (int i = 0; i < 20; ++i) {
        const auto picture = (*clip)->picture(random() % (*clip)->count());
        if (!picture) CHECK(has(picture.error().message, "b.mkv"));
        if (!picture) break;
      }
    }
  }
}

// ---- Pictures for displays ----

// Asks until the light of this number is there.
ClipLight wait_for(ClipFeed& feed, DurationNs show_ns, std::size_t index) {
  for (int i = 0; i < 5'000; ++i) {
    const ClipLight light = must(feed.at(show_ns));
    if (light.pixels && light.index == index) return light;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return {};
}

TEST_CASE("a feed that decodes ahead comes to the pictures of an exact one, forwards, at the loop and after jumps") {
  const TempFolder folder;
  write_clip(folder.file("a.mkv"), 30);
  const fixtures::Display display = display_of(folder.file("a.mkv"));
  const auto exact = must(ClipFeed::open(display, ClipPace::kExact));
  const auto ahead = must(ClipFeed::open(display, ClipPace::kAhead));
  for (const int number : {0, 1, 2, 3, 27, 28, 29, 30, 31, 45, 12, 59, 60, 3'000'000}) {
    CAPTURE(number);
    const ClipLight right = must(exact->at(number * kPictureNs));
    CHECK(right.index == static_cast<std::size_t>(number % 30));
    const ClipLight light = wait_for(*ahead, number * kPictureNs, right.index);
    REQUIRE(light.pixels);
    CHECK(light.pixels->texels == right.pixels->texels);
  }
  // The same picture is the same object: nothing is computed again.
  CHECK(must(exact->at(5 * kPictureNs)).pixels == must(exact->at(5 * kPictureNs + kNsPerMs)).pixels);
}

TEST_CASE("as many pictures are decoded ahead as have room in 160 MiB, but two to four") {
  CHECK(pictures_ahead(16, 9) == 4);
  CHECK(pictures_ahead(1920, 1080) == 4);
  CHECK(pictures_ahead(2560, 1440) == 3);
  CHECK(pictures_ahead(3840, 2160) == 2);
  CHECK(pictures_ahead(4096, 4096) == 2);
  const TempFolder folder;
  write_clip(folder.file("a.mkv"), 30);
  fixtures::Display display = display_of(folder.file("a.mkv"));
  const auto bytes_of_pictures = [&](ClipPace pace) {
    const std::uint64_t pixels = static_cast<std::uint64_t>(display.columns) * static_cast<std::uint64_t>(display.rows);
    return must(ClipFeed::open(display, pace))->bytes_most() / (pixels * sizeof(glm::vec3));
  };
  CHECK(bytes_of_pictures(ClipPace::kAhead) == 5);
  CHECK(bytes_of_pictures(ClipPace::kExact) == 2);
  display.columns = 3840;
  display.rows = 2160;
  CHECK(bytes_of_pictures(ClipPace::kAhead) == 3);
}

TEST_CASE("after a jump back a feed that decodes ahead shows the last picture until the right one is ready") {
  const TempFolder folder;
  write_clip(folder.file("a.mkv"), 60);
  const auto ahead = must(ClipFeed::open(display_of(folder.file("a.mkv")), ClipPace::kAhead));
  for (int round = 0; round < 10; ++round) {
    CAPTURE(round);
    // Each picture that is there shows that those after it are decoded meanwhile.
    for (int number = 30; number < 34; ++number) {
      (void)wait_for(*ahead, number * kPictureNs, static_cast<std::size_t>(number));
    }
    for (ClipLight light = must(ahead->at(3 * kPictureNs)); light.index != 3; light = must(ahead->at(3 * kPictureNs))) {
      REQUIRE(light.index == 33);
      std::this_thread::yield();
    }
  }
}

TEST_CASE("a feed that decodes ahead shows no picture before its time, through the loop") {
  const TempFolder folder;
  write_clip(folder.file("a.mkv"), 30);
  const auto ahead = must(ClipFeed::open(display_of(folder.file("a.mkv")), ClipPace::kAhead));
  std::size_t before = wait_for(*ahead, 20 * kPictureNs, 20).index;
  for (int number = 21; number < 70; ++number) {
    CAPTURE(number);
    const auto right = static_cast<std::size_t>(number % 30);
    const auto next = [&] { return must(ahead->at(number * kPictureNs)).index; };
    for (std::size_t index = next(); index != right; index = next()) {
      REQUIRE(index == before);
      std::this_thread::yield();
    }
    // While the time stands still, those after it are decoded, and the picture stays.
    for (int i = 0; i < 10; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      REQUIRE(next() == right);
    }
    before = right;
  }
}

TEST_CASE("a feed that decodes ahead can end at any moment") {
  const TempFolder folder;
  write_clip(folder.file("a.mkv"), 30);
  for (int i = 0; i < 20; ++i) {
    const auto feed = must(ClipFeed::open(display_of(folder.file("a.mkv")), ClipPace::kAhead));
    for (int k = 0; k < i; ++k) CHECK(feed->at(k * 7 * kPictureNs).has_value());
  }
}

}  // namespace
}  // namespace footlight::tools

// Grids through H.264 and back, whole files and damaged ones.
#include <doctest/doctest.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include <nlohmann/json.hpp>

#include "drivers/fd.h"
#include "drivers/vrsl/grid.h"
#include "sim/dmx_log/log_input.h"
#include "tests/sim/sound/tones.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tests/support/wav_bytes.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/vrsl/open_pictures.h"
#include "tools/footlight/vrsl/png_pictures.h"
#include "tools/footlight/vrsl/video_output.h"
#include "tools/footlight/vrsl/video_reader.h"
#include "tools/footlight/vrsl/yuv.h"

namespace footlight::tools {
namespace {

using drivers::GridCodec;
using drivers::GridFormat;
using drivers::GridPlanes;
using drivers::GridReading;
using drivers::Picture;
using drivers::PictureStep;
using testing::must;
using testing::TempFolder;
using Levels = std::vector<std::uint8_t>;

constexpr int kWidth = 960, kHeight = 104;  // a grid alone, with cells of 8 pixels
constexpr double kHz = 60;
// Levels of pictures that have nothing in common with the one before, in cells of 8 pixels, at the default quality:
// 8 were measured. Levels of another picture differ by up to 255.
constexpr int kWithin = 12;

GridCodec codec_of(GridPlanes planes) {
  GridFormat format;
  format.planes = planes;
  format.width = kWidth;
  format.height = kHeight;
  return must(GridCodec::make(format));
}

Levels random_levels(unsigned seed, int universes) {
  std::mt19937 random(seed);
  Levels levels(static_cast<std::size_t>(universes) * kSlotCountMax);
  for (std::uint8_t& level : levels) level = static_cast<std::uint8_t>(random());
  return levels;
}

drivers::PictureTarget target_of(const std::string& name, std::vector<EndpointOption> options = {}) {
  drivers::PictureTarget target;
  target.endpoint = "vrsl:1-9@" + name;
  target.name = name;
  target.pictures_hz = kHz;
  target.width = kWidth;
  target.height = kHeight;
  target.options = std::move(options);
  return target;
}

DurationNs time_of(int picture) { return std::llround(picture * 1e9 / kHz); }

// Pictures of random levels, a new one each time.
void write_video(const std::string& path, int count, GridPlanes planes, std::vector<EndpointOption> options = {}) {
  const GridCodec codec = codec_of(planes);
  const auto output = must(open_video_output(target_of(path, std::move(options))));
  Picture picture;
  for (int i = 0; i < count; ++i) {
    codec.encode(random_levels(static_cast<unsigned>(i), codec.universe_count()), picture);
    REQUIRE(output->show(picture, time_of(i)).has_value());
  }
  REQUIRE(output->finish().has_value());
}

struct ReadVideo {
  std::vector<Levels> levels;
  std::vector<DurationNs> times_ns;
  VideoCounters counters;
};

ReadVideo read_video(VideoReader& reader, GridPlanes planes) {
  const GridCodec codec = codec_of(planes);
  ReadVideo video;
  Picture picture;
  while (true) {
    std::optional<DurationNs> time_ns;
    const auto step = must(reader.next(picture, time_ns, 0));
    if (step == PictureStep::kEnd) break;
    REQUIRE(step == PictureStep::kPicture);
    GridReading reading;
    Levels& levels = video.levels.emplace_back(static_cast<std::size_t>(codec.universe_count()) * kSlotCountMax);
    REQUIRE(codec.decode(picture.view(), levels, reading).has_value());
    video.times_ns.push_back(time_ns.value_or(-1));
  }
  video.counters = reader.counters();
  return video;
}

ReadVideo read_video(const std::string& path, GridPlanes planes) {
  return read_video(*must(VideoReader::open(path)), planes);
}

int largest_error(const Levels& a, const Levels& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

}  // namespace

TEST_CASE("greys cross luma of full range exactly, and of limited range with at most one level lost") {
  Picture from, to;
  from.clear(512, 2);
  for (int i = 0; i < 512; ++i) {
    for (int y = 0; y < 2; ++y) std::fill_n(from.at(i, y), 3, static_cast<std::uint8_t>(i / 2));
  }
  for (const bool full : {true, false}) {
    std::vector<std::uint8_t> luma(1024), u(256), v(256);
    const YuvCoding coding{YuvMatrix::kBt709, full};
    RgbToYuv(coding).convert(from.view(), {{luma.data(), u.data(), v.data()}, {512, 256, 256}});
    YuvView view{{luma.data(), u.data(), v.data()}, {512, 256, 256}};
    view.width = 512;
    view.height = 2;
    to.clear(512, 2);
    YuvToRgb(coding).convert(view, 0, 2, to);
    int lost = 0;
    for (std::size_t i = 0; i < from.rgb.size(); ++i) lost = std::max(lost, std::abs(from.rgb[i] - to.rgb[i]));
    CHECK(lost == (full ? 0 : 1));
  }
}

TEST_CASE("colours of blocks cross both matrices with at most two levels lost") {
  std::mt19937 random(3);  // NOLINT(bugprone-random-generator-seed)
  Picture from, to;
  from.clear(256, 64);
  for (int y = 0; y < 64; y += 2) {
    for (int x = 0; x < 256; x += 2) {
      for (int i = 0; i < 3; ++i) {
        const auto level = static_cast<std::uint8_t>(random());
        for (const int k : {0, 1, 2, 3}) from.at(x + k % 2, y + k / 2)[i] = level;
      }
    }
  }
  for (const YuvMatrix matrix : {YuvMatrix::kBt601, YuvMatrix::kBt709}) {
    std::vector<std::uint8_t> luma(256 * 64), u(128 * 32), v(128 * 32);
    RgbToYuv({matrix, true}).convert(from.view(), {{luma.data(), u.data(), v.data()}, {256, 128, 128}});
    YuvView view{{luma.data(), u.data(), v.data()}, {256, 128, 128}};
    view.width = 256;
    view.height = 64;
    to.clear(256, 64);
    YuvToRgb({matrix, true}).convert(view, 0, 64, to);
    CHECK(largest_error(from.rgb, to.rgb) <= 2);
  }
}

TEST_CASE("a lossless video has every level and time of nine universes") {
  const TempFolder folder;
  write_video(folder.file("a.mkv"), 5, GridPlanes::kRgb, {{"lossless", "yes"}});
  const ReadVideo video = read_video(folder.file("a.mkv"), GridPlanes::kRgb);
  REQUIRE(video.levels.size() == 5);
  for (unsigned i = 0; i < 5; ++i) CHECK(video.levels[i] == random_levels(i, 9));
  for (int i = 0; i < 5; ++i) CHECK(std::abs(video.times_ns[static_cast<std::size_t>(i)] - time_of(i)) <= kNsPerMs);
  CHECK(video.counters.damaged == 0);
}

TEST_CASE("H.264 at its default quality keeps the levels of new pictures, as .mp4 and as .mkv") {
  const TempFolder folder;
  for (const char* const name : {"a.mp4", "a.mkv"}) {
    CAPTURE(name);
    write_video(folder.file(name), 4, GridPlanes::kLuma);
    const ReadVideo video = read_video(folder.file(name), GridPlanes::kLuma);
    REQUIRE(video.levels.size() == 4);
    for (unsigned i = 0; i < 4; ++i) CHECK(largest_error(video.levels[i], random_levels(i, 3)) <= kWithin);
    CHECK_FALSE(std::filesystem::exists(folder.file(name) + ".part"));
  }
}

TEST_CASE("a video states what it is") {
  const TempFolder folder;
  write_video(folder.file("a.mp4"), 30, GridPlanes::kLuma, {{"luma", "full"}});
  const auto reader = must(VideoReader::open(folder.file("a.mp4")));
  CHECK(reader->facts().codec == "h264");
  CHECK(reader->facts().width == kWidth);
  CHECK(reader->facts().range == "pc");
  CHECK(reader->facts().matrix == "bt709");
  CHECK(reader->facts().pictures_hz == doctest::Approx(kHz).epsilon(0.01));
  CHECK(std::abs(reader->facts().duration_ns.value_or(0) - kNsPerS / 2) < 20 * kNsPerMs);
}

TEST_CASE("a cut .mkv gives the pictures before the cut, and a cut .mp4 an error with the next step") {
  const TempFolder folder;
  write_video(folder.file("a.mkv"), 6, GridPlanes::kLuma);
  const std::string whole = bytes_of(folder.file("a.mkv"));
  write_bytes(folder.file("cut.mkv"), whole.substr(0, whole.size() / 2));
  const ReadVideo video = read_video(folder.file("cut.mkv"), GridPlanes::kLuma);
  CHECK(video.levels.size() >= 1);
  CHECK(video.levels.size() < 6);
  write_video(folder.file("a.mp4"), 6, GridPlanes::kLuma);
  const std::string other = bytes_of(folder.file("a.mp4"));
  write_bytes(folder.file("cut.mp4"), other.substr(0, other.size() / 2));
  const auto cut = VideoReader::open(folder.file("cut.mp4"));
  REQUIRE_FALSE(cut.has_value());
  CHECK(cut.error().message.find("index") != std::string::npos);
}

TEST_CASE("a damaged picture and those that build on it are counted and not returned") {
  const TempFolder folder;
  write_video(folder.file("a.mkv"), 90, GridPlanes::kLuma);  // key pictures: 0, 60
  std::string bytes = bytes_of(folder.file("a.mkv"));
  for (std::size_t i = bytes.size() / 6; i < bytes.size() / 6 + 400; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  write_bytes(folder.file("damaged.mkv"), bytes);
  const ReadVideo video = read_video(folder.file("damaged.mkv"), GridPlanes::kLuma);
  CHECK(video.counters.damaged > 0);
  CHECK(video.counters.damaged < 61);
  CHECK(video.levels.size() >= 29);
  // Those that are returned are pictures that were sent.
  for (std::size_t i = 0; i < video.levels.size(); ++i) {
    const auto number = static_cast<unsigned>(std::lround(static_cast<double>(video.times_ns[i]) * kHz / 1e9));
    CHECK(largest_error(video.levels[i], random_levels(number, 3)) <= kWithin);
  }
}

TEST_CASE("no damage makes the reader fail in any other way than by an error or fewer pictures") {
  const TempFolder folder;
  std::mt19937 random(7);  // NOLINT(bugprone-random-generator-seed)
  for (const char* const name : {"a.mp4", "a.mkv"}) {
    write_video(folder.file(name), 4, GridPlanes::kLuma);
    const std::string whole = bytes_of(folder.file(name));
    for (int round = 0; round < 25; ++round) {
      std::string bytes = whole.substr(0, 1 + random() % whole.size());
      for (int i = 0; i < 1 + round; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
      write_bytes(folder.file("b.mkv"), bytes);
      const auto reader = VideoReader::open(folder.file("b.mkv"));
      if (!reader) continue;
      Picture picture;
      std::optional<DurationNs> time_ns;
      for (int i = 0; i < 1'000; ++i) {
        const auto step = (*reader)->next(picture, time_ns, 0);
        if (!step || *step == PictureStep::kEnd) break;
      }
      CHECK((*reader)->counters().pictures <= 4);
    }
  }
}

TEST_CASE("a pipe without a reader refuses pictures, and each reader gets a stream of its own") {
  const TempFolder folder;
  const std::string pipe = folder.file("pipe");
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const auto output = must(open_video_output(target_of(pipe)));
  const GridCodec codec = codec_of(GridPlanes::kLuma);
  Picture picture;
  codec.encode(random_levels(1, 3), picture);
  CHECK(output->show(picture, 0).error().message.find("no program reads") != std::string::npos);
  for (const int round : {1, 2}) {
    CAPTURE(round);
    drivers::Fd reading(::open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    REQUIRE(static_cast<bool>(reading));
    std::string bytes;
    for (int i = 0; i < 3; ++i) {
      REQUIRE(output->show(picture, round * kNsPerS + time_of(i)).has_value());
      std::vector<char> part(1 << 20);
      for (ssize_t count = 0; (count = ::read(reading.get(), part.data(), part.size())) > 0;) {
        bytes.append(part.data(), static_cast<std::size_t>(count));
      }
    }
    write_bytes(folder.file("got.mkv"), bytes);
    const ReadVideo video = read_video(folder.file("got.mkv"), GridPlanes::kLuma);
    REQUIRE(video.levels.size() >= 2);  // the last one may still be in the container's queue
    CHECK(largest_error(video.levels[1], random_levels(1, 3)) <= kWithin);
    reading.reset();
    std::signal(SIGPIPE, SIG_IGN);  // as the program does
    bool refused = false;
    for (int i = 0; i < 3 && !refused; ++i) refused = !output->show(picture, (round + 1) * kNsPerS).has_value();
    CHECK(refused);
  }
}

TEST_CASE("a pipe has each picture as a whole as soon as it is shown") {
  const TempFolder folder;
  const std::string pipe = folder.file("pipe");
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const auto output = must(open_video_output(target_of(pipe)));
  drivers::Fd reading(::open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  const GridCodec codec = codec_of(GridPlanes::kLuma);
  Picture picture;
  std::string bytes;
  for (unsigned shown = 1; shown <= 4; ++shown) {
    codec.encode(random_levels(shown, 3), picture);
    REQUIRE(output->show(picture, time_of(static_cast<int>(shown) - 1)).has_value());
    std::vector<char> part(1 << 20);
    for (ssize_t count = 0; (count = ::read(reading.get(), part.data(), part.size())) > 0;) {
      bytes.append(part.data(), static_cast<std::size_t>(count));
    }
    write_bytes(folder.file("got.ts"), bytes);
    const ReadVideo video = read_video(folder.file("got.ts"), GridPlanes::kLuma);
    CAPTURE(shown);
    REQUIRE(video.levels.size() == shown);
    CHECK(largest_error(video.levels.back(), random_levels(shown, 3)) <= kWithin);
  }
}

TEST_CASE("targets that are no files have no option overwrite, and files take yes or no") {
  const TempFolder folder;
  const std::string pipe = folder.file("pipe.ts");
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  for (const std::string& target : {std::string("mock"), std::string("window"), std::string("/dev/video99"),
                                    std::string("-"), pipe}) {
    CAPTURE(target);
    const auto refused = open_picture_sink(must(parse_endpoint("vrsl:1@" + target + "?overwrite=yes", {})), false);
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().message.find("\"overwrite\" is not an option of this target") != std::string::npos);
  }
  for (const std::string& name : {std::string("f_%05d.png"), std::string("live.png"), std::string("a.mkv")}) {
    CAPTURE(name);
    const auto opened = [&](const char* value) {
      const std::string target = "vrsl:1@" + folder.file(name) + "?overwrite=" + value;
      return open_picture_sink(must(parse_endpoint(target, {})), false);
    };
    CHECK(opened("no").has_value());
    CHECK(opened("yes").has_value());
    const auto refused = opened("maybe");
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().message.find("overwrite=maybe: expected yes or no") != std::string::npos);
  }
}

TEST_CASE("the texture of a sound as a video is that of its pictures, and a stream ends after its time") {
  const TempFolder folder;
  const std::string tone = folder.write("tone.wav", testing::wav_bytes(sine(100, 1, 16'000, 0.7), 16'000, 1));
  const std::string video = folder.file("t.mkv"), png = folder.file("t_%04d.png");
  const testing::Outcome stream =
      testing::footlight({"audio", "texture", tone, "--every", "100ms", "--scale", "2", "-o", video + "?lossless=yes"});
  CHECK_MESSAGE(stream.exit_code == 0, stream.err);
  CHECK(stream.err.find("11 pictures of 256x128") != std::string::npos);
  CHECK(testing::footlight({"audio", "texture", tone, "--every", "100ms", "-o", png}).exit_code == 0);
  const auto reader = must(VideoReader::open(video));
  Picture picture, still;
  std::optional<DurationNs> time_ns;
  for (int i = 0; i <= 10; ++i) {
    CAPTURE(i);
    REQUIRE(must(reader->next(picture, time_ns, 0)) == PictureStep::kPicture);
    CHECK(std::abs(time_ns.value_or(-1) - i * 100 * kNsPerMs) <= kNsPerMs);
    REQUIRE(read_picture_file(folder.file(fmt::format("t_{:04}.png", i)), still).has_value());
    REQUIRE(still.width == 128);
    bool same = true;
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 256; ++x)
        same = same && std::equal(picture.at(x, y), picture.at(x, y) + 3, still.at(x / 2, y / 2));
    }
    CHECK(same);
  }
  // A pipe gets its pictures in time: 0.2 s of a sound of a second take 0.2 s.
  const testing::Outcome cut =
      testing::footlight({"audio", "texture", tone, "--every", "50ms", "--for", "200ms", "-o", "mock"});
  CHECK(cut.err.find("mock: 4 pictures of 128x64") != std::string::npos);
  const testing::Outcome device =
      testing::footlight({"audio", "texture", "audio:mock=1.1", "--every", "50ms", "--for", "200ms", "-o", "mock"});
  CHECK(device.err.find("mock: 4 pictures of 128x64") != std::string::npos);
  // An existing picture is reported, whatever its number, and a missing device leaves no file.
  folder.write("s_00003.png", "mine");
  const testing::Outcome exists = testing::footlight(
      {"audio", "texture", tone, "--every", "50ms", "-o", folder.file("s_%05d.png") + "?overwrite=no"});
  CHECK(exists.exit_code == 1);
  CHECK(exists.err.find("s_00003.png exists; choose another name") != std::string::npos);
  const std::string night = folder.file("night.mp4");
  CHECK(testing::footlight({"audio", "texture", "audio:alsa:no_such=1.1", "--every", "50ms", "-o", night}).exit_code !=
        0);
  CHECK_FALSE(std::filesystem::exists(night + ".part"));
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"audio", "texture", tone, "--every", "50ms", "-o", "mock?overwrite=yes"},
           {"audio", "texture", tone, "--every", "50ms", "-o", "t.mkv?overwrite=maybe"},
           {"audio", "texture", tone, "--every", "50ms", "-o", "t.pigeon"},
           {"audio", "texture", tone, "--every", "1ms", "-o", "t.mkv"},
           {"audio", "texture", tone, "--at", "1s", "-o", "t.mkv"},
           {"audio", "texture", tone, "--every", "50ms", "--scale", "2", "-o", png},
           {"audio", "texture", tone, "--every", "50ms", "-o", "t.mkv?speed=3"},
           {"audio", "texture", "audio:mock=1.1", "--at", "1s", "-o", folder.file("x.png")}}) {
    CAPTURE(wrong.back());
    CHECK(testing::footlight(wrong).exit_code == 2);
  }
}

TEST_CASE("log convert makes a log of a video's levels and times, and states the confidence of each universe") {
  const TempFolder folder;
  const std::string video = folder.file("club.mkv"), log = folder.file("club.dmxlog");
  write_video(video, 5, GridPlanes::kRgb, {{"lossless", "yes"}});
  const testing::Outcome converted =
      testing::footlight({"log", "convert", video, log, "--grid", "layout=horizontal-bottom&planes=rgb"});
  INFO(converted.err);
  CHECK(converted.exit_code == 0);
  CHECK(converted.out.find("universe 9: confidence 1.00 in the mean, 1.00 at least; 0 of 5") != std::string::npos);
  const auto input = must(open_log_input(log));
  FrameView frame;
  int frames = 0;
  while (must(input->next(frame))) {
    const auto picture = static_cast<unsigned>(std::lround(static_cast<double>(frame.stamp_ns) * kHz / 1e9));
    CHECK(std::abs(frame.stamp_ns - time_of(static_cast<int>(picture))) <= kNsPerMs);
    const Levels sent = random_levels(picture, 9);
    const auto first = sent.begin() + std::ptrdiff_t{kSlotCountMax} * (frame.universe - 1);
    CHECK(std::equal(frame.slots.begin(), frame.slots.end(), first));
    ++frames;
  }
  CHECK(frames == 45);
}

TEST_CASE("log convert and vrsl check count damaged pictures, and exit with 1") {
  const TempFolder folder;
  const std::string video = folder.file("club.mkv");
  write_video(video, 90, GridPlanes::kLuma);
  std::string bytes = bytes_of(video);
  for (std::size_t i = bytes.size() / 6; i < bytes.size() / 6 + 400; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  write_bytes(video, bytes);
  const testing::Outcome converted =
      testing::footlight({"log", "convert", video, folder.file("club.dmxlog"), "--grid", "layout=horizontal-bottom"});
  INFO(converted.err);
  CHECK(converted.exit_code == 1);
  CHECK(converted.out.find("pictures were damaged, or build on one that was") != std::string::npos);
  const testing::Outcome checked =
      testing::footlight({"vrsl", "check", video, "--format", "layout=horizontal-bottom", "--json"});
  CHECK(checked.exit_code == 1);
  const auto json = nlohmann::json::parse(checked.out);
  CHECK(json["damaged"].get<int>() > 0);
  CHECK(json["layout"] == "horizontal-bottom");
  CHECK(json["used"].get<int>() + json["damaged"].get<int>() == json["pictures"].get<int>());
  CHECK(json["universes"].size() == 3);
  CHECK(json["pictures_hz"].get<double>() == doctest::Approx(kHz).epsilon(0.05));
}

TEST_CASE("a video without a grid gives no log, and the message names what was expected") {
  const TempFolder folder;
  const auto output = must(open_video_output(target_of(folder.file("black.mkv"))));
  Picture black;
  black.clear(kWidth, kHeight);
  for (int i = 0; i < 3; ++i) must(output->show(black, time_of(i)));
  must(output->finish());
  const testing::Outcome converted =
      testing::footlight({"log", "convert", folder.file("black.mkv"), folder.file("black.dmxlog")});
  CHECK(converted.exit_code == 2);
  CHECK(converted.err.find("no grid in its 3 pictures") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder.file("black.dmxlog")));
  const testing::Outcome wrong = testing::footlight(
      {"log", "convert", folder.file("black.mkv"), folder.file("black.dmxlog"), "--grid", "quality=3"});
  CHECK(wrong.err.find("--grid quality=3") != std::string::npos);
}

TEST_CASE("wrong names, options and sizes of videos are refused with what was expected") {
  const TempFolder folder;
  const auto refusal = [&](const std::string& name, std::vector<EndpointOption> options) {
    const auto output = open_video_output(target_of(folder.file(name), std::move(options)));
    return output ? std::string() : output.error().message;
  };
  CHECK(refusal("a.mkv", {{"quality", "52"}}).find("0 to 51") != std::string::npos);
  CHECK(refusal("a.mkv", {{"bitrate", "5x"}}).find("10 to 200000") != std::string::npos);
  CHECK(refusal("a.mkv", {{"preset", "quick"}}).find("superfast") != std::string::npos);
  CHECK(refusal("a.mkv", {{"quality", "3"}, {"lossless", "yes"}}).find("exclude") != std::string::npos);
  CHECK(refusal("a.mkv", {{"colour", "red"}}).find("not an option") != std::string::npos);
  CHECK(refusal("a.avi", {}).find(".mkv") != std::string::npos);
  write_bytes(folder.file("there.mkv"), "x");
  CHECK(refusal("there.mkv", {}).find("exists") != std::string::npos);
  drivers::PictureTarget odd = target_of(folder.file("odd.mkv"));
  odd.height = 105;
  CHECK(open_video_output(odd).error().message.find("even") != std::string::npos);
  CHECK(VideoReader::open(folder.file("none.mkv")).error().code == ErrorCode::kNotFound);
  CHECK(VideoReader::open(folder.file("there.mkv")).error().code == ErrorCode::kBadInput);
  CHECK(VideoReader::open("/dev/null").error().code == ErrorCode::kBadInput);
}

}  // namespace footlight::tools

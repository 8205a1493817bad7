#include <doctest/doctest.h>

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "fixtures/simulate/vrsl_compat.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tools/footlight/vrsl/mock_pictures.h"
#include "tools/footlight/vrsl/open_pictures.h"
#include "tools/footlight/vrsl/png_pictures.h"
#include "tools/footlight/vrsl/round_trip.h"
#include "tools/footlight/vrsl/vrsl_reading.h"

using namespace footlight;
using namespace footlight::tools;
using drivers::GridCodec;
using drivers::GridFormat;
using drivers::GridLayout;
using drivers::GridPlanes;
using drivers::Picture;

namespace {

std::vector<std::uint8_t> some_levels(int seed) {
  std::vector<std::uint8_t> levels(std::size_t{9} * 512);
  std::uint32_t state = static_cast<std::uint32_t>(seed);
  for (std::uint8_t& level : levels) {
    state = state * 1'664'525 + 1'013'904'223;
    level = static_cast<std::uint8_t>(state >> 24);
  }
  return levels;
}

GridCodec codec_of(const GridFormat& format) {
  auto codec = GridCodec::make(format);
  REQUIRE(codec.has_value());
  return *codec;
}

Picture encoded(const GridCodec& codec, const std::vector<std::uint8_t>& levels) {
  Picture picture;
  codec.encode(levels, picture);
  return picture;
}

Endpoint endpoint_of(const std::string& text) {
  auto endpoint = parse_endpoint(text, {});
  REQUIRE_MESSAGE(endpoint.has_value(), endpoint.error().message);
  return *endpoint;
}

struct LastFrames final : FrameReceiver {
  void receive(const FrameView& frame) override {
    const std::vector<std::uint8_t> slots(frame.slots.begin(), frame.slots.end());
    if (frame.universe == 11) first.push_back(slots);
    if (frame.universe == 19) last.push_back(slots);
  }
  std::vector<std::vector<std::uint8_t>> first, last;
};

}  // namespace

TEST_CASE("a PNG holds a picture without a loss, and a damaged one is an error") {
  const testing::TempFolder folder;
  const Picture picture = encoded(codec_of({.planes = GridPlanes::kRgb}), some_levels(1));
  const std::string path = folder.file("one.png");
  REQUIRE(write_picture_file(path, picture.view()).has_value());
  CHECK(!std::filesystem::exists(path + ".part"));
  Picture read;
  REQUIRE(read_picture_file(path, read).has_value());
  CHECK(read.width == 1920);
  CHECK(read.rgb == picture.rgb);
  // Rows with a gap between them.
  const drivers::PictureView part{picture.view().at(100, 900), 64, 32, picture.view().stride_bytes};
  REQUIRE(write_picture_file(path, part).has_value());
  REQUIRE(read_picture_file(path, read).has_value());
  CHECK(read.width == 64);
  CHECK(std::equal(read.rgb.begin(), read.rgb.begin() + 3 * 64, picture.view().at(100, 900)));
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  const Status damaged = read_picture_file(path, read);
  REQUIRE(!damaged.has_value());
  CHECK(damaged.error().code == ErrorCode::kProtocol);
  CHECK(damaged.error().message.find(path) == 0);
  const Status missing = read_picture_file(folder.file("none.png"), read);
  REQUIRE(!missing.has_value());
  CHECK(missing.error().code == ErrorCode::kNotFound);
}

TEST_CASE("nine universes go out as numbered pictures and come back as they were") {
  const testing::TempFolder folder;
  const std::string name = folder.file("f_%03d.png");
  const auto a = some_levels(2), b = some_levels(3);
  const auto frames_of = [](const std::vector<std::uint8_t>& levels) {
    std::vector<FrameView> frames;
    for (int i = 0; i < 9; ++i) {
      frames.push_back(
          {.universe = 11 + i, .slots = std::span(levels).subspan(static_cast<std::size_t>(i) * 512, 512)});
    }
    return frames;
  };
  auto sink = open_picture_sink(endpoint_of("vrsl:1-9=11-19@" + name + "?fps=10&check=yes"), false);
  REQUIRE_MESSAGE(sink.has_value(), sink.error().message);
  REQUIRE((*sink)->send(0, frames_of(a)).has_value());
  REQUIRE((*sink)->poll(0).has_value());
  REQUIRE((*sink)->send(0, frames_of(b)).has_value());
  REQUIRE((*sink)->poll(100 * kNsPerMs).has_value());
  (*sink)->close(kNsPerS);
  CHECK((*sink)->counters().frames == 2);
  CHECK((*sink)->counters().errors == 0);
  CHECK(std::filesystem::exists(folder.file("f_001.png")));
  CHECK(!std::filesystem::exists(folder.file("f_002.png")));

  auto source = open_picture_source(endpoint_of("vrsl:1-9=11-19@" + name + "?fps=10&check=yes"));
  REQUIRE_MESSAGE(source.has_value(), source.error().message);
  LastFrames frames;
  while ((*source)->state() != PortState::kEnded) {
    pollfd waited{.fd = (*source)->poll_fd(), .events = POLLIN, .revents = 0};
    REQUIRE(::poll(&waited, 1, 20'000) == 1);
    REQUIRE((*source)->poll(frames.first.empty() ? 0 : 200 * kNsPerMs, frames).has_value());
  }
  REQUIRE(frames.first.size() == 2);
  CHECK(frames.first[0] == std::vector<std::uint8_t>(a.begin(), a.begin() + 512));
  CHECK(frames.first[1] == std::vector<std::uint8_t>(b.begin(), b.begin() + 512));
  CHECK(frames.last[1] == std::vector<std::uint8_t>(b.end() - 512, b.end()));
  CHECK((*source)->counters().rejected == 0);

  // The files stay unless told otherwise.
  const auto again = open_picture_sink(endpoint_of("vrsl:1@" + name), false);
  REQUIRE(!again.has_value());
  CHECK(again.error().message.find("exists; choose another name, or add ?overwrite=yes") != std::string::npos);
  CHECK(open_picture_sink(endpoint_of("vrsl:1@" + name + "?overwrite=yes"), false).has_value());
}

TEST_CASE("numbered pictures replace no file without overwrite=yes, whatever its number") {
  const testing::TempFolder folder;
  const std::string own = folder.write("f_00001.png", "mine");
  drivers::PictureTarget target;
  target.endpoint = "vrsl:1@f_%05d.png";
  target.name = folder.file("f_%05d.png");
  Picture picture;
  picture.clear(16, 16);
  const auto output = testing::must(open_png_output(target));
  testing::must(output->show(picture, 0));
  const Status refused = output->show(picture, 0);
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().message == own + " exists; choose another name, or add ?overwrite=yes");
  CHECK(std::filesystem::file_size(own) == 4);
}

TEST_CASE("after a time with an output, a model's pattern goes on at its rate, without the pictures of that time") {
  drivers::PictureTarget target{.endpoint = "in", .name = "mock/late"};
  target.pictures_hz = 4;
  const auto input = testing::must(open_picture_input(target));
  Picture read;
  std::optional<DurationNs> time_ns;
  {
    const auto output = testing::must(open_picture_output({.endpoint = "out", .name = "mock/late"}));
    CHECK(*input->next(read, time_ns, 800 * kNsPerMs) == drivers::PictureStep::kNothing);
  }
  CHECK(*input->next(read, time_ns, 0) == drivers::PictureStep::kPicture);
  CHECK(*input->next(read, time_ns, 0) == drivers::PictureStep::kNothing);
}

TEST_CASE("what one port shows on a model of a loopback device, another one reads, and other models do not") {
  const auto output = testing::must(open_picture_output({.endpoint = "out", .name = "mock/a"}));
  const auto input = testing::must(open_picture_input({.endpoint = "in", .name = "mock/a"}));
  const auto other = testing::must(open_picture_output({.endpoint = "out", .name = "mock/b"}));
  const auto stranger = testing::must(open_picture_input({.endpoint = "in", .name = "mock/b"}));
  Picture read;
  std::optional<DurationNs> time_ns;
  CHECK(*input->next(read, time_ns, 0) == drivers::PictureStep::kNothing);  // nothing has been shown
  for (int i = 0; i < 3; ++i) {
    const Picture shown = encoded(codec_of({.planes = GridPlanes::kRgb}), some_levels(i));
    REQUIRE(output->show(shown, 0));
    REQUIRE(*input->next(read, time_ns, kNsPerS) == drivers::PictureStep::kPicture);
    CHECK(read.rgb == shown.rgb);
    CHECK_FALSE(time_ns);  // live
  }
  CHECK(*input->next(read, time_ns, 0) == drivers::PictureStep::kNothing);
  CHECK(*stranger->next(read, time_ns, 0) == drivers::PictureStep::kNothing);
  CHECK_FALSE(open_picture_output({.endpoint = "out", .name = "mock", .options = {{"quality", "1"}}}));
}

TEST_CASE("an input from a model that nothing is shown on reads a moving pattern, in each layout") {
  for (const char* options : {"", "layout=horizontal-top&planes=rgb&", "layout=vertical-left&planes=rgb&"}) {
    CAPTURE(std::string(options));
    const std::string universes =
        std::string(options).find("vertical") == std::string::npos ? "1-9=11-19" : "1,7=11,19";
    const auto source =
        testing::must(open_picture_source(endpoint_of("vrsl:" + universes + "@mock/p?" + options + "fps=100")));
    LastFrames frames;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    TimeNs now_ns = 0;
    while (frames.first.size() < 3 && std::chrono::steady_clock::now() < end) {
      pollfd ready{source->poll_fd(), POLLIN, 0};
      ::poll(&ready, 1, 10);
      REQUIRE(source->poll(now_ns += kNsPerMs, frames));
    }
    REQUIRE(frames.first.size() >= 3);
    REQUIRE(!frames.last.empty());
    // Two pictures of the pattern differ by the same number at every address.
    const int step = (frames.first[2][0] - frames.first[1][0]) & 255;
    CHECK(step > 0);
    for (std::size_t slot = 0; slot < 512; ++slot) {
      CHECK(((frames.first[2][slot] - frames.first[1][slot]) & 255) == step);
      CHECK(((frames.first[1][slot] - frames.first[1][0]) & 255) == static_cast<int>(7 * slot & 255));
    }
  }
}

TEST_CASE("targets that nothing takes are refused with those that exist") {
  const auto refusal = [](const std::string& text, bool input) {
    const Endpoint endpoint = endpoint_of(text);
    const Error error = input ? open_picture_source(endpoint).error() : open_picture_sink(endpoint, false).error();
    CHECK(error.message.find(text) == 0);
    return error.message;
  };
  CHECK(refusal("vrsl:1@what.ever", false).find("expected one as frame_%05d.png") != std::string::npos);
  CHECK(refusal("vrsl:1@what.ever", true).find("is no input for pictures") != std::string::npos);
  CHECK(refusal("vrsl:1@no/such/folder/a.png", false).find("does not exist; create it") != std::string::npos);
  CHECK(refusal("vrsl:1@no_such.png", true).find("does not exist") != std::string::npos);
  CHECK(refusal("vrsl:1@no_such_%d.png", true).find("there is no picture with a number") != std::string::npos);
  CHECK(refusal("vrsl:1@a.jpg", false).find("JPEG changes levels") != std::string::npos);
  CHECK(refusal("vrsl:1@a.png?colour=blue", false).find("\"colour\" is not an option") != std::string::npos);
  CHECK(refusal("vrsl:1@a%d_%d.png", false).find("one placeholder") != std::string::npos);
}

TEST_CASE("VRSL does not read 120 addresses of nine universes, and all of three") {
  const auto unread = vrsl_unread({.planes = GridPlanes::kRgb});
  CHECK(count_of(unread) == 120);
  CHECK(unread == std::vector<ChannelRange>{{3, 497, 512}, {6, 473, 512}, {9, 449, 512}});
  CHECK(vrsl_unread({}).empty());
  CHECK(vrsl_unread({.layout = GridLayout::kVerticalLeft}).empty());
}

TEST_CASE("the picture gives VRSL the levels that its decoding expects at every address") {
  const auto sent = some_levels(4);
  for (const auto layout : {GridLayout::kHorizontalBottom, GridLayout::kHorizontalTop, GridLayout::kVerticalRight}) {
    for (const auto planes : {GridPlanes::kLuma, GridPlanes::kRgb}) {
      for (const bool exact_division : {false, true}) {
        for (const bool flipped : {false, true}) {
          const GridCodec codec = codec_of({.layout = layout, .planes = planes, .flipped = flipped});
          const VrslSeen seen = seen_by_vrsl(codec, encoded(codec, sent).view(), exact_division);
          CHECK(!seen.guard_tripped);
          fixtures::VrslDecode decode;
          decode.grid = is_horizontal(layout) ? fixtures::VrslGrid::kHorizontal : fixtures::VrslGrid::kVertical;
          decode.nine_universes = planes == GridPlanes::kRgb;
          decode.exact_division = exact_division;
          int wrong = 0, moved = 0;
          for (int universe = 1; universe <= codec.universe_count(); ++universe) {
            for (Address channel = 1; channel <= codec.slot_count(universe); ++channel) {
              const auto read = fixtures::vrsl_reads(universe, channel, decode);
              const auto at = static_cast<std::size_t>((universe - 1) * 512 + channel - 1);
              float expected = 0;
              if (read) {
                const auto from = static_cast<std::size_t>((read->universe - 1) * 512 + read->channel - 1);
                expected = static_cast<float>(sent[from]) / 255.0f;
                moved += from != at ? 1 : 0;
              }
              wrong += std::abs(seen.values[at] - expected) > 1e-5f ? 1 : 0;
            }
          }
          CHECK(wrong == 0);
          // Of forty cells in each colour one is padding, and nine in all are among the 120 that VRSL does not find.
          const int moved_expected = planes == GridPlanes::kRgb ? 3 * 39 - 9 : 39;
          if (is_horizontal(layout)) CHECK(moved == (exact_division ? moved_expected : 0));
        }
      }
    }
  }
}

TEST_CASE("padding that is not black trips VRSL's signal detection") {
  const GridCodec codec = codec_of({});
  Picture picture = encoded(codec, some_levels(5));
  CHECK(!seen_by_vrsl(codec, picture.view()).guard_tripped);
  // Cell 516 of the second universe.
  const fixtures::VrslCell cell = fixtures::vrsl_cell(2, 516, false);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x)
      std::fill_n(picture.at(16 * cell.row + x, 872 + 16 * cell.column + y), 3, std::uint8_t{7});
  }
  CHECK(seen_by_vrsl(codec, picture.view()).guard_tripped);
  // In limited range black is 16.
  const GridCodec limited = codec_of({.range = drivers::GridRange::kLimited});
  CHECK(seen_by_vrsl(limited, encoded(limited, some_levels(5)).view()).guard_tripped);
  // The check row is outside the grid.
  const GridCodec checked = codec_of({.check_row = true});
  CHECK(!seen_by_vrsl(checked, encoded(checked, some_levels(5)).view()).guard_tripped);
}

TEST_CASE("round trips lose what formats and ways lose, and no more") {
  const auto ways = plain_ways();
  const auto row_of = [&](const std::string& way, GridPlanes planes, drivers::GridRange range,
                          drivers::GridTransfer transfer) {
    const auto found = std::find_if(ways.begin(), ways.end(), [&](const PictureWay& one) { return one.name == way; });
    REQUIRE(found != ways.end());
    const auto row = round_trip({.planes = planes, .range = range, .transfer = transfer}, *found, 1);
    REQUIRE(row.has_value());
    return *row;
  };
  using drivers::GridRange;
  using drivers::GridTransfer;
  CHECK(row_of("none", GridPlanes::kRgb, GridRange::kFull, GridTransfer::kLinear).changed == 0);
  CHECK(row_of("1280x720", GridPlanes::kRgb, GridRange::kFull, GridTransfer::kLinear).changed == 0);
  CHECK(row_of("640x360", GridPlanes::kLuma, GridRange::kFull, GridTransfer::kLinear).changed == 0);
  const RoundTripRow limited = row_of("none", GridPlanes::kLuma, GridRange::kLimited, GridTransfer::kLinear);
  CHECK(limited.levels_left == 220);
  CHECK(limited.error_max == 1);
  CHECK(limited.found);
  // Video in limited range keeps grey levels within 1, and colours less well.
  const RoundTripRow grey = row_of("yuv420", GridPlanes::kLuma, GridRange::kFull, GridTransfer::kLinear);
  const RoundTripRow colours = row_of("yuv420", GridPlanes::kRgb, GridRange::kFull, GridTransfer::kLinear);
  CHECK(grey.error_max == 1);
  CHECK(colours.error_max > 1);
  CHECK(colours.error_max <= 4);
}

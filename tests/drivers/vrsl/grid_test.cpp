#include "drivers/vrsl/grid.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "drivers/vrsl/grid_check.h"
#include "fixtures/simulate/vrsl_compat.h"
#include "tests/drivers/vrsl/grids.h"

using namespace footlight;
using namespace footlight::drivers;

namespace {

GridCodec codec_of(const GridFormat& format) {
  auto codec = GridCodec::make(format);
  REQUIRE_MESSAGE(codec.has_value(), codec.error().message);
  return *codec;
}

std::vector<std::uint8_t> decoded(const GridCodec& codec, const PictureView& picture, GridReading& reading) {
  std::vector<std::uint8_t> levels(9 * 512);
  REQUIRE(codec.decode(picture, levels, reading).has_value());
  return levels;
}

// Addresses whose level differs from what the format can carry.
int wrong_count(const GridCodec& codec, const std::vector<std::uint8_t>& sent, const std::vector<std::uint8_t>& got) {
  int wrong = 0;
  for (int universe = 1; universe <= codec.universe_count(); ++universe) {
    for (Address address = 1; address <= 512; ++address) {
      const auto at = static_cast<std::size_t>((universe - 1) * 512 + address - 1);
      if (codec.carries(universe, address)) wrong += codec.through(sent[at]) != got[at] ? 1 : 0;
    }
  }
  return wrong;
}

}  // namespace

TEST_CASE("all 4,608 addresses of nine universes come back from a picture") {
  const GridCodec codec = codec_of({.planes = GridPlanes::kRgb});
  CHECK(codec.unreachable_count() == 0);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto sent = random_levels(seed);
    Picture picture;
    codec.encode(sent, picture);
    GridReading reading;
    CHECK(decoded(codec, picture.view(), reading) == sent);
    CHECK(reading.lowest(9) == doctest::Approx(1));
    CHECK(!reading.blank);
  }
}

TEST_CASE("every format carries every address that it states, and states the others") {
  const auto sent = random_levels(7);
  for (const GridFormat& format : all_formats()) {
    const GridCodec codec = codec_of(format);
    CAPTURE(name_of(format.layout));
    CAPTURE(name_of(format.transfer));
    Picture picture;
    codec.encode(sent, picture);
    GridReading reading;
    CHECK(wrong_count(codec, sent, decoded(codec, picture.view(), reading)) == 0);
    CHECK(reading.lowest(codec.universe_count()) > 0.99f);
    const int planes = format.planes == GridPlanes::kRgb ? 3 : 1;
    CHECK(codec.unreachable_count() == (is_horizontal(format.layout) ? 0 : 673 * planes));
  }
}

TEST_CASE("cells of addresses are where VRSL reads them") {
  struct Vector {
    int universe, channel, column, row, plane;
  };
  // Of VRSL's shader: column, row and plane of the table.
  const Vector vectors[] = {{1, 1, 0, 0, 0},     {1, 13, 12, 0, 0}, {1, 14, 0, 1, 0},    {2, 1, 0, 40, 0},
                            {3, 512, 4, 119, 0}, {4, 1, 0, 0, 1},   {6, 473, 4, 116, 1}, {9, 512, 4, 119, 2}};
  const GridCodec codec = codec_of({.planes = GridPlanes::kRgb});
  const GridCodec mirrored = codec_of({.planes = GridPlanes::kRgb, .flipped = true});
  for (const Vector& v : vectors) {
    CAPTURE(v.universe);
    CAPTURE(v.channel);
    const fixtures::VrslCell cell = fixtures::vrsl_cell(v.universe, v.channel, true);
    CHECK(cell == fixtures::VrslCell{v.column, v.row, v.plane});
    std::vector<std::uint8_t> levels(9 * 512);
    levels[static_cast<std::size_t>((v.universe - 1) * 512 + v.channel - 1)] = 200;
    Picture picture;
    codec.encode(levels, picture);
    // VRSL's camera is turned: columns of the table run down from the top of the strip.
    CHECK(picture.at(16 * v.row + 8, 1080 - 208 + 16 * v.column + 8)[v.plane] == 200);
    CHECK(std::count(picture.rgb.begin(), picture.rgb.end(), 200) == 256);
    // The texture of its editor has them from the bottom.
    mirrored.encode(levels, picture);
    const fixtures::VrslPixel pixel = fixtures::vrsl_pixel(cell);
    CHECK(picture.at(pixel.x, 1080 - 1 - pixel.y)[v.plane] == 200);
  }
}

TEST_CASE("a vertical grid has row 0 at the bottom and ends with address 351 of universe 2") {
  const GridCodec codec = codec_of({.layout = GridLayout::kVerticalRight});
  std::vector<std::uint8_t> levels(3 * 512);
  levels[0] = 10;
  levels[12] = 20;
  levels[13] = 30;
  levels[512 + 350] = 40;
  Picture picture;
  codec.encode(levels, picture);
  CHECK(picture.at(1920 - 208 + 8, 1072)[0] == 10);
  CHECK(picture.at(1920 - 8, 1072)[0] == 20);
  CHECK(picture.at(1920 - 208 + 8, 1056)[0] == 30);
  CHECK(picture.at(1920 - 8, 16)[0] == 40);
  CHECK(codec.carries(2, 351));
  CHECK(!codec.carries(2, 352));
  CHECK(!codec.carries(3, 1));
}

TEST_CASE("limited range keeps 220 of 256 levels, with an error of at most 1") {
  const GridCodec codec = codec_of({.range = GridRange::kLimited});
  std::set<int> left;
  for (int level = 0; level < 256; ++level) {
    const int through = codec.through(static_cast<std::uint8_t>(level));
    left.insert(through);
    CHECK(std::abs(through - level) <= 1);
  }
  CHECK(left.size() == 220);
}

TEST_CASE("sRGB made linear writes 104 and 105 as 35 and 36") {
  const GridCodec codec = codec_of({.transfer = GridTransfer::kFromSrgb});
  CHECK(codec.code_of(104) == 35);
  CHECK(codec.code_of(105) == 36);
  CHECK(codec.code_of(0) == 0);
  CHECK(codec.code_of(255) == 255);
  CHECK(codec_of({.transfer = GridTransfer::kToSrgb}).level_of(104) == 35);
}

TEST_CASE("levels come back from pictures of other sizes") {
  const auto sent = random_levels(11);
  struct Size {
    int width, height;
  };
  for (const Size size : {Size{1280, 720}, Size{640, 360}, Size{854, 480}, Size{1920, 1088}, Size{3840, 2160}}) {
    for (const auto layout : {GridLayout::kHorizontalBottom, GridLayout::kVerticalLeft}) {
      const GridCodec codec =
          codec_of({.layout = layout, .planes = GridPlanes::kRgb, .width = size.width, .height = size.height});
      Picture picture;
      codec.encode(sent, picture);
      GridReading reading;
      CAPTURE(size.width);
      CHECK(wrong_count(codec, sent, decoded(codec, picture.view(), reading)) == 0);
      CHECK(reading.lowest(9) > 0.95f);
    }
  }
}

TEST_CASE("the grid alone is a picture of its own") {
  const auto sent = random_levels(3);
  for (const GridFormat& format : {GridFormat{.width = 1920, .height = 208},
                                   GridFormat{.layout = GridLayout::kVerticalLeft, .width = 208, .height = 1072}}) {
    const GridCodec codec = codec_of(format);
    CHECK(codec.place() == GridPlace{0, 0, 16, 16});
    Picture picture;
    codec.encode(sent, picture);
    GridReading reading;
    CHECK(wrong_count(codec, sent, decoded(codec, picture.view(), reading)) == 0);
  }
}

TEST_CASE("the mean of a cell's inner half takes away noise that single pixels have") {
  const GridCodec codec = codec_of({});
  const auto sent = random_levels(5);
  Picture picture;
  codec.encode(sent, picture);
  // Noise of at most 3 codes whose mean over 8 x 8 pixels is 0, and edges that are smeared over 3 pixels.
  for (int y = 0; y < 1080; ++y) {
    for (int x = 0; x < 1920; ++x) {
      const int in_x = x % 16, in_y = (y - 872) % 16;
      for (int c = 0; c < 3; ++c) {
        std::uint8_t& code = picture.at(x, y)[c];
        const int noise = code >= 3 && code <= 252 ? ((x + y) % 2 == 0 ? 3 : -3) : 0;
        code = static_cast<std::uint8_t>(code + noise);
        if (in_x < 3 || in_y < 3 || in_x > 12 || in_y > 12) code = static_cast<std::uint8_t>(code / 2 + 60);
      }
    }
  }
  GridReading reading;
  CHECK(wrong_count(codec, sent, decoded(codec, picture.view(), reading)) == 0);
  CHECK(reading.lowest(3) > kGridConfidenceMin);
}

TEST_CASE("another picture has a low confidence") {
  const GridCodec codec = codec_of({});
  GridReading reading;
  Picture picture;
  picture.clear(1920, 1080);
  (void)decoded(codec, picture.view(), reading);
  CHECK(reading.blank);
  // White: its padding is not black.
  std::fill(picture.rgb.begin(), picture.rgb.end(), std::uint8_t{255});
  (void)decoded(codec, picture.view(), reading);
  CHECK(!reading.blank);
  CHECK(reading.lowest(3) == 0);
  // A gradient with texture.
  for (int y = 0; y < 1080; ++y) {
    for (int x = 0; x < 1920; ++x) {
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = static_cast<std::uint8_t>(x / 8 + (x * 7 + y * 13) % 40);
    }
  }
  (void)decoded(codec, picture.view(), reading);
  CHECK(reading.lowest(3) < kGridConfidenceMin);
  // A coloured grid read as grey.
  codec_of({.planes = GridPlanes::kRgb}).encode(random_levels(2), picture);
  (void)decoded(codec, picture.view(), reading);
  CHECK(reading.lowest(3) < kGridConfidenceMin);
}

TEST_CASE("the check row finds every damaged picture, and carries the number") {
  for (const GridFormat& plain : all_formats()) {
    GridFormat format = plain;
    format.check_row = true;
    const GridCodec codec = codec_of(format);
    const auto sent = random_levels(9);
    Picture picture;
    codec.encode(sent, picture, 54'321);
    GridReading reading;
    (void)decoded(codec, picture.view(), reading);
    CHECK(reading.sequence == 54'321);
    CHECK(!reading.damaged);
    // One cell of another level.
    const GridPlace& place = codec.place();
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) {
        picture.at(static_cast<int>(place.left) + x, static_cast<int>(place.top) + y)[0] ^= 0x40;
        picture.at(static_cast<int>(place.left) + x, static_cast<int>(place.top) + y)[1] ^= 0x40;
      }
    }
    (void)decoded(codec, picture.view(), reading);
    CHECK(reading.sequence == 54'321);
    CHECK(reading.damaged);
    // Without the row.
    codec_of(plain).encode(sent, picture);
    Picture other;
    codec_of(plain).encode(sent, other);
    (void)decoded(codec, other.view(), reading);
    CHECK(!reading.sequence);
    CHECK(reading.damaged);
  }
  const std::uint8_t digits[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  CHECK(crc32_of(digits) == 0xCBF4'3926);  // the check value of ISO 3309
}

TEST_CASE("a check row half a pixel beyond the edge of the picture is drawn within it, and read") {
  for (const auto& [layout, place] : {std::pair{GridLayout::kVerticalLeft, GridPlace{0, 8.5, 16, 16}},
                                      std::pair{GridLayout::kHorizontalBottom, GridPlace{-0.5, 16, 16, 16}}}) {
    const GridCodec codec = codec_of({.layout = layout, .check_row = true, .place = place});
    Picture picture;
    codec.encode(random_levels(3), picture, 4'321);
    REQUIRE(picture.rgb.size() == 3 * 1920 * 1080);
    GridReading reading;
    (void)decoded(codec, picture.view(), reading);
    CHECK(reading.sequence == 4'321);
    CHECK(!reading.damaged);
  }
}

TEST_CASE("a picture that is encoded again is not allocated again, and keeps what is around the grid") {
  const GridCodec codec = codec_of({});
  Picture picture;
  codec.encode(random_levels(1), picture);
  picture.at(5, 5)[1] = 77;
  const std::uint8_t* const pixels = picture.rgb.data();
  codec.encode(random_levels(2), picture);
  CHECK(picture.rgb.data() == pixels);
  CHECK(picture.at(5, 5)[1] == 77);
}

TEST_CASE("formats that do not fit are refused with the reason") {
  const auto message = [](const GridFormat& format) {
    const auto codec = GridCodec::make(format);
    REQUIRE(!codec.has_value());
    CHECK(codec.error().code == ErrorCode::kBadInput);
    return codec.error().message;
  };
  CHECK(message({.width = 100'000}).find("expected 1 to 8192") != std::string::npos);
  CHECK(message({.width = 160, .height = 90}).find("too small") != std::string::npos);
  CHECK(message({.width = 1920, .height = 100}).find("not inside a picture") != std::string::npos);
  CHECK(message({.check_row = true, .width = 1920, .height = 208}).find("check row") != std::string::npos);
  CHECK(message({.place = GridPlace{10, 0, 16, 16}}).find("not inside a picture") != std::string::npos);
  CHECK(message({.place = GridPlace{0, 0, 0.0 / 0.0, 16}}).find("too small") != std::string::npos);
  const GridCodec codec = codec_of({});
  Picture small;
  small.clear(640, 360);
  std::vector<std::uint8_t> levels(3 * 512);
  GridReading reading;
  const Status status = codec.decode(small.view(), levels, reading);
  REQUIRE(!status.has_value());
  CHECK(status.error().message == "a picture of 640 x 360 pixels; expected 1920 x 1080");
}

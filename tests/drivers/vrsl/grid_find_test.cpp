#include "drivers/vrsl/grid_find.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/drivers/vrsl/grids.h"

using namespace footlight;
using namespace footlight::drivers;

namespace {

Picture encoded(const GridFormat& format, const std::vector<std::uint8_t>& levels) {
  const auto codec = GridCodec::make(format);
  REQUIRE(codec.has_value());
  Picture picture;
  codec->encode(levels, picture);
  return picture;
}

// A wave of many colours, as a film has.
void draw_film(Picture& picture, int top, int bottom) {
  for (int y = top; y < bottom; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      std::uint8_t* const pixel = picture.at(x, y);
      pixel[0] = static_cast<std::uint8_t>(x / 8 + (x * y / 16) % 23);
      pixel[1] = static_cast<std::uint8_t>((x + 2 * y) / 16 + (x * 7 + y * 3) % 17);
      pixel[2] = static_cast<std::uint8_t>(128 + (y / 9 + x / 31) % 97);
    }
  }
}

// `picture` scaled bilinearly to a part of a larger one.
Picture placed(const Picture& picture, int width, int height, double left, double top, double scale) {
  Picture larger;
  larger.clear(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double from_x = (x + 0.5 - left) / scale - 0.5, from_y = (y + 0.5 - top) / scale - 0.5;
      if (from_x < 0 || from_y < 0 || from_x > picture.width - 1 || from_y > picture.height - 1) continue;
      const int x0 = static_cast<int>(from_x), y0 = static_cast<int>(from_y);
      const int x1 = std::min(x0 + 1, picture.width - 1), y1 = std::min(y0 + 1, picture.height - 1);
      for (int c = 0; c < 3; ++c) {
        const auto at = [&](int px, int py) { return static_cast<double>(picture.view().at(px, py)[c]); };
        const double fx = from_x - x0, fy = from_y - y0;
        const double value =
            (at(x0, y0) * (1 - fx) + at(x1, y0) * fx) * (1 - fy) + (at(x0, y1) * (1 - fx) + at(x1, y1) * fx) * fy;
        larger.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(value));
      }
    }
  }
  return larger;
}

// Levels that a reading of the picture in the found format has wrong, of those that `format` carries. `tolerance`: of
// levels.
int wrong_after_finding(const Picture& picture, const GridFormat& format, const std::vector<std::uint8_t>& sent,
                        int tolerance) {
  const auto found = find_grid(picture.view());
  REQUIRE_MESSAGE(found.has_value(), found.error().message);
  const auto codec = GridCodec::make(found->format);
  REQUIRE(codec.has_value());
  const auto original = GridCodec::make(format);
  std::vector<std::uint8_t> got(9 * 512);
  GridReading reading;
  REQUIRE(codec->decode(picture.view(), got, reading).has_value());
  CHECK(reading.lowest(codec->universe_count()) >= kGridConfidenceMin);
  CHECK(codec->universe_count() == original->universe_count());
  int wrong = 0;
  for (int universe = 1; universe <= original->universe_count(); ++universe) {
    for (Address address = 1; address <= original->slot_count(universe); ++address) {
      const auto at = static_cast<std::size_t>((universe - 1) * 512 + address - 1);
      wrong += std::abs(original->through(sent[at]) - got[at]) > tolerance ? 1 : 0;
    }
  }
  return wrong;
}

}  // namespace

TEST_CASE("every format is found in its picture, beside a film") {
  const auto sent = random_levels(21);
  bool flipped = false;
  for (GridFormat format : all_formats()) {
    format.flipped = flipped = !flipped;
    Picture picture = encoded(format, sent);
    // The rows that neither kind of grid uses.
    if (format.layout == GridLayout::kHorizontalBottom) draw_film(picture, 0, 872);
    if (format.layout == GridLayout::kHorizontalTop) draw_film(picture, 208, 1080);
    const auto found = find_grid(picture.view());
    CAPTURE(name_of(format.layout));
    CAPTURE(name_of(format.planes));
    CAPTURE(name_of(format.range));
    CAPTURE(name_of(format.transfer));
    REQUIRE_MESSAGE(found.has_value(), found.error().message);
    CHECK(name_of(found->format.layout) == name_of(format.layout));
    CHECK(name_of(found->format.planes) == name_of(format.planes));
    CHECK(name_of(found->format.range) == name_of(format.range));
    CHECK(name_of(found->format.transfer) == name_of(format.transfer));
    CHECK(found->format.flipped == flipped);
    CHECK(found->confidence > 0.9f);
  }
  // Each layout both ways up.
  for (const auto layout : {GridLayout::kHorizontalBottom, GridLayout::kHorizontalTop, GridLayout::kVerticalLeft,
                            GridLayout::kVerticalRight}) {
    for (const bool turned : {false, true}) {
      const auto found = find_grid(encoded({.layout = layout, .flipped = turned}, sent).view());
      REQUIRE(found.has_value());
      CHECK(found->format.flipped == turned);
      CHECK(found->open.size() == 1);  // three universes, or nine
    }
  }
}

TEST_CASE("a grid is found at any place and scale of a larger picture, and its levels are right") {
  const auto sent = random_levels(22);
  struct Place {
    GridLayout layout;
    GridPlanes planes;
    int width, height;
    double left, top, scale;
  };
  const Place places[] = {
      {GridLayout::kHorizontalBottom, GridPlanes::kLuma, 1920, 1080, 213, 95, 0.75},
      {GridLayout::kHorizontalTop, GridPlanes::kRgb, 1600, 900, 40.5, 33.25, 0.6},
      {GridLayout::kVerticalLeft, GridPlanes::kRgb, 1920, 1080, 300, 140, 0.8},
      {GridLayout::kVerticalRight, GridPlanes::kLuma, 1600, 900, 17, 21, 0.7},
  };
  for (const Place& place : places) {
    const GridFormat format{.layout = place.layout, .planes = place.planes};
    const Picture larger = placed(encoded(format, sent), place.width, place.height, place.left, place.top, place.scale);
    CAPTURE(name_of(place.layout));
    CHECK(wrong_after_finding(larger, format, sent, 1) == 0);
  }
}

TEST_CASE("a picture that was scaled as a whole is found at its usual place") {
  const auto sent = random_levels(23);
  const GridFormat format{.planes = GridPlanes::kRgb};
  const Picture smaller = placed(encoded(format, sent), 1280, 720, 0, 0, 2.0 / 3);
  const auto found = find_grid(smaller.view());
  REQUIRE_MESSAGE(found.has_value(), found.error().message);
  CHECK(!found->format.place);
  CHECK(wrong_after_finding(smaller, format, sent, 1) == 0);
}

TEST_CASE("few fixtures are enough at the usual place, and what they leave open is stated") {
  std::vector<std::uint8_t> levels(9 * 512);
  for (std::size_t i = 0; i < 200; ++i) levels[i] = static_cast<std::uint8_t>(37 * i % 256);
  const auto found = find_grid(encoded({}, levels).view());
  REQUIRE_MESSAGE(found.has_value(), found.error().message);
  CHECK(name_of(found->format.layout) == "horizontal-bottom");
  CHECK(!found->format.flipped);
  const auto mentions = [&](const char* text) {
    return std::any_of(found->open.begin(), found->open.end(),
                       [&](const std::string& one) { return one.find(text) != std::string::npos; });
  };
  CHECK(mentions("Upside down"));
  CHECK(mentions("three universes, or nine"));
  // So few that a corner of either layout shows them.
  for (std::size_t i = 40; i < 200; ++i) levels[i] = 0;
  const auto corner = find_grid(encoded({}, levels).view());
  REQUIRE(!corner.has_value());
  CHECK(corner.error().message.find("fit horizontal-bottom as well as vertical-left") != std::string::npos);
}

TEST_CASE("pictures without a grid are refused with a reason") {
  const auto refusal = [](const Picture& picture) {
    const auto found = find_grid(picture.view());
    REQUIRE(!found.has_value());
    CHECK(found.error().code == ErrorCode::kNotFound);
    return found.error().message;
  };
  Picture picture;
  picture.clear(1920, 1080);
  CHECK(refusal(picture).find("the picture is black") != std::string::npos);
  draw_film(picture, 0, 1080);
  CHECK(refusal(picture).find("no blocks of one colour") != std::string::npos);
  // White, and flat areas as of a slide.
  std::fill(picture.rgb.begin(), picture.rgb.end(), std::uint8_t{255});
  (void)refusal(picture);
  for (int y = 300; y < 1000; ++y) {
    for (int x = 200; x < 1700; ++x) picture.at(x, y)[y < 600 ? 0 : 2] = static_cast<std::uint8_t>(x < 900 ? 30 : 90);
  }
  (void)refusal(picture);
  // A chess board with squares as large as cells: its padding is not black.
  for (int y = 0; y < 1080; ++y) {
    for (int x = 0; x < 1920; ++x) {
      std::fill_n(picture.at(x, y), 3, static_cast<std::uint8_t>((x / 16 + y / 16) % 2 == 0 ? 220 : 60));
    }
  }
  (void)refusal(picture);
  // Light that fades smoothly into black, as of a stage: the inside of each cell is nearly of one colour.
  picture.clear(1280, 720);
  for (int y = 0; y < 720; ++y) {
    for (int x = 0; x < 1280; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double beam = 200 * std::exp(-((x - 300 - 250 * c) * (x - 300 - 250 * c) + 2 * y * y) / 9000.0);
        picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(beam));
      }
    }
  }
  (void)refusal(picture);
  // White text on black.
  picture.clear(1920, 1080);
  for (int y = 0; y < 1080; ++y) {
    for (int x = 0; x < 1920; ++x) {
      if (y % 40 < 24 && (x * 31 + y * 17 + x * y / 7) % 5 < 2) std::fill_n(picture.at(x, y), 3, std::uint8_t{255});
    }
  }
  (void)refusal(picture);
}

TEST_CASE("a grid that is covered, cut off or noisy is refused, not read wrongly") {
  const auto sent = random_levels(24);
  const GridFormat format{.planes = GridPlanes::kRgb};
  const Picture whole = encoded(format, sent);
  // A subtitle over 40 x 3 cells.
  Picture covered = whole;
  for (int y = 950; y < 998; ++y) {
    for (int x = 640; x < 1280; ++x) {
      if ((x * 13 + y * 7 + x * y / 11) % 4 == 0) std::fill_n(covered.at(x, y), 3, std::uint8_t{255});
    }
  }
  CHECK(!find_grid(covered.view()).has_value());
  const auto codec = GridCodec::make(format);
  std::vector<std::uint8_t> got(9 * 512);
  GridReading reading;
  REQUIRE(codec->decode(covered.view(), got, reading).has_value());
  CHECK(reading.lowest(9) < kGridConfidenceMin);
  // A tenth of its width is missing.
  const Picture cut = placed(whole, 1728, 1080, -192, 0, 1);
  CHECK(!find_grid(cut.view()).has_value());
  // Noise of 40 codes.
  Picture noisy = whole;
  std::uint32_t state = 1;
  for (std::uint8_t& code : noisy.rgb) {
    state = state * 1'664'525 + 1'013'904'223;
    code =
        static_cast<std::uint8_t>(std::clamp(static_cast<int>(code) + static_cast<int>(state >> 24) % 81 - 40, 0, 255));
  }
  CHECK(!find_grid(noisy.view()).has_value());
}

// Pixels of displays and the cells that are made of them: which are stored, those of two pixels, which are computed
// where they are read, and a display of 3840 x 2160 pixels.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <glm/gtc/packing.hpp>

#include "fixtures/displays/display.h"
#include "render/display_tables.h"
#include "render/frame.h"
#include "tests/render/judged_light.h"
#include "tests/support/headless_vulkan.h"

namespace footlight::render {
namespace {

using namespace render::testing;
using footlight::testing::HeadlessVulkan;

constexpr int kWidth = 32, kHeight = 18;

Scene scene_of(const std::string& things) {
  Scene scene;
  scene.rig = must(fixtures::parse_rig("[rig]\nname = \"Pixels\"\nambient_lx = 0\n[haze]\nscattering_per_m = 0\n" +
                                           things + "[[camera]]\nname = \"main\"\nposition = [0, -4, 2]\n"
                                                    "target = [0, 4, 2]\nfov_deg = 55\n",
                                       "pixels.toml"));
  scene.compile();
  return scene;
}

std::string display_of(const std::string& place, double width_m, double height_m) {
  return "[[display]]\n" + place + "width_m = " + std::to_string(width_m) + "\nheight_m = " +
         std::to_string(height_m) + "\nnits = 800\n";
}

void give_image(fixtures::Display& display, const fixtures::PaneImage& image) {
  display.columns = image.width;
  display.rows = image.height;
  display.image = std::make_shared<const fixtures::PaneImage>(image);
}

fixtures::PaneImage random_image(int columns, int rows) {
  fixtures::PaneImage image{columns, rows, {}};
  Random random(static_cast<std::uint64_t>(columns + 1000 * rows));
  for (int i = 0; i < columns * rows; ++i) {
    image.texels.emplace_back(random.between(0, 1), random.between(0, 1), random.between(0, 1));
  }
  return image;
}

// From the top left at these pixels of the image.
struct CellSum {
  glm::dvec3 mean{0};
  glm::dvec3 moment_x{0};
  glm::dvec3 moment_y{0};
};
CellSum sum_over(const fixtures::PaneImage& image, int left, int top, int right, int bottom) {
  CellSum sum;
  const double count = (right - left) * (bottom - top);
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const glm::dvec3 light = glm::dvec3(image.texels.at(static_cast<std::size_t>(y * image.width + x))) / count;
      sum.mean += light;
      sum.moment_x += light * (x + 0.5 - 0.5 * (left + right));
      sum.moment_y += light * (y + 0.5 - 0.5 * (top + bottom));
    }
  }
  return sum;
}

TEST_CASE("stored cells have the means and moments of their pixels, however pixels are left over in a level") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  const std::vector<std::array<int, 2>> sizes = {{5, 3}, {1, 9}, {9, 1}, {7, 7}, {4, 4},
                                                 {3, 2}, {1, 1}, {2, 1}, {1, 2}};
  std::string things;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    // Of some of these pixels are wide, and their first cells have one above the other.
    things += display_of("position = [0, 4, " + std::to_string(2 * i) + "]\n", i % 2 == 0 ? 1.6 : 6.4, 1.6);
  }
  Scene scene = scene_of(things);
  std::vector<fixtures::PaneImage> images;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    images.push_back(random_image(sizes[i][0], sizes[i][1]));
    give_image(scene.rig.displays[i], images[i]);
  }
  scene.compile();
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(kWidth, kHeight));
  (void)draw(*frame, scene);
  const DisplayTables tables = display_tables(scene.rig, scene.compiled);
  const vk::Buffer& cells = frame->resources().rig.display_cells;
  const VkDeviceSize bytes = tables.cells * kCellBytes;
  const vk::Buffer read = must(vk::Buffer::host_visible(vulkan.device(), bytes, 0));
  must(vulkan.device().run_once([&](VkCommandBuffer commands) {
    const VkBufferCopy region{0, 0, bytes};
    vkCmdCopyBuffer(commands, cells.handle, read.handle, 1, &region);
  }));
  const auto word = [&](std::uint64_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, static_cast<const std::byte*>(read.mapped) + at * sizeof value, sizeof value);
    return value;
  };
  std::uint64_t checked = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    CAPTURE(sizes[i]);
    const DisplayRow& row = tables.rows[i];
    std::array<int, 2> side{1, 1};  // of a cell, pixels
    for (std::uint32_t level = 0; level < row.levels; ++level) {
      const DisplayLevelRow& size = tables.levels[row.level_first + level];
      for (std::uint32_t cell = 0; level >= FL_DISPLAY_STORED && cell < size.columns * size.rows; ++cell) {
        const int left = static_cast<int>(cell % size.columns) * side[0];
        const int top = static_cast<int>(cell / size.columns) * side[1];
        const CellSum sum = sum_over(images[i], left, top, std::min(left + side[0], sizes[i][0]),
                                     std::min(top + side[1], sizes[i][1]));
        const std::uint64_t at = 6 * (std::uint64_t{size.first} + cell);
        const glm::dvec2 a = glm::unpackHalf2x16(word(at + 3)), b = glm::unpackHalf2x16(word(at + 4)),
                         c = glm::unpackHalf2x16(word(at + 5));
        for (int k = 0; k < 3; ++k) {
          float mean = 0;
          const std::uint32_t bits = word(at + static_cast<std::uint64_t>(k));
          std::memcpy(&mean, &bits, sizeof mean);
          CHECK(std::abs(mean - sum.mean[k]) < 1e-6);
        }
        // Half floats on each level: 2^-11 of values up to half a side.
        CHECK(glm::length(glm::dvec3(a, b.x) - sum.moment_x) < 2e-3 * side[0]);
        CHECK(glm::length(glm::dvec3(b.y, c) - sum.moment_y) < 2e-3 * side[1]);
        ++checked;
      }
      side[(row.axes >> level & 1u) != 0 ? 1 : 0] *= 2;
    }
  }
  CHECK(checked == tables.cells);
}

TEST_CASE("cells of two pixels have their mean in the picture") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  // Each pixel of the picture shows some 6 x 6 of the display: too many for pixels, and few enough for pairs.
  for (const bool is_wide : {false, true}) {
    CAPTURE(is_wide);
    const int columns = is_wide ? 90 : 66, rows = is_wide ? 40 : 52;
    Scene scene = scene_of(display_of("position = [0, 4, 2]\n", is_wide ? 7.0 : 5.0, is_wide ? 3.0 : 4.0));
    fixtures::PaneImage image{columns, rows, {}};
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        image.texels.emplace_back((is_wide ? y : x) % 2 == 0 ? 0.9f : 0.1f);
      }
    }
    give_image(scene.rig.displays[0], image);
    scene.compile();
    const DisplayTables tables = display_tables(scene.rig, scene.compiled);
    REQUIRE((tables.rows[0].axes & 1u) == (is_wide ? 1u : 0u));
    const RadianceImage shown = drawn_light(vulkan.device(), scene, kWidth, kHeight, false);
    const auto light = [&](int at) { return shown.rgb.at(static_cast<std::size_t>(3 * at)); };
    int inside = 0;
    for (int at = kWidth; at < kWidth * (kHeight - 1); ++at) {
      // At its edges fewer pixels are seen, by themselves.
      if (std::min({light(at - 1), light(at + 1), light(at - kWidth), light(at + kWidth)}) == 0) continue;
      ++inside;
      CHECK(std::abs(light(at) - 400) < 1e-3f);
    }
    CHECK(inside > 40);
  }
}

TEST_CASE("displays of one to nine pixels, seen as cells of two, light surfaces as in the judge's picture") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const auto& [columns, rows] :
       {std::array{1, 1}, std::array{2, 1}, std::array{1, 2}, std::array{3, 1}, std::array{1, 3}, std::array{3, 3}}) {
    CAPTURE(columns);
    CAPTURE(rows);
    Scene scene = scene_of(
        display_of("position = [0, 0, 2]\nrotation = [90, 0, 0]\n", 0.3 * columns, 0.3 * rows) + kFloor);
    fixtures::PaneImage image{columns, rows, {}};
    for (int i = 0; i < columns * rows; ++i) {
      image.texels.push_back(i % 2 == 0 ? glm::vec3(1) : glm::vec3(0, 0.1, 1));
    }
    give_image(scene.rig.displays[0], image);
    view_from(scene, {0.5, -1, 2.5}, {0, 0, 0});
    scene.compile();
    const double error = rel_l2(drawn_light(vulkan.device(), scene, kWidth, kHeight, true),
                                judged_light(scene, kWidth, kHeight));
    print_error("display of few pixels", error);
    CHECK(error < 3e-3);
  }
}

constexpr int kColumns = 3840, kRows = 2160, kField = 240;

glm::vec3 color_at(int x, int y) {
  Random random(static_cast<std::uint64_t>(x) * 4096 + static_cast<std::uint64_t>(y) + 7);
  return {random.between(0, 1), random.between(0, 1), random.between(0, 1)};
}

// Fields of 240 x 240 pixels; those at the far corners have a colour each.
std::shared_ptr<const fixtures::PaneImage> fine_picture(const fixtures::PaneImage& fields) {
  auto image = std::make_shared<fixtures::PaneImage>(fixtures::PaneImage{kColumns, kRows, {}});
  image->texels.resize(std::size_t{kColumns} * kRows);
  const auto is_corner = [](int x, int y) { return (x < 16 || x >= kColumns - 16) && (y < 16 || y >= kRows - 16); };
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      image->texels[static_cast<std::size_t>(y) * kColumns + static_cast<std::size_t>(x)] =
          is_corner(x, y) ? color_at(x, y)
                          : fields.texels[static_cast<std::size_t>(y / kField * fields.width + x / kField)];
    }
  }
  return image;
}

// How many pixels of the picture show a single pixel of the display, 8 x 4.5 m in the plane y = 4 around z = 3; all of
// these have its light. last: whether one of them is in the last column and one in the last row.
int count_single(const RadianceImage& shown, const View& view, bool& last) {
  int count = 0;
  bool last_column = false, last_row = false;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const double scale = 2 * view.tan_half_fov / kHeight;
    const glm::dvec3 way = view.forward + view.right * ((i % kWidth + 0.5 - kWidth / 2.0) * scale) -
                           view.up * ((i / kWidth + 0.5 - kHeight / 2.0) * scale);
    const double t_m = (4 - view.position_m.y) / way.y;
    const glm::dvec3 place = view.position_m + way * t_m;
    const glm::dvec2 at = glm::dvec2(place.x + 4, 3 + 2.25 - place.z) * (kColumns / 8.0);
    const glm::dvec2 part = at - glm::floor(at) - 0.5;
    const bool inside = at.x >= 0 && at.y >= 0 && at.x < kColumns && at.y < kRows;
    if (!inside || std::max(std::abs(part.x), std::abs(part.y)) > 0.25) continue;
    const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
    const glm::vec3 expected = 800.0f * color_at(x, y);
    for (int c = 0; c < 3; ++c) {
      CHECK(shown.rgb.at(static_cast<std::size_t>(3 * i + c)) == doctest::Approx(expected[c]).epsilon(1e-4));
    }
    last_column = last_column || x == kColumns - 1;
    last_row = last_row || y == kRows - 1;
    ++count;
  }
  last = last_column && last_row;
  return count;
}

TEST_CASE("a display of 3840 x 2160 pixels shows single ones up to the last, and lights the floor as fewer do") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  const std::string wall = display_of("position = [0, 4, 3]\n", 8, 4.5);
  Scene fine = scene_of(wall + "columns = 3840\nrows = 2160\n" + kFloor), coarse = scene_of(wall + kFloor);
  fine.rig.displays[0].video.emplace();
  fine.compile();
  const fixtures::PaneImage fields = random_image(kColumns / kField, kRows / kField);
  give_image(coarse.rig.displays[0], fields);
  view_from(coarse, {1, 3.9, 2.5}, {-1, -2, 0});
  coarse.compile();
  FrameSettings settings = judged_settings(kWidth, kHeight);
  settings.widen_thin = true;
  const auto frame = make_frame(vulkan.device(), fine, settings);
  frame->show_pixels(0, fine_picture(fields));
  frame->step(fine.levels, 0);
  must(frame->draw(view_of(coarse.rig.cameras[0]), 0));
  const double error = rel_l2(must(frame->read_radiance()), judged_light(coarse, kWidth, kHeight));
  print_error("3840 x 2160 pixels", error);
  CHECK(error < 5e-3);
  // From 0.1 m, a pixel of the display is as large as 3 x 3 of the picture.
  for (const glm::dvec2 corner : {glm::dvec2(-4 + 0.01, 5.25 - 0.006), glm::dvec2(4 - 0.01, 0.75 + 0.006)}) {
    view_from(fine, {corner.x, 3.9, corner.y}, {corner.x, 4, corner.y});
    fine.rig.cameras[0].fov_deg = 7.15;
    const View view = view_of(fine.rig.cameras[0]);
    must(frame->draw(view, 0));
    bool last = false;
    CHECK(count_single(must(frame->read_radiance()), view, last) > 30);
    CHECK(last == (corner.x > 0));
  }
}

TEST_CASE("all of the 4.2 million pixels of a map have the levels of their slots") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  // 65,625 workgroups, where a dispatch may have 65,535: the second one begins at column 540 of row 1997 of 2000.
  Scene scene = scene_of(display_of("position = [0, 4, 2]\n", 2.1, 2) +
                         "columns = 2100\nrows = 2000\nuniverse = 1\norder = \"w\"\n");
  REQUIRE(display_tables(scene.rig, scene.compiled).live.at(0).count > 65'535);
  std::fill(scene.levels.begin(), scene.levels.end(), std::uint8_t{51});
  const auto corner_of = [&](double x, double z) {
    view_from(scene, {x, 3.9, z}, {x, 4, z});
    scene.rig.cameras[0].fov_deg = 1.5;  // from 0.1 m rows 1997.3 to 1999.9 around column 2090 are seen
    return view_of(scene.rig.cameras[0]);
  };
  const auto frame = make_frame(vulkan.device(), scene, judged_settings(kWidth, kHeight));
  frame->step(scene.levels, 0);
  for (const double side : {-1.0, 1.0}) {
    CAPTURE(side);
    must(frame->draw(corner_of(side * 1.04, 2 - side * 0.9986), 0));
    for (const float light : must(frame->read_radiance()).rgb) REQUIRE(light == doctest::Approx(160).epsilon(1e-5));
  }
}

TEST_CASE("pixels or cells that have no room in a buffer of the device are refused, each by its name and numbers") {
  HeadlessVulkan vulkan;
  if (!vulkan) return;
  // Pixels much wider than high: nine rows are five, three, two and one, so there are many cells.
  std::string things;
  for (int i = 0; i < 256; ++i) {
    things += display_of("position = [0, 4, 2]\n", 40, 0.01) + "columns = 4096\nrows = 9\n";
  }
  const Scene long_ones = scene_of(things);
  Scene large = scene_of(display_of("position = [0, 4, 2]\n", 4, 4));
  large.rig.displays[0].columns = large.rig.displays[0].rows = 4096;  // more than a file may state
  large.compile();
  const DisplayTables many_cells = display_tables(long_ones.rig, long_ones.compiled);
  CHECK(many_cells.pixels * kPixelBytes < (128u << 20));
  const std::uint64_t most = vulkan.device().limits().maxStorageBufferRange;
  const auto check_refused = [&](const Scene& scene, std::uint64_t bytes, const std::string& what) {
    REQUIRE(bytes > (128u << 20));
    if (most >= bytes) return;
    const auto frame = Frame::create(vulkan.device(), scene.rig, scene.compiled, judged_settings(kWidth, kHeight));
    REQUIRE(!frame);
    CHECK(frame.error().message == vulkan.device().name() + ": maxStorageBufferRange is " + std::to_string(most) +
                                       ", needed: " + std::to_string(bytes) + " bytes for the " + what +
                                       " of displays; use fewer columns or rows");
  };
  check_refused(long_ones, many_cells.cells * kCellBytes, "cells of pixels");
  check_refused(large, std::uint64_t{4096} * 4096 * kPixelBytes, "pixels");
}

}  // namespace
}  // namespace footlight::render

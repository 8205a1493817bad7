// The rigs of docs/gallery.md: they can be read and compiled, and the page names each of them and its picture.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/model/rig.h"
#include "tests/support/must.h"

namespace footlight {
namespace {

namespace fs = std::filesystem;

const fs::path kDocs = fs::path(FOOTLIGHT_SOURCE_DIR) / "docs";
constexpr std::uintmax_t kPictureBytesMax = 150'000;

std::string text_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}
bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<fs::path> gallery_rigs() {
  std::vector<fs::path> rigs;
  for (const auto& entry : fs::directory_iterator(kDocs / "gallery")) {
    if (entry.path().extension() == ".toml") rigs.push_back(entry.path());
  }
  std::sort(rigs.begin(), rigs.end());
  return rigs;
}

TEST_CASE("each rig of the gallery can be read and compiled, has a camera, and says how it is rendered") {
  const std::vector<fs::path> rigs = gallery_rigs();
  REQUIRE(rigs.size() >= 9);
  for (const fs::path& path : rigs) {
    CAPTURE(path.string());
    const fixtures::Rig rig = testing::must(fixtures::load_rig(path.string()));
    CHECK(fixtures::compile(rig).has_value());
    REQUIRE(rig.cameras.size() == 1);
    CHECK(has(text_of(path), "\n# render: --"));
  }
}

TEST_CASE("the gallery shows each of its rigs, and has no picture without one") {
  const std::string page = text_of(kDocs / "gallery.md");
  for (const fs::path& path : gallery_rigs()) {
    const std::string name = path.stem().string();
    CAPTURE(name);
    CHECK(has(page, "(gallery/" + name + ".png)"));
    CHECK(has(page, "(gallery/" + name + ".toml"));
    const fs::path picture = fs::path(path).replace_extension(".png");
    REQUIRE(fs::exists(picture));
    CHECK(fs::file_size(picture) < kPictureBytesMax);
  }
  for (std::size_t at = page.find("](gallery/"); at != std::string::npos; at = page.find("](gallery/", at + 1)) {
    const std::size_t first = at + 2;
    const std::string file = page.substr(first, page.find(')', first) - first);
    CHECK_MESSAGE(fs::exists(kDocs / file), file);
  }
}

}  // namespace
}  // namespace footlight

// Images of panes: what is read is a share of light in each texel, not larger than allowed, and halves down to one.
#include "fixtures/glass/pane.h"
#include "fixtures/gobos/png.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{5, 3}, std::pair{2100, 1}}) {
    std::vector<std::uint8_t> pixels;
    for (int i = 0; i < 3 * width * height; ++i) pixels.push_back(static_cast<std::uint8_t>(7 * i));
    const fixtures::Bytes png = fixtures::png_of(width, height, 3, pixels);
    seeds.add("png" + std::to_string(width), std::string(reinterpret_cast<const char*>(png.data()), png.size()));
  }
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  auto image = fixtures::pane_image(fixtures::Bytes(bytes, bytes + size), "fuzz");
  if (!image) {
    require(image.error().message.starts_with("fuzz"));
    return 0;
  }
  const std::uint64_t planned = fixtures::texels_with_levels(*image);
  if (planned > 1u << 20) return 0;
  std::uint64_t texels = 0;
  for (;;) {
    require(image->width >= 1 && image->width <= fixtures::kPanePxMax);
    require(image->height >= 1 && image->height <= fixtures::kPanePxMax);
    texels += image->texels.size();
    for (const glm::vec3& texel : image->texels) {
      for (int c = 0; c < 3; ++c) require(texel[c] >= 0 && texel[c] <= 1.00001f);
    }
    if (image->texels.size() == 1) break;
    *image = fixtures::halved(*image);
  }
  require(texels == planned);
  return 0;
}

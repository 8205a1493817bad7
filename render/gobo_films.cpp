#include "render/gobo_films.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "fixtures/model/srgb.h"

namespace footlight::render {
namespace {

constexpr std::size_t kCodes = 1u << 15;  // 10 for each code of sRGB where it is steepest

// The code of a share of light, by a table: the power takes most of the time.
std::uint8_t code_of(float linear) {
  static const std::vector<std::uint8_t> kTable = [] {
    std::vector<std::uint8_t> table(kCodes + 1);
    for (std::size_t i = 0; i <= kCodes; ++i) {
      const double share = static_cast<double>(i) / kCodes;
      table[i] = static_cast<std::uint8_t>(std::lround(255 * fixtures::srgb_of_linear(share)));
    }
    return table;
  }();
  // Not below 0, so this rounds, and sooner than lround().
  // NOLINTNEXTLINE(bugprone-incorrect-roundings)
  return kTable[static_cast<std::size_t>(std::clamp(linear, 0.0f, 1.0f) * kCodes + 0.5f)];
}

// Which pixels of a line of the picture a texel covers, and by how much of the texel.
struct Cover {
  int first = 0;
  int count = 1;
  float share_first = 1;
  float share = 0;  // of those in the middle
  float share_last = 0;
};
// Texels of a line.
struct Span {
  int first = 0;
  int count = 1;
};
// Of a line from `left` on, `width` texels long: it may begin and end within a texel.
Span span_of(double left, double width) {
  const int first = static_cast<int>(std::floor(left));
  return {first, std::max(static_cast<int>(std::ceil(left + width)) - first, 1)};
}
// The line has `pixels` pixels.
std::vector<Cover> covers(int pixels, double left, double width) {
  std::vector<Cover> all;
  const Span span = span_of(left, width);
  const double step = pixels / width;
  for (int i = 0; i < span.count; ++i) {
    const auto place = [&](int texel) { return std::clamp((texel - left) * step, 0.0, static_cast<double>(pixels)); };
    const double begin = place(span.first + i), end = place(span.first + i + 1);
    Cover cover;
    cover.first = std::min(static_cast<int>(begin), pixels - 1);
    const int last = std::clamp(static_cast<int>(std::ceil(end - 1e-9)) - 1, cover.first, pixels - 1);
    cover.count = last - cover.first + 1;
    cover.share_first = static_cast<float>(((cover.count > 1 ? cover.first + 1 : end) - begin) / step);
    cover.share = static_cast<float>(1 / step);
    cover.share_last = static_cast<float>((end - last) / step);
    all.push_back(cover);
  }
  return all;
}
template <class At>
glm::vec3 mean(const Cover& cover, const At& at) {
  glm::vec3 sum = cover.share_first * at(cover.first);
  for (int k = 1; k + 1 < cover.count; ++k) sum += cover.share * at(cover.first + k);
  if (cover.count > 1) sum += cover.share_last * at(cover.first + cover.count - 1);
  return sum;
}

// The picture over the texels that these cover, in linear light.
std::vector<glm::vec3> sized(const fixtures::PaneImage& picture, const glm::vec3& color,
                             const std::vector<Cover>& across, const std::vector<Cover>& down) {
  const std::size_t width = across.size();
  std::vector<glm::vec3> lines(width * static_cast<std::size_t>(picture.height));
  for (int y = 0; y < picture.height; ++y) {
    const glm::vec3* const line = picture.texels.data() + static_cast<std::ptrdiff_t>(y) * picture.width;
    glm::vec3* const out = lines.data() + static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; ++x) out[x] = color * mean(across[x], [&](int at) { return line[at]; });
  }
  std::vector<glm::vec3> texels(width * down.size());
  for (std::size_t y = 0; y < down.size(); ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      texels[y * width + x] = mean(down[y], [&](int at) { return lines[static_cast<std::size_t>(at) * width + x]; });
    }
  }
  return texels;
}

// The next level: means of four texels of the image, of which those outside are black.
std::vector<glm::vec3> halved(const std::vector<glm::vec3>& texels, const FilmLevel& level, const FilmLevel& next) {
  std::vector<glm::vec3> half(static_cast<std::size_t>(next.columns) * static_cast<std::size_t>(next.rows),
                              glm::vec3(0));
  for (int y = 0; y < level.rows; ++y) {
    const auto out = static_cast<std::size_t>((level.top + y) / 2 - next.top) * static_cast<std::size_t>(next.columns);
    const auto in = static_cast<std::size_t>(y) * static_cast<std::size_t>(level.columns);
    for (int x = 0; x < level.columns; ++x) {
      half[out + static_cast<std::size_t>((level.left + x) / 2 - next.left)] +=
          0.25f * texels[in + static_cast<std::size_t>(x)];
    }
  }
  return half;
}

}  // namespace

FilmTexels film_texels(const fixtures::PaneImage& picture, const glm::vec3& color, const fixtures::GoboPart& part,
                       int size_px) {
  FilmTexels film;
  const double scale = static_cast<double>(size_px) / fixtures::kProjectorGoboPx;
  const double left = scale * part.left, top = scale * part.top;
  const double width = scale * part.columns, height = scale * part.rows;
  FilmLevel level{0, span_of(left, width).first, span_of(top, height).first, span_of(left, width).count,
                  span_of(top, height).count, 0};
  std::vector<glm::vec3> texels =
      sized(picture, color, covers(picture.width, left, width), covers(picture.height, top, height));
  for (int size = size_px; size > 0; size /= 2) {
    level.first = film.texels.size();
    film.levels.push_back(level);
    film.texels.resize(level.first + 4 * texels.size());
    std::uint8_t* out = film.texels.data() + level.first;
    for (const glm::vec3& texel : texels) {
      for (int c = 0; c < 3; ++c) *out++ = code_of(texel[c]);
      *out++ = 255;
    }
    FilmLevel next{level.level + 1, level.left / 2, level.top / 2, 0, 0, 0};
    next.columns = (level.left + level.columns - 1) / 2 - next.left + 1;
    next.rows = (level.top + level.rows - 1) / 2 - next.top + 1;
    if (size > 1) texels = halved(texels, level, next);
    level = next;
  }
  return film;
}

Status GoboFilms::create(vk::Device& device, const MemoryShape& shape, const RigTables& rig) {
  if (shape.rig.projections.empty() || rig.gobos.handle == VK_NULL_HANDLE) return {};
  size_px_ = rig.gobo_px;
  VkDeviceSize bytes = 0;
  for (const fixtures::Display& display : shape.rig.projections) {
    const fixtures::FixtureType& type = shape.rig.types[static_cast<std::size_t>(display.type)];
    Film film;
    film.display = display;
    const fixtures::Projector& projector = *type.said_by_rig.projector;
    film.part = fixtures::picture_part(fixtures::projected_frame(projector), fixtures::kProjectorGoboPx);
    if (changes_on_panel(projector)) {
      film.panel.emplace(projector, film.part.columns, film.part.rows);
      // Not in record(), for which a window waits.
      film.panel->prepare(display.image ? display.image->width : display.columns,
                          display.image ? display.image->height : display.rows);
    }
    const auto& images = shape.compiled.images;
    const auto own = std::find_if(images.begin(), images.end(),
                                  [&](const fixtures::ImageSource& image) { return image.files == type.files; });
    film.has_layer = own != images.end();
    if (film.has_layer) {
      film.layer = static_cast<std::uint32_t>(own - images.begin());
      film.staged = bytes;
      film.pixels = display.image;
      if (display.map) film.map.emplace(display, shape.compiled.universes);
      bytes += film_texels({}, glm::vec3(1), film.part, size_px_).texels.size();
    }
    films_.push_back(std::move(film));
  }
  if (bytes == 0) {
    films_.clear();
    return {};
  }
  FL_ASSIGN(staged_, vk::Buffer::host_visible(device, bytes, 0));
  return {};
}

void GoboFilms::show(std::size_t projection, const std::shared_ptr<const fixtures::PaneImage>& pixels) {
  if (projection < films_.size() && films_[projection].has_layer) films_[projection].pixels = pixels;
}

void GoboFilms::record(VkCommandBuffer commands, const RigTables& rig, std::span<const std::uint8_t> levels) {
  bool any = false;
  for (Film& film : films_) {
    if (film.map) {
      if (auto pixels = film.map->next(levels)) film.pixels = std::move(pixels);
    }
    if (!film.pixels) continue;
    if (!std::exchange(any, true)) {
      vk::full_barrier(commands);
      vk::change_layout(commands, rig.gobos, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    }
    if (film.panel) film.pixels = std::make_shared<const fixtures::PaneImage>(film.panel->shown(*film.pixels));
    const FilmTexels made = film_texels(*film.pixels, glm::vec3(film.display.color), film.part, size_px_);
    film.pixels.reset();
    std::memcpy(static_cast<std::byte*>(staged_.mapped) + film.staged, made.texels.data(), made.texels.size());
    std::vector<VkBufferImageCopy> regions;
    for (const FilmLevel& level : made.levels) {
      VkBufferImageCopy region{};
      region.bufferOffset = film.staged + level.first;
      region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level.level, film.layer, 1};
      region.imageOffset = {level.left, level.top, 0};
      region.imageExtent = {static_cast<std::uint32_t>(level.columns), static_cast<std::uint32_t>(level.rows), 1};
      regions.push_back(region);
    }
    vkCmdCopyBufferToImage(commands, staged_.handle, rig.gobos.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<std::uint32_t>(regions.size()), regions.data());
  }
  if (!any) return;
  vk::change_layout(commands, rig.gobos, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  vk::full_barrier(commands);
}

}  // namespace footlight::render

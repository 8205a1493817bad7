#include "tools/footlight/displays/picture_light.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>
#include <vector>

#include "fixtures/model/srgb.h"

namespace footlight::tools {
namespace {

// Which samples of a line a part of it covers, and how much of each counts.
struct Part {
  int first = 0;
  int count = 0;
  float weight_first = 0;  // of the first sample, of those in the middle, of the last one; together 1
  float weight = 0;
  float weight_last = 0;
};

std::vector<Part> parts_of(int size, int count) {
  std::vector<Part> parts;
  const double step = static_cast<double>(size) / count;
  for (int i = 0; i < count; ++i) {
    const double from = i * step;
    const double to = i + 1 == count ? size : (i + 1) * step;
    Part part;
    part.first = std::min(static_cast<int>(from), size - 1);
    const int last = std::clamp(static_cast<int>(std::ceil(to)) - 1, part.first, size - 1);
    part.count = last - part.first + 1;
    part.weight = static_cast<float>(1 / step);
    part.weight_first = static_cast<float>((std::min<double>(part.first + 1, to) - from) / step);
    part.weight_last = part.count > 1 ? static_cast<float>((to - last) / step) : part.weight_first;
    parts.push_back(part);
  }
  return parts;
}

float weight_of(const Part& part, int i) {
  return i == 0 ? part.weight_first : i + 1 == part.count ? part.weight_last : part.weight;
}

// The light of one row of the picture, for each column of the display.
void take_row(const std::uint8_t* row, const LightCurve256& curve, const std::vector<Part>& columns,
              std::vector<glm::vec3>& line) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Part& part = columns[i];
    const std::uint8_t* at = row + 3 * static_cast<std::ptrdiff_t>(part.first);
    const auto light = [&] { return glm::vec3(curve[at[0]], curve[at[1]], curve[at[2]]); };
    if (part.count == 1) {
      line[i] = light();
      continue;
    }
    glm::vec3 sum = part.weight_first * light();
    glm::vec3 middle(0);
    at += 3;
    for (int k = 2; k < part.count; ++k, at += 3) middle += light();
    line[i] = sum + part.weight * middle + part.weight_last * light();
  }
}

// Each pixel of the picture is one of the display.
void take_codes(const drivers::PictureView& view, const LightCurve256& curve, glm::vec3* out) {
  for (int y = 0; y < view.height; ++y) {
    const std::uint8_t* at = view.row(y);
    for (int x = 0; x < view.width; ++x, at += 3) *out++ = {curve[at[0]], curve[at[1]], curve[at[2]]};
  }
}

constexpr std::size_t kSpareMost = 1;  // images without a holder

}  // namespace

LightCurve256 light_curve(double gamma) {
  LightCurve256 curve{};
  for (std::size_t code = 0; code < curve.size(); ++code) {
    const double share = static_cast<double>(code) / 255;
    curve[code] = gamma > 0 ? static_cast<float>(std::pow(share, gamma))
                            : fixtures::linear_of_srgb(static_cast<float>(code) / 255.0f);
  }
  return curve;
}

fixtures::PaneImage light_of(const drivers::Picture& picture, const LightCurve256& curve, int columns, int rows) {
  fixtures::PaneImage light;
  set_light(picture, curve, columns, rows, light);
  return light;
}

void set_light(const drivers::Picture& picture, const LightCurve256& curve, int columns, int rows,
               fixtures::PaneImage& light) {
  light.width = columns;
  light.height = rows;
  light.texels.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  if (columns == picture.width && rows == picture.height) {
    take_codes(picture.view(), curve, light.texels.data());
    return;
  }
  const std::vector<Part> across = parts_of(picture.width, columns), down = parts_of(picture.height, rows);
  std::vector<glm::vec3> line(static_cast<std::size_t>(columns));
  const drivers::PictureView view = picture.view();
  int taken = -1;  // the row that is in `line`; a row of the picture may count for two of the display
  glm::vec3* out = light.texels.data();
  for (const Part& part : down) {
    for (int k = 0; k < part.count; ++k) {
      if (const int y = part.first + k; y != taken) {
        take_row(view.row(y), curve, across, line);
        taken = y;
      }
      const float weight = part.count == 1 ? 1.0f : weight_of(part, k);
      for (std::size_t i = 0; i < line.size(); ++i) out[i] = k == 0 ? weight * line[i] : out[i] + weight * line[i];
    }
    out += columns;
  }
}

struct LightImages::Spare {
  std::mutex mutex;
  std::vector<std::unique_ptr<fixtures::PaneImage>> images;
};

std::shared_ptr<const fixtures::PaneImage> LightImages::light_of(const drivers::Picture& picture,
                                                                 const LightCurve256& curve, int columns, int rows) {
  if (!spare_) {
    spare_ = std::make_shared<Spare>();
    spare_->images.reserve(kSpareMost);
  }
  std::unique_ptr<fixtures::PaneImage> image;
  {
    const std::lock_guard lock(spare_->mutex);
    if (!spare_->images.empty()) {
      image = std::move(spare_->images.back());
      spare_->images.pop_back();
    }
  }
  if (!image) image = std::make_unique<fixtures::PaneImage>();
  set_light(picture, curve, columns, rows, *image);
  return {image.release(), [spare = spare_](fixtures::PaneImage* done) {
            std::unique_ptr<fixtures::PaneImage> own(done);
            const std::lock_guard lock(spare->mutex);
            if (spare->images.size() < kSpareMost) spare->images.push_back(std::move(own));
          }};
}

}  // namespace footlight::tools

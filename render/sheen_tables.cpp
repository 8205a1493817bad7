#include "render/sheen_tables.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace footlight::render {
namespace {

float apart(const SheenRow& a, const SheenRow& b) {
  const glm::vec3 color = glm::abs(glm::vec3(a.color) - glm::vec3(b.color));
  return std::abs(a.roughness - b.roughness) + std::abs(a.metal - b.metal) + color.x + color.y + color.z;
}

}  // namespace

std::uint32_t SheenTable::number(const std::optional<fixtures::Sheen>& sheen, const glm::vec3& color) {
  if (!sheen || sheen->matt()) return 0;
  const SheenRow row{vec4(glm::clamp(color, 0.0f, 1.0f), 0), static_cast<float>(sheen->roughness),
                     static_cast<float>(sheen->metal), 0, 0};
  std::size_t nearest = rows_.size();
  for (std::size_t i = 1; i < rows_.size(); ++i) {
    if (nearest == rows_.size() || apart(rows_[i], row) < apart(rows_[nearest], row)) nearest = i;
  }
  if (nearest == rows_.size() || (apart(rows_[nearest], row) > 0 && rows_.size() < FL_SHEENS_MAX)) {
    nearest = rows_.size();
    rows_.push_back(row);
  }
  if (apart(rows_[nearest], row) > 0) joined_.emplace(row.roughness, row.metal, row.color.x, row.color.y, row.color.z);
  return static_cast<std::uint32_t>(nearest);
}

std::optional<fixtures::Diagnostic> SheenTable::warning(const std::string& rig) const {
  if (joined_.empty()) return {};
  const std::size_t own = rows_.size() - 1;
  return fixtures::Diagnostic{
      fixtures::Severity::kWarning,
      "materials-too-many",
      {rig},
      fmt::format("{} materials that are not matt, and a picture has {}", own + joined_.size(), own),
      fmt::format("{} of them look like the most similar of the first {}", joined_.size(), own)};
}

}  // namespace footlight::render

// Materials with sheen, as a table.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "fixtures/model/diagnostic.h"
#include "fixtures/model/sheen.h"
#include "render/frame_io.h"

namespace footlight::render {

class SheenTable {
 public:
  // The row of a material; 0 of a matt one. color: of a fixture's body, what it reflects as a metal. Past FL_SHEENS_MAX
  // different ones the nearest row.
  [[nodiscard]] std::uint32_t number(const std::optional<fixtures::Sheen>& sheen,
                                     const glm::vec3& color = glm::vec3(0));
  [[nodiscard]] const std::vector<SheenRow>& rows() const { return rows_; }
  // How many different materials have a row that is not theirs.
  [[nodiscard]] std::size_t joined() const { return joined_.size(); }
  // What was done with them, of a rig of this name; nothing: each has its own row.
  [[nodiscard]] std::optional<fixtures::Diagnostic> warning(const std::string& rig) const;

 private:
  std::vector<SheenRow> rows_{{vec4(0), 1, 0, 0, 0}};
  std::set<std::tuple<float, float, float, float, float>> joined_;  // roughness, metal, color
};

}  // namespace footlight::render

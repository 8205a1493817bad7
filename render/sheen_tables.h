// Materials with sheen, as a table.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

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
  // How many materials have a row that is not theirs.
  [[nodiscard]] std::uint32_t joined() const { return joined_; }

 private:
  std::vector<SheenRow> rows_{{vec4(0), 1, 0, 0, 0}};
  std::uint32_t joined_ = 0;
};

}  // namespace footlight::render

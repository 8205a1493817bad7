// Which fixture is at a point of the picture, and where fixtures are in it. On the CPU, by boxes around bodies: the
// visibility buffer knows no boxes of the stage, has nothing at all where bodies are left out, and a fixture far away
// covers less than the pixel under the mouse. A box is exact enough to click on (decision 0135).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/model/rig.h"
#include "tools/footlight/preview/ui/stage_rays.h"

namespace footlight::tools {

class StagePick {
 public:
  // Computes a box for every mode in use: around its models, or the built-in body, with every axis at its default.
  explicit StagePick(const fixtures::Rig& rig);

  // -1: none. Of the boxes that the ray meets before a box of the stage, the nearest; else the fixture whose middle is
  // nearest to the point and within reach_units of it.
  [[nodiscard]] int fixture_at(const StagePlace& place, glm::dvec2 at, double reach_units = 10) const;

  // The fixtures whose middle is in a rectangle of the picture, ascending. Boxes of the stage hide what is behind them,
  // as for fixture_at().
  [[nodiscard]] std::vector<int> fixtures_in(const StagePlace& place, glm::dvec2 low, glm::dvec2 high) const;

  // The rectangle around a fixture; nothing if it is behind the camera or beside the picture.
  struct Mark {
    glm::dvec2 low{0};
    glm::dvec2 high{0};
  };
  [[nodiscard]] std::optional<Mark> mark_of(const StagePlace& place, int fixture) const;

  // The box of a fixture in fixture space, metres.
  struct Box {
    glm::dvec3 low_m{1e30};
    glm::dvec3 high_m{-1e30};
  };
  [[nodiscard]] const Box& box_of(int fixture) const { return boxes_[box_index_[static_cast<std::size_t>(fixture)]]; }
  // Around these fixtures, in stage space: what Frame selection shows.
  [[nodiscard]] Box bounds_of(std::span<const int> which) const;

 private:
  [[nodiscard]] glm::dvec3 middle_of(std::size_t fixture) const;
  // The depth of the first box of the stage on a way from the camera, in lengths of the way.
  [[nodiscard]] double wall_on(const glm::dvec3& from, const glm::dvec3& way) const;

  const fixtures::Rig& rig_;
  std::vector<Box> boxes_;              // of each mode in use
  std::vector<std::size_t> box_index_;  // of each fixture
};

}  // namespace footlight::tools

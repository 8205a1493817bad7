// The judge of scanned lasers, by brute force in double: the path of the scanner is cut into short times, each of them
// is a beam that stands still, and that is cut into short pieces and into filaments across. Every bit of light is put
// where the camera sees it, spread over the pixels by the definition of a pixel (render/shaders/shared/laser.h). It
// shares no formula with the closed form: no chord, no error function, no sheet.
#pragma once

#include <functional>
#include <vector>

#include <glm/glm.hpp>

#include "render/image.h"
#include "render/reference/judge.h"
#include "sim/core/result.h"

namespace footlight::render {

// The scanner goes from one place to another, straight and evenly in the angles of its two mirrors.
struct JudgeMove {
  glm::dvec2 from_rad{0};
  glm::dvec2 to_rad{0};
  double share = 1;  // of the exposure
  glm::dvec3 rgb{1};
};

struct JudgeLaser {
  glm::dvec3 lens_m{0};
  glm::dvec3 right{1, 0, 0};  // orthonormal
  glm::dvec3 up{0, 0, 1};
  glm::dvec3 axis{0, 1, 0};
  double sigma_m = 0.001;  // deviation of the light across, as it leaves
  double slope = 0.0003;   // of it with the distance, far away
  double range_m = 100;
  glm::dvec3 flux_lm{1000};
  std::vector<JudgeMove> moves;
};

// The lasers of a rig as the states of the walker have them. The path is the figure's points, not the parts that the
// compiled tables have of it; an exposure of less than a pass shows its share of them.
[[nodiscard]] Result<std::vector<JudgeLaser>> judged_lasers(const fixtures::Rig& rig, fixtures::f64::Walker& walker,
                                                            double range_m);

// Light of the lasers in the air and on the boxes of a scene, cd/m^2; 3 values a pixel. step_px: length of the pieces
// in the picture; half of it tells the judge's own error. go_on is optional and is called at times with the share that
// is done; false ends it, and the result is empty.
[[nodiscard]] std::vector<double> judge_lasers(const JudgeScene& scene, const std::vector<JudgeLaser>& lasers,
                                               const View& view, int width, int height, double step_px = 0.3,
                                               const std::function<bool(double done)>& go_on = {});

}  // namespace footlight::render

// The judge of pictures: the light model of docs/numerics.md by adaptive quadrature in double.
//
// It shares no formula with render/shaders/shared/beam.h: the integrand along the ray is written in stage space from
// the definition of the beam, and Gauss-Kronrod 15 (Boost.Math) refines it until its own error estimate is below a
// tolerance. Every picture is computed at a tolerance and again, from other pieces, at a hundredth of it; the
// difference is the judge's stated error.
//
// The model: single scattering in homogeneous haze, Henyey-Greenstein, diffuse boxes that hide light along the paths on
// which it travels in its beam. Fixture bodies are left out of judged pictures.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "fixtures/model/gloss.h"
#include "fixtures/model/rig.h"
#include "fixtures/simulate/walker.h"
#include "render/haze.h"
#include "render/image.h"

namespace footlight::render {

// The share of light that a gobo transmits at (x, y) in the unit disc, 0 to 1. gobo > 0: the layer of the compiled
// rig's images.
using GoboTransmission = std::function<double(int gobo, double x, double y)>;
// The same for red, green and blue.
using GoboColors = std::function<glm::dvec3(int gobo, double x, double y)>;

// A gobo wheel of a beam.
struct JudgeWheel {
  int image = 0;      // 0: open
  int next = 0;       // image of the neighbouring slot that reaches into the gate
  double offset = 0;  // of the image's centre from that of the beam, in beam radii
  double cos = 1;     // of the image's rotation
  double sin = 0;
};

// Intensity over peak intensity towards (x, y, 1) in the light space of a beam.
using MeasuredShare = std::function<double(double x, double y)>;

// One beam in stage space, in metres. The axes are orthonormal; x cross y = axis, or -axis if a prism mirrors it.
struct JudgeBeam {
  glm::dvec3 lens_m{0};
  glm::dvec3 x_axis{1, 0, 0};
  glm::dvec3 y_axis{0, 1, 0};
  glm::dvec3 axis{0, 0, 1};
  double lens_radius_m = 0.05;  // R0 > 0
  double spread = 0.1;          // k = tan(half angle) >= 0
  double profile_power = 1;     // f = 1 - rho^(2m); below 1: (1 - rho^2)^(1/m)
  double range_m = 100;         // along the axis; the light ends there
  glm::dvec3 strength_lm{1};    // J0 per channel
  JudgeWheel wheels[2];
  int animation = 0;  // image of the animation wheel; 0: none
  double animation_cos = 1;
  double animation_sin = 0;
  double gobo_scale = 1;    // share of the images' radius that is inside the beam
  double blur = 0;          // blur of images by frost: radius in beam radii
  double focus_per_m = -1;  // below 0: images are sharp at every distance
  int blur_points = 64;     // of the disc over which a blur is the mean
  double aspect = 0;  // width over height of a rectangular beam; then lens radius and k are those of half its width,
                      // and f is the product of one profile in x and one in y. 0: round
  MeasuredShare measured;  // replaces f; rho = 1 is at measured_spread
  double measured_spread = 0;
  double shown = 1;               // share of the radius of f inside the iris; f ends there
  std::vector<glm::dvec3> edges;  // of blades: points with x X + y Y <= z are lit
};

// What hides light: a parallelepiped, from its centre to the middles of three of its faces.
struct JudgeSolid {
  glm::dvec3 center_m{0};
  glm::dvec3 half_m[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  double slack_m = 1e-6;  // it hides nothing of what is so little behind where light enters it
};

// A pane of glass that the sun shines through.
struct JudgePane {
  glm::dvec3 center_m{0};
  glm::dvec3 right_m{0.5, 0, 0};  // to the middles of two edges, as the image has them; perpendicular
  glm::dvec3 up_m{0, 0, 0.5};
  std::shared_ptr<const fixtures::PaneImage> image;  // null: even
  glm::dvec3 color{1};                               // share of light that passes, times that of the image
};
struct JudgeSun {
  glm::dvec3 direction{0, 0, -1};  // unit
  glm::dvec3 light_lx{0};          // across it
  glm::dvec3 sky_cd_m2{0};         // luminance of the sky behind the panes
  double range_m = 100;            // light ends this far from a pane
};

// A display: a rectangle of pixels that shines to the side of right x up.
struct JudgeDisplay {
  glm::dvec3 center_m{0};
  glm::dvec3 right_m{0.5, 0, 0};  // to the middles of two edges, as the image has them; perpendicular
  glm::dvec3 up_m{0, 0, 0.5};
  int columns = 1;
  int rows = 1;
  std::vector<glm::dvec3> pixels_cd_m2{glm::dvec3(1)};  // rows from the top
};

struct Ray {
  glm::dvec3 origin_m{0};
  glm::dvec3 direction{0, 0, 1};  // unit
};

struct SurfaceHit {
  double t_m = 0;
  glm::dvec3 normal{0};
  glm::dvec3 albedo{0};
  std::optional<fixtures::Sheen> sheen;  // null: matt
  bool shaped = false;                   // even light shows its form, as that of everything but boxes
};
using RayHit = std::function<std::optional<SurfaceHit>(const Ray& ray)>;

// Illuminance at a point by what surfaces reflect, by side x side paths (bounce_judge.h).
using BouncedLux = std::function<glm::dvec3(const glm::dvec3& point_m, const glm::dvec3& normal, int side)>;

// Density of haze at a place on the stage, over that of even haze.
using HazeDensity = std::function<double(const glm::dvec3& place_m)>;

struct JudgeScene {
  std::vector<JudgeBeam> beams;    // only lit ones
  std::vector<JudgeSolid> solids;  // empty: nothing hides light
  std::vector<glm::dvec2> lens;    // points of the unit disc from which light is hidden, each with an equal share of
                                   // the lens (judge_lens()); empty: shadows are those of the model, with hard edges
  std::vector<fixtures::StageBox> boxes;
  RayHit others;  // what else stands on the stage (judge_mesh.h); empty: nothing
  JudgeSun sun;
  std::vector<JudgePane> panes;
  std::vector<JudgeDisplay> displays;
  std::vector<JudgeDisplay> display_lights;  // what shines into the air and on surfaces instead; empty: the displays
  std::vector<fixtures::GlossTop> glosses;  // of boxes: tops that mirror (gloss_judge.h)
  int gloss_rays = 256;                     // that a rough one sends
  int sheen_rays = 0;  // that a surface with sheen sends for what it mirrors (probe_judge.h); 0: it mirrors nothing
  bool matt = false;     // nothing has a sheen
  BouncedLux bounced_lx;  // empty: surfaces reflect no light to others
  int bounced_side = 8;   // of its paths
  fixtures::Haze haze;
  HazeDensity density;          // empty: haze is even
  bool even_extinction = true;  // light is lost as in even haze; false: to the density on its way, 1000 times slower;
                                // light of the sun is lost as in even haze in both
  PlumeField plumes;            // of machines, part of `density` (plume_judge.h); light is lost in them to the eye
  double ambient_lx = 0;
  double range_m = 100;   // no air further away than this from the camera is drawn
  GoboTransmission gobo;  // empty: every gobo is open
  GoboColors colors;      // used instead of `gobo` if images are coloured
};

// Returns the scene of a rig with the states of the walker, including everything that shapes its beams. Facets of a
// prism become separate beams. The walker is not stepped; it is not const because the shared functions are its members.
// A measured beam has the candela of its file, which is read again instead of using the compiled table. Frost, blades,
// focus and wheels between two slots are defined in render/shaders/shared/optics.h. A blur is the mean over some
// points of a disc here. time_ns: of the show, for clouds of haze that drift.
[[nodiscard]] JudgeScene judge_scene(const fixtures::Rig& rig, fixtures::f64::Walker& walker,
                                     GoboTransmission gobo = {}, std::int64_t time_ns = 0);

// Integral of f (1 + k^2 rho^2)^(-3/2) over the unit disc by adaptive quadrature: flux in lumens over J0. f is
// evaluated at shown rho.
[[nodiscard]] double judge_flux_factor(double spread, double profile_power, double shown = 1);
// The same over a rectangle as wide as the lens diameter, with that width over `aspect` as its height.
[[nodiscard]] double judge_rectangle_factor(double spread, double profile_power, double aspect, double shown = 1);

// In-scattered light of one beam along a ray from t_min_m to t_max_m (may be infinite), over sigma_s J0, in 1/m.
// Extinction counts from the lens to the air and back to t = 0. Input that is not finite gives 0. lens: as in
// JudgeScene.
[[nodiscard]] double judge_inscatter(const JudgeBeam& beam, const fixtures::Haze& haze, const Ray& ray, double t_min_m,
                                     double t_max_m, const GoboTransmission& gobo, double tolerance,
                                     std::span<const JudgeSolid> solids = {}, std::span<const glm::dvec2> lens = {});

// Whether a solid hides the light of a beam at a point of the beam: the path from the lens to there enters the solid
// more than its slack before its end.
[[nodiscard]] bool judge_hides(const JudgeBeam& beam, const JudgeSolid& solid, const glm::dvec3& point_m);
// The same of light that goes straight from a place on the lens.
[[nodiscard]] bool judge_hides_from(const glm::dvec3& lens_m, const JudgeSolid& solid, const glm::dvec3& point_m);

// `count` places in the unit disc, which have equal areas around them (a sunflower's).
[[nodiscard]] std::vector<glm::dvec2> judge_lens(int count);
// Share of the places of a lens from which light reaches a point; without places: along the model's path, 0 or 1.
[[nodiscard]] double judge_lit(const JudgeBeam& beam, std::span<const glm::dvec2> lens,
                               std::span<const JudgeSolid> solids, const glm::dvec3& point_m);

// Illuminance over J0 of one beam on a surface with unit normal at a point, in 1/m^2, with extinction.
[[nodiscard]] double judge_illuminance(const JudgeBeam& beam, const fixtures::Haze& haze, const glm::dvec3& point_m,
                                       const glm::dvec3& normal, const GoboTransmission& gobo);

// Returns the nearest box that the ray enters from outside, or what else it meets before.
[[nodiscard]] std::optional<SurfaceHit> judge_hit(const JudgeScene& scene, const Ray& ray);

// Radiance along a ray, cd/m^2 per channel.
[[nodiscard]] glm::dvec3 judge_radiance(const JudgeScene& scene, const Ray& ray, double tolerance);

// The ray of pixel (x, y); see render/image.h.
[[nodiscard]] Ray pixel_ray(const View& view, int width, int height, int x, int y);

struct JudgeOptions {
  double tolerance = 1e-7;   // relative, of each integral; the picture is computed at a hundredth of it
  int threads = 0;           // 0: one per core. The picture does not depend on it.
  bool stated_error = true;  // false: only the finer pass is computed, own_* are 0
  // Called at times on the caller's thread, with the number of finished pixels; false ends the picture.
  std::function<bool(int done, int all)> go_on;
};

struct JudgedImage {
  RadianceImage image;      // `rgb` rounded to float
  std::vector<double> rgb;  // the same in double
  double own_rel_l2 = 0;    // between the tolerance and a hundredth of it
  double own_max = 0;       // largest difference over (value + 1e-2 mean)
  double hits_per_px = 0;   // mean number of beams that the visible part of a pixel's ray crosses
  bool whole = true;        // false: go_on ended it, and pixels are missing
};

// Some pixels of a picture.
struct JudgedPixels {
  std::vector<double> rgb;   // 3 values per pixel, in the order of `pixels`
  std::vector<double> hits;  // per pixel: how many beams the visible part of its ray crosses
  double own_rel_l2 = 0;     // as in JudgedImage, over these pixels
  double own_max = 0;
  bool whole = true;  // false: go_on ended it, and pixels are missing
};

// Computes the pixels y * width + x of a picture of width x height.
[[nodiscard]] JudgedPixels judge_pixels(const JudgeScene& scene, const View& view, int width, int height,
                                        std::span<const std::uint32_t> pixels, const JudgeOptions& options = {});
// Computes all pixels.
[[nodiscard]] JudgedImage judge_image(const JudgeScene& scene, const View& view, int width, int height,
                                      const JudgeOptions& options = {});

}  // namespace footlight::render

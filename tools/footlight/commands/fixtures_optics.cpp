// Compares the beams and colours as drawn with those of the definition.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "fixtures/displays/screens.h"
#include "fixtures/model/color.h"
#include "fixtures/photometry/attach.h"
#include "fixtures/photometry/fit.h"
#include "tools/footlight/commands/fixtures_command.h"

namespace footlight::tools {

using namespace fixtures;

namespace {

// How the geometries of a beam draw it: sizes of its tubes, each once, and whether some draw it as a beam.
struct BeamUse {
  std::vector<glm::dvec2> tubes_m;
  bool as_beam = false;
};
BeamUse use_of(const FixtureType& type, std::size_t beam) {
  BeamUse use;
  bool any = false;
  for (const Mode& mode : type.modes) {
    for (const Geometry& geometry : mode.geometries) {
      if (geometry.beam != static_cast<int>(beam)) continue;
      any = true;
      const glm::dvec2 size = geometry.tube_m;
      use.as_beam = use.as_beam || size == glm::dvec2(0);
      const bool is_new = std::find(use.tubes_m.begin(), use.tubes_m.end(), size) == use.tubes_m.end();
      if (size != glm::dvec2(0) && is_new) use.tubes_m.push_back(size);
    }
  }
  use.as_beam = use.as_beam || !any;
  return use;
}

std::string tube_line(const Beam& beam, const glm::dvec2& size_m) {
  return fmt::format(
      "  {:.5g} lm, a tube {:.4g} m long and {:.4g} m wide: drawn as a face of {:.4g} cd/m2, {:.4g} cd straight before "
      "it, {:.4g} cd at 60 degrees\n",
      beam.flux_lm, std::max(size_m.x, size_m.y), std::min(size_m.x, size_m.y), tube_nits(beam, size_m),
      beam.flux_lm / std::numbers::pi, beam.flux_lm / std::numbers::pi / 2);
}

}  // namespace

std::string optics_of_type(const FixtureType& type) {
  std::string text;
  const auto out = std::back_inserter(text);
  if (!type.beams.empty()) {
    text += "Beams as drawn: angles at 50 % and 10 % of the peak, and the larger of their errors\n";
  }
  std::vector<std::string> seen;
  const auto add_line = [&](const std::string& line) {
    if (std::find(seen.begin(), seen.end(), line) != seen.end()) return;  // pixels are all equal
    seen.push_back(line);
    text += line;
  };
  for (std::size_t i = 0; i < type.beams.size(); ++i) {
    const Beam& beam = type.beams[i];
    const BeamUse use = use_of(type, i);
    for (const glm::dvec2& tube_m : use.tubes_m) add_line(tube_line(beam, tube_m));
    if (!use.as_beam) continue;
    const BeamFit fit = drawn_beam(beam);
    std::string line;
    if (!beam.photometry.empty()) {
      const auto photometry = read_photometry_file(type.files, beam.photometry);
      const Side side = beam.photometry_back ? Side::kBack : Side::kFront;
      line = fmt::format("  {}\n",
                         photometry ? measured_text(measured_table(*photometry, side)) : photometry.error().message);
      if (photometry && side == Side::kFront) {
        Diagnostics energy;
        energy_check(*photometry, beam.photometry, energy);
        for (const Diagnostic& one : energy.all()) line += fmt::format("  {}: {}\n", beam.photometry, one.message);
      }
    } else if (const auto rectangle = rectangle_of(beam)) {
      const double half_width = std::tan(rectangle->half_angle_rad);
      const auto full_deg = [](double tangent) { return 2 * std::atan(tangent) * 180 / std::numbers::pi; };
      line = fmt::format("  {:.5g} lm, a rectangle of {:.4g} by {:.4g} degrees\n", beam.flux_lm, full_deg(half_width),
                         full_deg(half_width / rectangle->aspect));
    } else if (beam.profile_power > 0) {
      line = fmt::format(
          "  {:.5g} lm, m = {} and {:.4g} deg at the edge: drawn {:.4g} and {:.4g} deg, {:.6g} cd in the middle\n",
          fit.flux_lm, fit.profile_power, 2 * std::atan(fit.spread) * 180 / std::numbers::pi, fit.beam_angle_deg,
          fit.field_angle_deg, fit.peak_cd);
    } else {
      line = fmt::format(
          "  {:.5g} lm, {:.4g} and {:.4g} deg: drawn {:.4g} and {:.4g} deg, {:.1f} % off, {:.4g} cd in the "
          "middle{}{}\n",
          beam.flux_lm, beam.beam_angle_deg, beam.field_angle_deg, fit.beam_angle_deg, fit.field_angle_deg,
          100 * fit.angle_error, fit.peak_cd, fit.assumed.empty() ? "" : "; ", fit.assumed);
    }
    add_line(line);
  }
  const std::vector<ColorError> rows = color_report(type);
  if (rows.empty()) return text.empty() ? "no beams and no colours\n" : text;
  text += "Colours as drawn: CIEDE2000 to the definition, and the part of it that mixing in RGB causes\n";
  double worst = 0;
  double sum = 0;
  for (const ColorError& row : rows) {
    fmt::format_to(
        out, "  {:<40} x {:.4f} y {:.4f} Y {:6.2f}  drawn x {:.4f} y {:.4f} Y {:6.2f}  {:5.2f}  mixing {:5.2f}{}\n",
        row.what, row.reference.x, row.reference.y, row.reference.Y, row.drawn.x, row.drawn.y, row.drawn.Y, row.delta_e,
        row.delta_e_mixing, row.by_spectrum ? "" : "  (no spectrum)");
    worst = std::max(worst, row.delta_e);
    sum += row.delta_e;
  }
  fmt::format_to(out, "  mean {:.2f}, worst {:.2f}\n", sum / static_cast<double>(rows.size()), worst);
  return text;
}

}  // namespace footlight::tools

#include "tools/footlight/report/sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

namespace footlight::tools {
namespace {

struct SweepName {
  std::string_view name;
  Sweep::Of of;
  double least, most;
  const char* axis;
};
constexpr SweepName kSweepNames[] = {{"beams", Sweep::Of::kBeams, 1, 1e6, "beams"},
                                     {"pixels", Sweep::Of::kPixels, 144, 1e9, "pixels"},
                                     {"gobos", Sweep::Of::kGobos, 0, 100, "per cent of the beams that have a gobo"},
                                     {"clutter", Sweep::Of::kClutter, 0, 1e5, "boxes on the floor"}};

const SweepName& sweep_name(Sweep::Of of) {
  return *std::find_if(std::begin(kSweepNames), std::end(kSweepNames),
                       [of](const SweepName& each) { return each.of == of; });
}

}  // namespace

const char* axis_of(const Sweep& sweep) { return sweep_name(sweep.of).axis; }

Result<Sweep> parse_sweep(const std::string& text) {
  const auto wrong = [&] {
    return fail(ErrorCode::kBadInput,
                "--sweep: expected beams=, pixels=, gobos= (0 to 100 per cent) or clutter= and numbers with commas, "
                "as in beams=100,1000");
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return wrong();
  const auto found = std::find_if(std::begin(kSweepNames), std::end(kSweepNames),
                                  [&](const SweepName& each) { return each.name == text.substr(0, equals); });
  if (found == std::end(kSweepNames)) return wrong();
  Sweep sweep{found->of, {}};
  for (std::size_t at = equals + 1; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string number = text.substr(at, end - at);
    char* rest = nullptr;
    const double value = std::strtod(number.c_str(), &rest);
    if (number.empty() || *rest != 0 || !(value >= found->least && value <= found->most)) return wrong();
    sweep.values.push_back(value);
    at = end + 1;
  }
  return sweep;
}

Result<Scene> scene_of_sweep(const Sweep& sweep, double value, const SweepScene& scene, PictureReportOptions& options) {
  SweepScene of = scene;
  switch (sweep.of) {
    case Sweep::Of::kBeams: of.beams = static_cast<int>(value); break;
    case Sweep::Of::kGobos: of.gobo_share = value / 100; break;
    case Sweep::Of::kClutter: of.clutter = static_cast<int>(value); break;
    case Sweep::Of::kPixels: {
      const double unit = std::sqrt(value / 144);  // 16 x 9
      options.width = std::max(static_cast<int>(std::lround(16 * unit)), 1);
      options.height = std::max(static_cast<int>(std::lround(9 * unit)), 1);
      break;
    }
  }
  FL_ASSIGN(Scene made, make_beams_scene(of.beams, {}, of.gobo_share, of.clutter, of.wheels));
  if (sweep.of == Sweep::Of::kPixels) made.name += fmt::format(", {}x{}", options.width, options.height);
  return made;
}

}  // namespace footlight::tools

// footlight laser: what is in ILDA files, and how far the lasers of a rig are above the MPE.
#include <cmath>
#include <cstdio>
#include <memory>

#include "fixtures/laser/ilda.h"
#include "fixtures/laser/safety.h"
#include "sim/core/counted.h"
#include "tools/footlight/command.h"

namespace footlight::tools {
namespace {

struct Options {
  std::vector<std::string> paths;
  std::string rig;
  std::vector<std::string> places;
};

Result<int> check(const Options& options) {
  if (options.paths.empty()) return fail(ErrorCode::kBadInput, "laser check: expected ILDA files, such as logo.ild");
  bool refused = false;
  for (const std::string& path : options.paths) {
    auto file = fixtures::load_ilda(path);
    if (!file) {
      fmt::print(stderr, "footlight: {}\n", file.error().message);
      refused = true;
      continue;
    }
    std::size_t most = 0;
    for (const fixtures::LaserFrame& frame : file->figure.frames) most = std::max(most, frame.size());
    fmt::print("{}: {}, {} points ({} of them lit), at most {} in a frame, {}\n", path,
               counted(file->figure.frames.size(), "frame"), file->points, file->lit_points, most,
               counted(file->palettes, "palette"));
    for (const std::string& note : file->notes) fmt::print("  {}\n", note);
  }
  FL_TRY(flush_output());
  return refused ? kExitFailed : kExitOk;
}

Result<fixtures::LaserPlace> place_of(const std::string& text) {
  fixtures::LaserPlace place{text, {}};
  int used = 0;
  const int count = std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &place.at_m.x, &place.at_m.y, &place.at_m.z, &used);
  const bool finite = std::isfinite(place.at_m.x) && std::isfinite(place.at_m.y) && std::isfinite(place.at_m.z);
  if (count != 3 || static_cast<std::size_t>(used) != text.size() || !finite) {
    return fail(ErrorCode::kBadInput, "--at {}: expected X,Y,Z in metres, such as 0,-6,1.6", text);
  }
  return place;
}

std::string duration(double s) {
  return s < 1e-3 ? fmt::format("{:.3g} us", s * 1e6) : fmt::format("{:.3g} ms", s * 1e3);
}

Result<int> safety(const Options& options) {
  std::vector<fixtures::LaserPlace> places;
  for (const std::string& text : options.places) {
    FL_ASSIGN(const fixtures::LaserPlace place, place_of(text));
    places.push_back(place);
  }
  FL_ASSIGN(const fixtures::Rig rig, fixtures::load_rig(options.rig));
  if (places.empty()) {
    if (rig.usual_camera || rig.made_up_cameras) {
      return fail(ErrorCode::kBadInput, "{}: the rig has no camera; name the places of eyes, such as --at 0,-6,1.6",
                  options.rig);
    }
    for (const fixtures::Camera& camera : rig.cameras) {
      places.push_back({fmt::format("camera \"{}\"", camera.name), camera.position_m});
    }
  }
  FL_ASSIGN(const fixtures::LaserSafety report, fixtures::laser_safety(rig, places));
  if (report.lasers.empty()) {
    return fail(ErrorCode::kNotFound,
                "{}: the rig has no laser; add a [[fixture]] of a type with one, such as type = \"generic/laser\"",
                options.rig);
  }
  for (const std::string& line : report.lasers) fmt::print("{}\n", line);
  bool above = report.not_computed;
  for (const fixtures::LaserSafetyRow& row : report.rows) {
    const double most = std::max(row.still_over, row.exposure.over_mpe);
    above = above || (row.in_field && most > 1);
    fmt::print(
        "{} at {}: {:.1f} m, {}; a beam that stands still {:.3g} times the MPE; {} {:.3g} times (on the pupil {} "
        "at a time, {} in a pass of {}; asked at {} of {} places in {} of {} frames)\n",
        row.fixture, row.place, row.distance_m,
        row.moves      ? "taken as in the field of its scanner, since pan or tilt turns it"
        : row.in_field ? "in the field of its scanner"
                       : "beside the field of its scanner as it hangs",
        row.still_over, row.worst, row.exposure.over_mpe, duration(row.exposure.on_s),
        counted(static_cast<std::size_t>(row.exposure.times), "time"), duration(row.exposure.pass_s),
        row.exposure.places_asked, row.exposure.places, row.exposure.frames_asked, row.exposure.frames);
  }
  fmt::print(
      "Computed from IEC 60825-1's limits for visible light, at full power and full size. This is a report of "
      "figures and no statement that anything is safe: docs/lasers.md says what it leaves out.\n");
  FL_TRY(flush_output());
  return above ? kExitFailed : kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  Arguments files = arguments.subcommand("check", "Print what is in ILDA files: frames, points, and what is wrong",
                                         "  footlight laser check logo.ild\n"
                                         "Exit code 1 if a file has no frame to show.");
  files.words("FILE", options->paths, "ILDA files (.ild)");
  files.job([options]() -> Result<int> { return check(*options); });
  Arguments rig =
      arguments.subcommand("safety", "Compare the lasers of a rig with the maximum permissible exposure of the eye",
                           "  footlight laser safety club.toml\n"
                           "  footlight laser safety club.toml --at 0,-6,1.6\n"
                           "Places are the rig's cameras unless --at names some. Exit code 1 if a place in the field "
                           "of a laser is above the "
                           "MPE, or if the wavelength of a laser is not computed. The report does not say that "
                           "anything is safe.");
  rig.word("RIG", options->rig, "a rig file");
  rig.list("--at", options->places, "X,Y,Z", "a place of eyes, metres; may be given several times");
  rig.job([options]() -> Result<int> { return safety(*options); });
}

}  // namespace

extern const CommandInfo laser_command{
    .name = "laser",
    .help = "Check ILDA files, and compare lasers with the exposure that eyes may get",
    .examples =
        "  footlight laser check logo.ild\n"
        "  footlight laser safety club.toml --at 0,-6,1.6\n",
    .add = add,
};

}  // namespace footlight::tools

#include "tools/footlight/pictures/scene_files.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <utility>

#include "fixtures/files/import/import_rig.h"
#include "sim/core/counted.h"
#include "tools/demo_show/demo_assets.h"
#include "tools/footlight/sound/sound_log.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {

void add_scene_arguments(Arguments& arguments, SceneFiles& files) {
  arguments.option("RIG,--rig", files.rig, "FILE", "the rig: TOML, MVR or QLC+; or one fixture definition");
  arguments.option("--log", files.log, "FILE", "the levels: a DMX log, an OLA show file, a capture or a sound map");
  arguments.flag("--vrsl-compat", files.vrsl, "draw VRSL fixtures as VRSL does, with its errors (docs/vrsl.md)");
  arguments.flag("--demo", files.demo, "the built-in rig, driven by the built-in show");
  arguments.option("--smooth", files.smooth, "SECONDS", "smooth the levels: 0.1, or Pan=0.1,Tilt=0.1,Dimmer=0.05");
  arguments.option("--dimmer-law", files.dimmer_law, "LAW",
                   "of every fixture: linear, square, s, 'inverse square'; default: as defined");
  arguments.option("--haze", files.haze_per_m, 0, 10,
                   "scattering of the room's own haze, 1/m; default: as in the rig, or 0.02");
  arguments.option("--haze-noise", files.haze_noise, 0, 1,
                   "clouds of haze: how far its density is from the even one; with a slow draught where the rig has no "
                   "wind; 0: no clouds; default: as in the rig, or 0");
  arguments.option("--plumes", files.plumes, "WORD",
                   "haze that is seen in front of machines before it has mixed: on or off; default: as in the rig, or "
                   "on");
  arguments.option("--room", files.volume_m3, 1, 1e7,
                   "m^3 that haze and fog machines fill; default: as in the rig, or 1000");
}

Result<fixtures::Rig> load_scene_rig(const SceneFiles& files) {
  if (!files.rig.empty() && files.demo) {
    return fail(ErrorCode::kBadInput, "expected a rig or --demo, not both");
  }
  if (files.demo) {
    fixtures::Rig rig = fixtures::demo_rig();
    FL_TRY(adjust_scene_rig(rig, files));
    return rig;
  }
  if (files.rig.empty()) {
    return fail(ErrorCode::kBadInput, "no rig: expected a file, or --demo for the built-in rig");
  }
  FL_ASSIGN(fixtures::ImportedRig imported, fixtures::import_rig(files.rig));
  const auto wrong =
      std::count_if(imported.diagnostics.begin(), imported.diagnostics.end(),
                    [](const fixtures::Diagnostic& one) { return one.severity != fixtures::Severity::kNote; });
  if (wrong > 0) {
    const std::string path = printable_utf8(files.rig);
    fmt::print(stderr, "footlight: {}: {}; 'footlight rig check {}' lists them\n", path, counted(wrong, "warning"),
               path);
  }
  fixtures::Rig rig = std::move(imported.rig);
  FL_TRY(adjust_scene_rig(rig, files));
  return rig;
}

void print_warnings(const std::vector<fixtures::Diagnostic>& diagnostics) {
  for (const fixtures::Diagnostic& one : diagnostics) {
    if (one.severity == fixtures::Severity::kNote) continue;
    fmt::print(stderr, "footlight: {}\n", printable_line(fixtures::text(one)));
  }
}

Result<std::optional<LogReader>> open_scene_log(const SceneFiles& files) {
  std::optional<LogReader> log;
  if (!files.log.empty()) {
    FL_ASSIGN(log, read_level_log(files.log));
  } else if (files.demo) {
    const auto bytes = demo::demo_log_bytes();
    FL_ASSIGN(log, LogReader::open_bytes({bytes.begin(), bytes.end()}, "the built-in show"));
  }
  return log;
}

Result<PictureSize> parse_size(const std::string& text) {
  constexpr int kSizeMax = 16'384;
  PictureSize size;
  const char* end = text.data() + text.size();
  const auto [at, width_fault] = std::from_chars(text.data(), end, size.width);
  if (width_fault == std::errc() && at != end && *at == 'x') {
    const auto [rest, height_fault] = std::from_chars(at + 1, end, size.height);
    if (height_fault == std::errc() && rest == end && size.width >= 1 && size.height >= 1 && size.width <= kSizeMax &&
        size.height <= kSizeMax) {
      return size;
    }
  }
  return fail(ErrorCode::kBadInput, "size '{}': expected width x height from 1x1 to {}x{}, for example 1280x720", text,
              kSizeMax, kSizeMax);
}

Result<fixtures::Camera> find_camera(const fixtures::Rig& rig, const std::string& name) {
  if (name.empty()) return rig.cameras.front();
  std::string names;
  for (const fixtures::Camera& camera : rig.cameras) {
    if (camera.name == name) return camera;
    names += (names.empty() ? "" : ", ") + camera.name;
  }
  return fail(ErrorCode::kBadInput, "camera '{}': this rig has {}", name, names);
}

}  // namespace footlight::tools

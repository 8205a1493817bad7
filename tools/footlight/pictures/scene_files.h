// Which rig and which log: the options that render, preview and report share.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "sim/dmx_log/dmx_log.h"
#include "tools/footlight/command.h"

namespace footlight::tools {

struct SceneFiles {
  std::string rig;                   // path; empty with demo
  std::string log;                   // path; may be empty
  bool vrsl = false;                 // VRSL fixtures as VRSL shows them, whether the rig says so or not
  bool demo = false;                 // the embedded rig, and the embedded log where no other is named
  std::string smooth;                // of levels, as fixtures/model/smoothing.h reads it; empty: as the rig says
  std::string dimmer_law;            // of all fixtures; empty: as the rig says
  std::optional<double> haze_per_m;  // scattering of the room's own haze; as the rig says
  std::optional<double> volume_m3;   // of the room that machines fill; as the rig says
};

// The rig, as the first word or behind --rig; --log, --demo and what changes the rig.
void add_scene_arguments(Arguments& arguments, SceneFiles& files);

// The rig that is named; kBadInput where neither a file nor --demo is given.
[[nodiscard]] Result<fixtures::Rig> load_scene_rig(const SceneFiles& files);
// What is wrong, on standard error; notes are left out.
void print_warnings(const std::vector<fixtures::Diagnostic>& diagnostics);
// The log that is named; nothing where none is.
[[nodiscard]] Result<std::optional<LogReader>> open_scene_log(const SceneFiles& files);

// "1280x720" as --size takes it: 1x1 to 16384x16384.
struct PictureSize {
  int width = 0;
  int height = 0;
};
[[nodiscard]] Result<PictureSize> parse_size(const std::string& text);

// The rig's camera of this name; the first one where the name is empty. kBadInput lists the names.
[[nodiscard]] Result<fixtures::Camera> find_camera(const fixtures::Rig& rig, const std::string& name);

}  // namespace footlight::tools

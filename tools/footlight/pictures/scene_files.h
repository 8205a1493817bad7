// The rig and the log: the options that render, preview and report share.
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
  bool vrsl = false;                 // true: VRSL fixtures as VRSL draws them, even without [vrsl] in the rig
  bool demo = false;                 // the built-in rig, and the built-in log unless --log is given
  std::string smooth;                // smoothing of levels, as in fixtures/model/smoothing.h; empty: as in the rig
  std::string dimmer_law;            // of all fixtures; empty: as in the rig
  std::optional<double> haze_noise;  // clouds of haze; default: as in the rig
  std::optional<double> haze_per_m;  // scattering of the room's own haze; default: as in the rig
  std::string plumes;                // "on" or "off"; empty: as in the rig
  std::optional<double> volume_m3;   // of the room that machines fill; default: as in the rig
};

// Adds the rig, as the first word or --rig; --log, --demo and the options that change the rig.
void add_scene_arguments(Arguments& arguments, SceneFiles& files);

// Applies --vrsl-compat, --smooth, --dimmer-law, --haze, --haze-noise, --plumes and --room to a rig.
[[nodiscard]] Status adjust_scene_rig(fixtures::Rig& rig, const SceneFiles& files);
// Loads the rig; kBadInput if neither a file nor --demo is given.
[[nodiscard]] Result<fixtures::Rig> load_scene_rig(const SceneFiles& files);
// Prints errors and warnings on standard error, without notes.
void print_warnings(const std::vector<fixtures::Diagnostic>& diagnostics);
// Opens the log; nullopt if none is given.
[[nodiscard]] Result<std::optional<LogReader>> open_scene_log(const SceneFiles& files);

// "1280x720", the format of --size: 1x1 to 16384x16384.
struct PictureSize {
  int width = 0;
  int height = 0;
};
[[nodiscard]] Result<PictureSize> parse_size(const std::string& text);

// The rig's camera of this name; the first one if the name is empty. The message of kBadInput lists the names.
[[nodiscard]] Result<fixtures::Camera> find_camera(const fixtures::Rig& rig, const std::string& name);

}  // namespace footlight::tools

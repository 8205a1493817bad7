// The options of `footlight preview`. The window is in preview_window.cpp; a build without GLFW or Dear ImGui has
// no_preview_window.cpp instead.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/quality.h"
#include "render/rivals/picture_style.h"
#include "sim/core/clock.h"
#include "tools/footlight/pictures/flash_mode.h"
#include "tools/footlight/pictures/frame_options.h"
#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/preview/window_settings.h"

namespace footlight::tools {

struct PreviewOptions {
  SceneFiles files;
  std::vector<std::string> ins;      // endpoints; if there are any but controls, no log drives the rig
  std::vector<std::string> outputs;  // endpoints to real lamps; each sends nothing until the user arms it
  bool outputs_stay = false;         // they are those of the window before: one that does not fit the rig is left out
  bool hold_to_live = false;         // outputs are live only while a key is held
  std::string socket = "auto";       // for commands by hand: a file, auto or none
  std::string compare;               // log whose levels are compared with those of the window; empty: none
  std::string compare_stage = "off";  // or "beside", "difference": A and B of the comparison on the stage
  std::string record;                // log of what the fixtures get, from the start; empty: none
  std::string recordings;            // folder of recordings that begin in the window; empty: that of the rig
  std::string size = "1280x720";
  std::string camera;
  std::string panels;                // words of open panels, separated by commas
  std::vector<std::string> library;  // folders that the panel of the library lists, too
  std::string select;                // name of the fixtures that are selected, with * for any text
  std::string theme;                 // "dark" or "light"; empty: as the window's settings have it
  std::string language;              // "de"; empty: as the environment has it, "en": English
  std::optional<int> ui_percent;     // size of the user interface; default: as the settings have it
  std::optional<int> views;          // of the stage: 1, 2 or 4; default: as the settings have it
  bool locked = false;               // nothing in the window edits the rig or sets levels
  bool handles = false;              // handles of the selected fixtures are shown at the start
  std::string device;
  std::string screenshot;               // PNG of the last frame; empty: none
  DurationNs at_ns = 0;                 // start time in the log
  double seconds = 0;                   // closes after this time; 0: stays open
  std::optional<double> work_light_lx;  // default: work_light_lx() if faders drive the rig, else 0
  render::QualityRequest quality;       // if one is asked for, the three that follow do not matter
  int nodes = 3;
  double tile_error = 4e-3;                   // render::FrameSettings
  double body_error_px = 0.5;                 // the same
  std::optional<std::uint32_t> edge_samples;  // default: render::suited_edge_samples()
  bool bounce = true;
  bool probes = true;
  render::PictureStyle style = render::PictureStyle::kPhysical;
  render::FrameSettings display;  // of which glare, white balance, tone curve, automatic exposure, and shadows
  CameraWords camera_words;  // of which depth of field, that of the first camera where they name none
  FlashMode flashes = FlashMode::kWarn;
  bool recover = false;  // opens the newest edits of the rig that a session lost
  bool json = false;
  DurationNs json_period_ns = kNsPerS;
  std::string news;  // a message of the window at its start; empty: none
};

// The looks that options set for the session, as the user has left them in a window: for the next window of it. What no
// option sets is read from the settings.
void keep_look(PreviewOptions& options, const WindowSettings& settings);

// Opens the window and returns an ExitCode when it is closed.
[[nodiscard]] Result<int> run_preview(const PreviewOptions& options);

}  // namespace footlight::tools

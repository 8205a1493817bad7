// The panel beside the picture: what is shown, its cost and error, and the controls. ImGui only.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/frame.h"
#include "render/live_error.h"
#include "render/quality.h"
#include "tools/footlight/pictures/flash_mode.h"
#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/preview/live_levels.h"
#include "tools/footlight/preview/ui/transport.h"

namespace footlight::tools {

// The data that the panel shows.
struct PreviewFacts {
  std::string rig;
  std::string device;
  std::vector<std::string> cameras;
  bool can_edit = false;  // cameras can be stored
  bool locked = false;    // faders and the haze of the rig cannot be moved
  std::vector<std::string> fixtures;
  bool can_haze = false;       // the rig has haze to turn off
  bool can_probes = false;     // and reflection probes
  std::size_t machines = 0;    // haze, fog and fan machines; if there are any, the current haze, 1/m:
  double room_haze_per_m = 0;  // of [haze]
  double machine_haze_per_m = 0;
  double machine_fog_per_m = 0;

  int width = 0;  // of the computed picture
  int height = 0;
  double fps = 0;
  double frame_p50_ms = 0;  // from picture to picture
  double frame_p90_ms = 0;
  double edit_to_frame_ms = -1;  // from the last edit of the rig to the frame made for it; -1: there was none
  double ui_ms = 0;  // CPU time of all panels; the median
  std::vector<render::PassTime> passes;
  std::uint32_t live_beams = 0;
  std::uint32_t dark_beams = 0;
  std::uint32_t shadows = 0;
  std::uint32_t shadows_lost = 0;  // of them, for want of room
  double gpu_mib = 0;
  render::ErrorWindow::Estimate error;      // of the pictures of the last second
  render::QualityRequest quality;           // that knobs are chosen for; nothing: the user chooses
  std::optional<render::KnobPoint> chosen;  // for it
  bool measures_knobs = false;              // of this machine, for quality
  FlashMode flashes = FlashMode::kWarn;
  bool flashes_harmful = false;             // now
  bool flashes_held = false;                // the last harmless picture is held

  bool has_log = false;
  TimeNs now_ns = 0;   // on the clock of the live stamps
  PumpStatus status;   // live
  std::string notice;  // the newest event of the inputs
};

// What the user asks for about a camera of the rig.
struct CameraRequest {
  enum class What { kStore, kRename, kDelete };
  What what = What::kStore;
  std::size_t index = 0;
  std::string name;  // of kRename
};

enum class PanelState { kFull, kStrip, kHidden };

// The values that the user can change. The caller executes requests and resets them.
struct PreviewControls {
  PanelState panel = PanelState::kFull;
  float exposure_ev = 4;       // those of UiState::exposure, and what the user makes of them
  bool auto_exposure = false;  // exposure_ev does not matter then
  render::ToneCurve tone = render::ToneCurve::kAgx;
  bool balances_white = false;
  float white_k = 5600;  // where it does
  float glare_percent = 1;
  bool work_light = false;
  float work_light_lx = 0;  // while it is on
  int nodes = 3;
  int divisor = 1;  // the picture is computed with 1/divisor of the window's pixels a side
  bool haze = true;
  bool probes = true;
  Transport transport;  // of a log
  int hand_fixture = -1;  // -1: all

  std::optional<float> drag_s;  // the position of the log's slider while it is dragged
  std::optional<int> camera;
  std::optional<CameraRequest> camera_request;
  std::optional<double> haze_per_m;               // scattering of the room's haze
  std::optional<FlashMode> flashes;               // what harmful flashes do
  std::optional<render::QualityRequest> quality;  // nothing in it: nodes and pixels by hand
  float error_percent = 0.1f;                     // what the slider has that asks for an error
  float picture_ms = 16;                          // and for a time
  std::string camera_name;                        // in the field of the camera whose menu is open
};

inline constexpr float kPanelWidth = 264;  // units of ImGui at scale 1

// live, hand: nullptr if the rig is not driven by them. menu: draws the entries of the bar at its top.
void draw_panel(const PreviewFacts& facts, PreviewControls& controls, const LiveLevels* live, HandLevels* hand,
                float scale, const std::function<void()>& menu);

// A line of text in the middle of the window before the first picture. Call between the begin and end of a UI.
void draw_progress(const std::string& text);

}  // namespace footlight::tools

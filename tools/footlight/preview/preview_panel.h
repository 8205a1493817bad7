// The panel beside the picture: what is shown, what it costs, how wrong it is, and the controls. ImGui only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/frame.h"
#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/preview/live_levels.h"

namespace footlight::tools {

// What the panel tells.
struct PreviewFacts {
  std::string rig;
  std::string device;
  std::vector<std::string> cameras;
  std::vector<std::string> fixtures;
  bool can_haze = false;       // the rig has haze to turn off
  bool gobos = false;          // the rig has gobos
  std::size_t machines = 0;    // that haze, fog or blow; then what is in the air now, 1/m:
  double room_haze_per_m = 0;  // the room's own
  double machine_haze_per_m = 0;
  double machine_fog_per_m = 0;

  int width = 0;  // of the computed picture
  int height = 0;
  double fps = 0;
  double frame_p50_ms = 0;  // from picture to picture
  double frame_p90_ms = 0;
  std::vector<render::PassTime> passes;
  std::uint32_t live_beams = 0;
  std::uint32_t dark_beams = 0;
  double gpu_mib = 0;
  bool flashes_harmful = false;  // now
  bool flashes_held = false;     // the last harmless picture stands

  bool has_log = false;
  double time_s = 0;
  double duration_s = 0;
  TimeNs now_ns = 0;   // on the clock of the live stamps
  PumpStatus status;   // live
  std::string notice;  // the newest event of the wire
};

enum class PanelState { kFull, kStrip, kHidden };

// What it lets people change. Requests are taken by the caller and reset.
struct PreviewControls {
  PanelState panel = PanelState::kFull;
  float exposure_ev = 4;
  bool work_light = false;
  float work_light_lx = 0;  // while it is on
  int nodes = 3;
  int divisor = 1;  // the picture is computed with 1/divisor of the window's pixels a side
  bool haze = true;
  bool playing = true;
  bool loop = false;
  int hand_fixture = -1;  // -1: all

  std::optional<double> seek_s;
  std::optional<float> drag_s;  // where the slider of the log is held
  std::optional<int> camera;
};

inline constexpr float kPanelWidth = 264;  // units of ImGui at scale 1

// The relative L2 error of pictures with 1 to 8 Gauss nodes as measured once; see the definition for scene and command.
[[nodiscard]] double measured_rel_l2(int nodes);

// live, hand: nullptr where the rig is not driven that way.
void draw_panel(const PreviewFacts& facts, PreviewControls& controls, const LiveLevels* live, HandLevels* hand,
                float scale);

// A line of text in the middle of the window, while there is no picture yet. Between the calls that begin and end a UI.
void draw_progress(const std::string& text);

}  // namespace footlight::tools

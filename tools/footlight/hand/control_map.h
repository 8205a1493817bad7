// Controls: faders, knobs and buttons of MIDI devices and OSC programs, and what they do to the hand (docs/control.md).
//
// Whatever its kind, a control has a share from 0 to 1. Its target turns the share into a command of the hand.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fixtures/files/source_at.h"
#include "sim/core/result.h"
#include "sim/hand.h"
#include "tools/footlight/hand/hand_targets.h"

namespace footlight::tools {

// One [[control]] of a map, as in the file.
struct ControlPlan {
  std::string input;       // "cc 1 7", "note 1 60", "/1/fader1"
  std::string to;          // "1.17", "Mover 3:Tilt", "scene Warm", "blackout", "release", "tempo"
  std::string low = "0%";  // of slots and attributes: at the share 0
  std::string high = "100%";
  DurationNs over_ns = 0;
  bool toggle = false;  // each press changes between low and high, or on and off
  fixtures::SourceAt at;
};

struct ControlMap {
  std::string device;  // MIDI: a part of the device's name, or "mock"
  int port = 0;        // OSC: UDP port; 0: none
  std::string rig;
  std::string scenes;
  int priority = kHandPriorityDefault;
  std::vector<ControlPlan> controls;
  std::string name;  // of the file, for messages
};

// Errors: kBadInput, with the position. Also those of reading the file.
[[nodiscard]] Result<ControlMap> parse_control_map(std::string_view text, const std::string& name);
// Paths in the file are relative to it; in the result they are not.
[[nodiscard]] Result<ControlMap> load_control_map(const std::string& path);

// What a control does.
class Control {
 public:
  // Errors: those of add_assignment(); the message names the map and the position.
  [[nodiscard]] static Result<Control> make(const ControlPlan& plan, const ControlMap& map, const RigOf& rig);

  // Does something when it is pressed, at a share of one half; else its share is a level.
  [[nodiscard]] bool is_button() const { return toggle_ || kind_ != Kind::kLevels; }
  // A new share. `now_ns`: of the pump. Does not allocate once it was called.
  Status move(double share, TimeNs now_ns, HandTaker& taker);
  // A press of a button that does not tell its end. A blackout that it begins stays.
  Status tap(TimeNs now_ns, HandTaker& taker);

 private:
  Status black_out(bool press, bool end, TimeNs now_ns, HandTaker& taker);

  enum class Kind { kLevels, kScene, kBlackout, kRelease, kTempo };
  Kind kind_ = Kind::kLevels;
  bool toggle_ = false;
  bool on_ = false;       // of a toggle of levels
  bool pressed_ = false;  // the last share was half or more
  bool began_ = false;    // this press began the blackout that is on
  HandCommand command_;
  std::vector<std::uint32_t> low_, high_;  // of command_.levels
  SceneCall scene_;
};

// The first lines of a new map at `path`: for a device, or for a UDP port; `rig`: with the names of fixtures, or "".
[[nodiscard]] std::string map_head(const std::string& path, const std::string& device, int udp_port,
                                   const std::string& rig);
// The text of a control for a map file, and the file with it appended. `path` may not exist yet.
[[nodiscard]] std::string control_text(const std::string& input, const std::string& to);
[[nodiscard]] Status append_control(const std::string& path, const std::string& head, const std::string& input,
                                    const std::string& to);

}  // namespace footlight::tools

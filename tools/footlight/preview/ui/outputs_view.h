// The outputs of the window to real lamps as panels show them, and what the user asks for. Plain data: the loop of the
// preview fills it in and carries it out (live_outputs.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/pump.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

enum class ArmState : std::uint8_t {
  kOff,      // not open: nothing is sent
  kOpening,  // asked for; nothing is sent yet
  kArmed,    // sends the levels of the picture
  kClosing,  // sends zeros and closes
};

// The key of the dead man's switch, for people: keys.h has its number.
inline constexpr const char* kHoldKeyName = tr_mark("End");

// Why armed outputs send zeros.
enum class Darkness : std::uint8_t {
  kNone,     // they send the levels of the picture
  kAsked,    // the user asked for a blackout
  kSilence,  // the window gave no levels for OutputFeed::kSilenceMaxNs
  kNotHeld,  // lamps are live only while a key is held, and it is not
};

// Until the user ends it.
[[nodiscard]] constexpr bool is_blackout(Darkness darkness) {
  return darkness == Darkness::kAsked || darkness == Darkness::kSilence;
}

// Of an output for as long as it is in the list, and of no other one of the window.
using OutputId = int;

struct OutputRow {
  OutputId id = 0;
  std::string endpoint;
  std::vector<Universe> universes;  // that it carries
  std::vector<Universe> left_out;   // of them, those that are not sent: no address of the rig is in them
  bool can_move = false;            // to another universe: a device with one, not armed
  bool made_up = false;             // a model inside the program: no lamp gets what it sends
  bool leaves = false;              // it was removed, and leaves the list once it is dark and closed
  ArmState state = ArmState::kOff;
  std::string trouble;               // why it could not be armed; empty: it could, or was not asked for
  std::optional<PortStatus> status;  // while it is armed; at most two seconds old

  // Those that it sends.
  [[nodiscard]] std::vector<Universe> sent() const;
};

// A DMX interface that is plugged in.
struct PluggedDevice {
  std::string endpoint;  // "enttec-pro:EN172589"; empty: not known to be one
  std::string model;
  std::string state;      // "ready", "no-permission" ...
  std::string fix;        // why it cannot be used, and the command that helps; empty if it is ready
  bool can_send = false;  // it is ready and has an output
};

struct OutputsView {
  // What is.
  std::vector<OutputRow> rows;
  Darkness darkness = Darkness::kNone;
  std::string notice;                  // the newest event
  std::vector<Universe> universes;     // in which the rig has an address of its own, ascending
  std::vector<PluggedDevice> devices;  // while somebody looks for them; at most two seconds old
  std::string refusal;                 // why the last output that was to be added was not; empty: it was

  // What the user asks for; the loop carries it out and resets it. An id whose row is gone by then is ignored.
  std::vector<OutputId> arm;
  std::vector<OutputId> disarm;
  std::vector<OutputId> remove;    // from the list, once it is dark and closed
  std::optional<bool> blackout;    // false: ends
  bool needs_hold = false;         // lamps are live only while kHoldKeyName is held; stays as it is set
  std::optional<std::string> add;  // an endpoint; it is not armed
  struct Move {
    OutputId id = 0;  // of a row that can_move
    Universe to = 0;
  };
  std::optional<Move> move;
  bool looks = false;              // for devices; asked for with each picture

  // How many of them send.
  [[nodiscard]] std::size_t live_count() const;
  // Some output is armed, or will be.
  [[nodiscard]] bool any_on() const;
  void disarm_all();
  // What a locked window refuses: outputs that come, go or get another universe. True if there was something.
  bool drop_requests();
  // nullptr: it has left the list.
  [[nodiscard]] const OutputRow* find(OutputId id) const;
  // The endpoints of those that stay in the list, as they are now, for a window that follows.
  [[nodiscard]] std::vector<std::string> staying() const;
};

// "LIVE: 2 outputs", "LIVE: 1 output (made up)" where no lamp gets anything, "BLACKOUT of outputs: 2 send
// zeros"; empty if there is nothing to say: no output is armed, and there is no blackout.
[[nodiscard]] std::string live_words(const OutputsView& view);
// How a blackout ends, and why it began if the user did not ask for it; empty without one.
[[nodiscard]] std::string blackout_words(const OutputsView& view);

}  // namespace footlight::tools

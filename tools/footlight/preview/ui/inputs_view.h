// The inputs of the window as the panel of devices shows them, and what the user asks for. Plain data: the loop of the
// preview fills it in and carries it out (preview_inputs.cpp).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/core/dmx.h"

namespace footlight::tools {

struct InputsView {
  // What is.
  std::vector<std::string> inputs;   // endpoints
  std::vector<std::string> made_up;  // of them, those that are models of devices, and patterns
  std::vector<std::string> movable;  // of them, devices with one connector: to another universe
  std::string why_not;               // why none but controls can be added now; empty: it can
  std::string by_hand;               // "12 slots are set by hand"; empty: none is
  bool dark_by_hand = false;         // a blackout of 'footlight blackout' or a control is on
  std::string refusal;               // why the last one that was to be added was not; empty: it was

  double beats_a_minute = 120;  // of patterns among the made-up inputs
  bool has_patterns = false;    // there is a made-up input with a tempo
  bool has_controls = false;    // there is an input of OSC or MIDI
  bool learns = false;          // the next control that moves is added to its map

  // What the user asks for; the loop carries it out and resets it.
  std::optional<std::string> add;  // "mock:chase", "sacn:1-9"
  std::optional<std::string> remove;
  struct Move {
    std::string input;  // of `movable`
    Universe to = 0;
  };
  std::optional<Move> move;
  bool release_hand = false;  // all slots that are set by hand
  bool end_hand_blackout = false;
  bool tap = false;                  // of the tempo
  std::optional<std::string> learn;  // what the next control that moves is for, as "1.17"
  bool stop_learning = false;

  // What a locked window refuses: all but the end of a blackout. True if there was something.
  bool drop_requests();
};

// "MADE UP: mock:chase", "MADE UP: 2 inputs"; empty: there is none.
[[nodiscard]] std::string made_up_words(const InputsView& view);
// "BLACKOUT by hand", and how it ends, which is not how that of outputs does; empty: there is none.
[[nodiscard]] std::string hand_blackout_words(const InputsView& view);
[[nodiscard]] std::string hand_blackout_end();

}  // namespace footlight::tools

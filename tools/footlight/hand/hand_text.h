// Commands of the hand (sim/hand.h) as text: the assignments of the command line and of scene files, and the messages
// on the socket of a bridge.
//
//   1.17=255          address 17 of universe 1
//   1.1-12=50%        twelve addresses
//   1.1=255,128,0     addresses 1, 2 and 3
//   1.*=0             a whole universe
//   1.17+18=30000     a number of 16 bits in addresses 17 and 18, the more significant byte first; up to four
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/core/result.h"
#include "sim/hand.h"

namespace footlight::tools {

// True for what the functions below read: it begins with a digit and has no colon. Others name fixtures.
[[nodiscard]] bool names_slots(std::string_view text);

// A name as a part of an OSC address: "Mover 3" is "Mover_3".
[[nodiscard]] std::string osc_name(std::string_view name);

// A number, or a percentage. Neither is checked against a range, except that a percentage is from 0 to 100.
struct HandNumber {
  double number = 0;
  bool percent = false;
};
[[nodiscard]] Result<HandNumber> parse_hand_number(std::string_view text);

// Errors: kBadInput; the message begins with the text and has an example. The levels are added to `into`.
[[nodiscard]] Status parse_slots(std::string_view text, std::vector<HandLevel>& into);            // "1.1-12"
[[nodiscard]] Status parse_slot_assignment(std::string_view text, std::vector<HandLevel>& into);  // "1.1-12=0"
// The same text, with runs of equal levels and of neighbours as one assignment each.
[[nodiscard]] std::vector<std::string> assignments_of(const std::vector<HandLevel>& levels);
// "1 slot of universe 1", "12 slots of 3 universes": each slot once.
[[nodiscard]] std::string counted_slots(const std::vector<HandLevel>& levels);

// A message has a line with the version, a line with the action, and lines with its parts:
//
//   footlight-hand 1
//   set
//   priority 150
//   over 3000000000
//   1.1-12=0
//   jump 1.20=40
//
// Actions: set, release, release-all, blackout, blackout-off, hold, renew, tempo. "tempo" is a tap, or has a line
// "beats 128.5": that many a minute.
inline constexpr int kHandVersion = 1;
inline constexpr std::size_t kHandMessageBytesMax = 256u << 10;
inline constexpr std::size_t kHandLevelsMax = 1u << 18;  // of one message: all slots of 512 universes
[[nodiscard]] std::string hand_message(const HandCommand& command);
// The same command in parts that are each short enough for a message. For actions that add up, such as a blackout.
[[nodiscard]] std::vector<HandCommand> hand_parts(HandCommand command);
// Errors: kBadInput, with the line; kUnsupported: another version.
[[nodiscard]] Result<HandCommand> parse_hand_message(std::string_view text);

}  // namespace footlight::tools

// DMX512-A (ANSI E1.11): types and constants.
//
// A universe has 512 slots (bytes). Universes and addresses count from 1; slots in code count from 0. Only
// slot_of_address() converts an address to a slot.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "sim/core/clock.h"

namespace footlight {

inline constexpr int kSlotCountMax = 512;
inline constexpr int kUniverseCountDefault = 9;
inline constexpr int kUniverseMin = 1;
inline constexpr int kUniverseMax = 63'999;            // E1.31-2018 section 6.2.7
inline constexpr std::uint8_t kPriorityDefault = 100;  // E1.31-2018 section 6.2.3
inline constexpr std::uint8_t kPriorityMax = 200;

// The meaning of a frame's slots (E1.11 section 8.5). Ports drop frames with any other start code.
inline constexpr std::uint8_t kStartCodeLevels = 0x00;
inline constexpr std::uint8_t kStartCodePriorities = 0xDD;  // per-address priority, an ETC extension of sACN

using Universe = int;  // counted from 1: 1 to kUniverseMax
using Address = int;   // counted from 1: 1 to 512
using Slots = std::array<std::uint8_t, kSlotCountMax>;

[[nodiscard]] constexpr bool is_universe(long long number) { return number >= kUniverseMin && number <= kUniverseMax; }
[[nodiscard]] constexpr bool is_address(long long number) { return number >= 1 && number <= kSlotCountMax; }
[[nodiscard]] constexpr int slot_of_address(Address address) { return address - 1; }

// The sender of a frame. Assigned by the source that received it; equal ids mean the same sender. 0: no sender.
using SenderId = std::uint64_t;

// One frame. Does not own its slots: valid during the call that receives it as an argument.
struct FrameView {
  Universe universe = 0;
  TimeNs stamp_ns = 0;  // when it was received, on the pump's clock
  SenderId sender = 0;
  std::uint32_t sequence = 0;                  // set by the sender, as received; 0 if the protocol has none
  std::uint8_t priority = kPriorityDefault;    // 0 to 200
  bool terminated = false;                     // the sender stops sending this universe; slots are ignored
  std::uint8_t start_code = kStartCodeLevels;  // the meaning of the slots
  // How long the sender may be silent before it is removed; 0: as MergeOptions sets. For protocols whose senders repeat
  // less often than E1.31's (Art-Net: 4 s between repeats, removed after 10 s).
  DurationNs silence_max_ns = 0;
  // 0 to 512 levels, slot 0 = address 1; slots past the end are unchanged. With kStartCodePriorities: a priority for
  // each address; 0 = the sender does not claim the address; addresses past the end have 0.
  std::span<const std::uint8_t> slots;
};

// Stored in the buffer with the 512 levels.
struct FrameStamp {
  TimeNs stamp_ns = 0;         // of the newest frame written; 0: no frame yet
  SenderId sender = 0;         // of that frame
  std::uint32_t sequence = 0;  // of that frame
  std::uint32_t revision = 0;  // counts writes to this universe; 0: never written
};

}  // namespace footlight

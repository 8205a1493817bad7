// The words of DMX512-A (ANSI E1.11) as this program uses them.
//
// A universe has 512 slots (bytes). People count universes and addresses from 1; code counts slots from 0. The one
// place that turns an address into a slot is slot_of_address().
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

// What the slots of a frame mean (E1.11 section 8.5). All others are dropped by the port that meets them.
inline constexpr std::uint8_t kStartCodeLevels = 0x00;
inline constexpr std::uint8_t kStartCodePriorities = 0xDD;  // per-address priority, an ETC extension of sACN

using Universe = int;  // as people count: 1 to kUniverseMax
using Address = int;   // as people count: 1 to 512
using Slots = std::array<std::uint8_t, kSlotCountMax>;

[[nodiscard]] constexpr bool is_universe(long long number) { return number >= kUniverseMin && number <= kUniverseMax; }
[[nodiscard]] constexpr bool is_address(long long number) { return number >= 1 && number <= kSlotCountMax; }
[[nodiscard]] constexpr int slot_of_address(Address address) { return address - 1; }

// Who sent a frame. Given out by the source that received it; equal ids mean the same sender. 0 is nobody.
using SenderId = std::uint64_t;

// One frame as it travels. Does not own its slots: valid during the call that hands it over.
struct FrameView {
  Universe universe = 0;
  TimeNs stamp_ns = 0;  // when it was received, on the clock of the pump
  SenderId sender = 0;
  std::uint32_t sequence = 0;                  // of the sender, as it came over the wire; 0 where the wire has none
  std::uint8_t priority = kPriorityDefault;    // 0 to 200
  bool terminated = false;                     // the sender says that it stops sending this universe; slots are ignored
  std::uint8_t start_code = kStartCodeLevels;  // what the slots mean
  // How long the sender may be silent before it is forgotten; 0: as the merge is told. For protocols whose senders
  // repeat themselves less often than E1.31's (Art-Net: 4 s between repeats, 10 s to be forgotten).
  DurationNs silence_max_ns = 0;
  // 0 to 512 levels, slot 0 = address 1; slots past the end are unchanged. With kStartCodePriorities: a priority for
  // each address, 0 = not sent by this sender; addresses past the end have 0.
  std::span<const std::uint8_t> slots;
};

// What the buffer keeps beside the 512 levels.
struct FrameStamp {
  TimeNs stamp_ns = 0;         // of the newest frame that went in; 0: nothing ever came
  SenderId sender = 0;         // of that frame
  std::uint32_t sequence = 0;  // of that frame
  std::uint32_t revision = 0;  // counts writes to this universe; 0: never written
};

}  // namespace footlight

// Anyma uDMX and its clones: the time of a snapshot on the wire, and the selection of slots to send.
//
// The device is low speed: a packet carries 8 bytes and takes a millisecond of the bus, so a whole universe takes 66
// ms. It stores all slots and repeats them itself. So only changed slots are sent, one transfer per range of slots:
// bRequest 2, wValue = slots, wIndex = first slot, data = levels.
// Sources: the firmware, uDMX.c and uDMX_cmds.h (anyma.ch/research/udmx); illutzmination.de/udmx-timing.html: 15 frames
// a second of 512 slots and 30 of 256, which matches the packet times of udmx_transfer_ns().
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"

namespace footlight::drivers {

struct UdmxRange {
  int first = 0;  // slot
  int count = 0;
  friend bool operator==(const UdmxRange&, const UdmxRange&) = default;
};

// The bus time of a transfer of slot_count slots.
[[nodiscard]] DurationNs udmx_transfer_ns(int slot_count);
// The first range to send, at or after slot `from`, to change `known` into `wanted`; nullopt: they are equal from there
// on. Equal slots between two changes are included if that is cheaper than another transfer.
[[nodiscard]] std::optional<UdmxRange> next_udmx_range(std::span<const std::uint8_t, kSlotCountMax> known,
                                                       std::span<const std::uint8_t, kSlotCountMax> wanted, int from);

}  // namespace footlight::drivers

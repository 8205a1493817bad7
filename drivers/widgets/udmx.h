// Anyma uDMX and its clones: what a look costs on the wire, and which slots to send.
//
// The device is a low-speed one: a packet carries 8 bytes and each takes a millisecond of the bus, so a whole universe
// takes 66 ms. It keeps all slots and repeats them by itself; so only what has changed is sent, in one transfer for
// each range of slots: bRequest 2, wValue = slots, wIndex = first slot, data = levels.
// Sources: the firmware, uDMX.c and uDMX_cmds.h (anyma.ch/research/udmx); illutzmination.de/udmx-timing.html: 15 looks
// a second of 512 slots and 30 of 256, which is what the packets of udmx_transfer_ns() add up to.
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

// How long the bus is busy with a transfer of so many slots.
[[nodiscard]] DurationNs udmx_transfer_ns(int slot_count);
// The first range to send, at or after slot `from`, in order to turn `known` into `wanted`; nullopt: they are the same
// from there on. Equal slots between two changes are sent along where that is cheaper than another transfer.
[[nodiscard]] std::optional<UdmxRange> next_udmx_range(std::span<const std::uint8_t, kSlotCountMax> known,
                                                       std::span<const std::uint8_t, kSlotCountMax> wanted, int from);

}  // namespace footlight::drivers

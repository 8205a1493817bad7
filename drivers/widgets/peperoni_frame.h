// The messages of Peperoni's (earlier: Lighting Solutions') Rodin, X-Switch and USBDMX21: bytes only.
//
// The format depends on the firmware, which is the release number of the USB device descriptor (bcdDevice):
//
//   below 4.00  control transfer: request 0x08 (transmitter memory), wValue 0 (do not wait), wIndex 0 (first slot)
//   below 5.00  bulk: 01 request 00 02, then 512 levels; request 0: first universe, 4: second
//   from 5.00   bulk: 02 4D 6B 32, 00 (set), universe, 07 02 (size of what follows below), transmitter settings, time
//               limit in ms (low byte first), break, mark after break; then 02 4D 6B 32, 01 02 (bytes of the frame),
//               00 (the start code is put in front), 512 levels. The device answers with 8 bytes: 02 4D 6B 32, a time
//               in ms (low byte first), PeperoniStatus, 0.
//
// Sources: peperonidefs.h and peperonidevice.cpp of QLC+; usbdmx.h of the maker's Linux driver (requests).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sim/core/dmx.h"

namespace footlight::drivers {

enum class PeperoniFrames : std::uint8_t { kControl, kBulk, kBulkWithStatus };
// release: bcdDevice, 0x0500 is 5.00.
[[nodiscard]] PeperoniFrames peperoni_frames(std::uint16_t release);

inline constexpr std::size_t kPeperoniBulkSize = 4 + kSlotCountMax;
inline constexpr std::size_t kPeperoniStatusFrameSize = 13 + 7 + kSlotCountMax;
inline constexpr std::size_t kPeperoniStatusSize = 8;
// How long a device with answers waits until its transmitter is free; this paces the snapshots.
inline constexpr std::uint8_t kPeperoniWaitMs = 50;

// universe: 0 or 1.
[[nodiscard]] std::array<std::uint8_t, kPeperoniBulkSize> encode_peperoni_bulk(
    int universe, std::span<const std::uint8_t, kSlotCountMax> snapshot);
[[nodiscard]] std::array<std::uint8_t, kPeperoniStatusFrameSize> encode_peperoni_with_status(
    int universe, std::span<const std::uint8_t, kSlotCountMax> snapshot);

enum class PeperoniStatus : std::uint8_t { kOk = 0, kTimeout = 1, kStartFailed = 2, kWrongUniverse = 3 };
// The status byte of an answer, possibly one that PeperoniStatus does not list; nullopt if it is not an answer.
[[nodiscard]] std::optional<PeperoniStatus> decode_peperoni_status(std::span<const std::uint8_t> answer);

}  // namespace footlight::drivers

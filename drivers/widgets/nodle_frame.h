// The reports of the Nodle family: bytes only, no I/O, no time.
//
// Nodle U1 and R4S, Digital Enlightenment USB-DMX and FX5 use the same reports of 33 bytes, in both directions:
//
//   block levels[32]     block 0 to 15: the levels of slots 32 x block and on; to the host: levels of its input
//   16 mode zeros...     to the device only: its mode, bits of NodleMode
//
// Sources: hiddmxdevice.cpp of QLC+ (whose authors made the Nodle) and DMXCProjectsNodleU1.cpp of OLA; the meaning of
// the modes: plugins/usbdmx/README.md of OLA.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sim/core/dmx.h"

namespace footlight::drivers {

inline constexpr int kNodleBlockSize = 32;
inline constexpr int kNodleBlockCount = kSlotCountMax / kNodleBlockSize;
inline constexpr std::size_t kNodleReportSize = 1 + kNodleBlockSize;  // without the HID report number
using NodleReport = std::array<std::uint8_t, 1 + kNodleReportSize>;   // with it: a leading 0

enum NodleMode : std::uint8_t {  // or-ed together; none: standby
  kNodleThrough = 1,             // DMX in to DMX out
  kNodleOutput = 2,              // host to DMX out
  kNodleInput = 4,               // DMX in to host
};

[[nodiscard]] NodleReport encode_nodle_mode(std::uint8_t mode);
// block: 0 to 15.
[[nodiscard]] NodleReport encode_nodle_block(int block, std::span<const std::uint8_t, kSlotCountMax> snapshot);
// Writes the levels of an input report to their slots and returns the number of the block; nullopt if it is not one,
// with `slots` unchanged. report: with its HID report number.
std::optional<int> apply_nodle_report(std::span<const std::uint8_t> report,
                                      std::span<std::uint8_t, kSlotCountMax> slots);

}  // namespace footlight::drivers

// The messages of a Vince USB-DMX512 converter: bytes only, no I/O.
//
// To it:   0F 0F command length_high length_low data[length] 04; the data of an update start with two zeros.
// From it: 0F 0F command status length_high length_low data[length] 04, status 0 on success.
// Source: the traffic of other programs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sim/core/dmx.h"

namespace footlight::drivers {

enum class VinceCommand : std::uint8_t { kStart = 0x01, kStop = 0x02, kUpdate = 0x11 };

inline constexpr std::size_t kVinceUpdateSize = 2 + 1 + 2 + 2 + kSlotCountMax + 1;
inline constexpr std::array<std::uint8_t, 6> kVinceStart{0x0F, 0x0F, 0x01, 0, 0, 0x04};
[[nodiscard]] std::array<std::uint8_t, kVinceUpdateSize> encode_vince_update(
    std::span<const std::uint8_t, kSlotCountMax> snapshot);

struct VinceReply {
  std::uint8_t command = 0;
  std::uint8_t status = 0;  // 0: success
};

// Finds replies in a stream that may begin anywhere, be cut anywhere and contain noise. Only the first byte of a wrong
// candidate is discarded.
class VinceReplyParser {
 public:
  // Consumes bytes from the front of `stream` until a reply is complete.
  [[nodiscard]] bool next(std::span<const std::uint8_t>& stream, VinceReply& reply);
  void reset() { size_ = 0; }
  [[nodiscard]] std::uint64_t garbage_byte_count() const { return garbage_byte_count_; }

 private:
  static constexpr std::size_t kHeadSize = 6;
  static constexpr std::size_t kDataSizeMax = 64;  // answers to updates have no data
  // Whether the bytes at held_'s front need more, are a reply, or are not one.
  enum class Verdict { kNeedsMore, kReply, kFalseStart };
  [[nodiscard]] Verdict judge() const;

  std::array<std::uint8_t, kHeadSize + kDataSizeMax + 1> held_{};
  std::size_t size_ = 0;
  std::uint64_t garbage_byte_count_ = 0;
};

}  // namespace footlight::drivers

// Assembles DMX frames from bytes and breaks of a serial line. No I/O, no time of its own, no allocation.
//
// A frame starts at a break (E1.11 section 8.3). It is returned when it is full, and when it is as long as the last
// one, so that short frames need not wait for the next break. If its length differs, it is returned at the next break.
// A frame with a damaged or missing byte is counted and dropped, since its slots may be at wrong addresses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/transport/transport.h"
#include "sim/core/dmx.h"

namespace footlight::drivers {

class LineFrameParser {
 public:
  struct Counters {
    std::uint64_t frames = 0;          // returned; a frame that grew after that counts once
    std::uint64_t short_frames = 0;    // of those, with fewer than 512 slots
    std::uint64_t framing_errors = 0;  // frames dropped because of a damaged byte
    std::uint64_t overruns = 0;        // frames dropped because of missing bytes
    std::uint64_t stray_bytes = 0;     // outside of a frame
  };
  struct Frame {
    std::span<const std::uint8_t> bytes;  // start code first; valid until the next take()
    TimeNs stamp_ns = 0;                  // of its last byte
  };

  // Returns the frame that this byte completes, if any.
  [[nodiscard]] std::optional<Frame> take(const LineByte& byte);
  // Drops an incomplete frame.
  void reset();
  [[nodiscard]] const Counters& counters() const { return counters_; }

 private:
  std::optional<Frame> give();

  std::array<std::uint8_t, 1 + kSlotCountMax> frame_{};
  std::size_t size_ = 0;
  std::size_t given_size_ = 0;     // of this frame, when it was last returned; 0: not yet
  std::size_t expected_size_ = 0;  // of the last frame
  TimeNs stamp_ns_ = 0;
  bool in_frame_ = false;
  Counters counters_;
};

}  // namespace footlight::drivers

// Decodes the bytes and breaks of a serial line from a tty in PARMRK mode. No I/O.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/transport/transport.h"

namespace footlight::drivers {

// FF 00 00 is a break, FF 00 x a byte x with a framing error, FF FF a byte FF (termios(3)). A mark may be split between
// two calls.
class TtyMarkParser {
 public:
  // Appends to `into`.
  void take(std::span<const std::uint8_t> bytes, TimeNs stamp_ns, std::vector<LineByte>& into);
  void reset() { state_ = State::kPlain; }

 private:
  enum class State { kPlain, kMark, kError };
  State state_ = State::kPlain;
};

}  // namespace footlight::drivers

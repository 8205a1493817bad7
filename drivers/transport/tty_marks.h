// Bytes and breaks of a serial line, as a tty with PARMRK writes them. No I/O.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/transport/transport.h"

namespace footlight::drivers {

// What a tty in PARMRK mode says of a line: FF 00 00 is a break, FF 00 x a byte with a framing error, FF FF a byte FF
// (termios(3)). Bytes may be cut anywhere.
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

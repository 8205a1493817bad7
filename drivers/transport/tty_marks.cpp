#include "drivers/transport/tty_marks.h"

namespace footlight::drivers {

void TtyMarkParser::take(std::span<const std::uint8_t> bytes, TimeNs stamp_ns, std::vector<LineByte>& into) {
  constexpr std::uint8_t kMark = 0xFF;
  for (const std::uint8_t byte : bytes) {
    switch (state_) {
      case State::kPlain:
        if (byte == kMark)
          state_ = State::kMark;
        else
          into.push_back({.value = byte, .stamp_ns = stamp_ns});
        break;
      case State::kMark:
        state_ = byte == 0 ? State::kError : State::kPlain;
        if (byte != 0) into.push_back({.value = byte, .stamp_ns = stamp_ns});  // FF, or what no kernel sends
        break;
      case State::kError:
        state_ = State::kPlain;
        // The kernel says both, a break and a damaged zero, in the same three bytes; a break is what DMX is made of.
        into.push_back({.value = byte, .is_break = byte == 0, .framing_error = byte != 0, .stamp_ns = stamp_ns});
        break;
    }
  }
}

}  // namespace footlight::drivers

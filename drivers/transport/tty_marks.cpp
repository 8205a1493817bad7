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
        if (byte != 0) into.push_back({.value = byte, .stamp_ns = stamp_ns});  // FF; no kernel sends others
        break;
      case State::kError:
        state_ = State::kPlain;
        // The kernel marks a break and a zero with a framing error alike. It is taken for a break: frames begin so.
        into.push_back({.value = byte, .is_break = byte == 0, .framing_error = byte != 0, .stamp_ns = stamp_ns});
        break;
    }
  }
}

}  // namespace footlight::drivers

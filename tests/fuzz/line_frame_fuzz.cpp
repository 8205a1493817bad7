// Arbitrary input of a serial line: bytes, breaks and errors in any order, as an FTDI chip or a tty reports them.
#include <cstdlib>
#include <vector>

#include "drivers/transport/tty_marks.h"
#include "drivers/widgets/line_frame.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight::drivers;

void footlight::testing::add_seeds(Seeds& seeds) {
  // In pairs: flags, value. A break, then a short frame; twice.
  std::vector<std::uint8_t> frames;
  for (int frame = 0; frame < 2; ++frame) {
    frames.insert(frames.end(), {1, 0});
    for (std::uint8_t slot = 0; slot < 24; ++slot) frames.insert(frames.end(), {0, slot});
  }
  seeds.add("frames", frames);
  const std::uint8_t marks[] = {0xFF, 0, 0, 0, 1, 2, 0xFF, 0xFF, 0xFF, 0, 7, 0xFF, 0, 0};
  seeds.add("marks", marks);
}

namespace {

void check(LineFrameParser& parser, const LineByte& byte) {
  const auto frame = parser.take(byte);
  if (frame && (frame->bytes.empty() || frame->bytes.size() > 513)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  LineFrameParser parser;
  for (std::size_t i = 0; i + 1 < size; i += 2)
    check(parser, {.value = data[i + 1],
                   .is_break = (data[i] & 1) != 0,
                   .framing_error = (data[i] & 2) != 0,
                   .lost_before = (data[i] & 4) != 0});
  // The same bytes from a tty, whole and divided: the result must not depend on the division.
  std::vector<LineByte> whole, cut;
  TtyMarkParser one, other;
  one.take({data, size}, 0, whole);
  other.take({data, size / 3}, 0, cut);
  other.take({data + size / 3, size - size / 3}, 0, cut);
  if (whole.size() != cut.size()) std::abort();
  for (const LineByte& byte : whole) check(parser, byte);
  if (parser.counters().short_frames > parser.counters().frames) std::abort();
  return 0;
}

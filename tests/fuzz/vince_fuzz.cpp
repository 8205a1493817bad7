// Arbitrary bytes from a Vince USB-DMX512 converter: replies do not depend on how the stream is divided, and a valid
// reply after them is found.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "drivers/widgets/vince_frame.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight::drivers;

void footlight::testing::add_seeds(Seeds& seeds) {
  const std::uint8_t done[] = {0x0F, 0x0F, 0x11, 0, 0, 0, 0x04};
  const std::uint8_t with_data[] = {0x0F, 0x0F, 0x01, 0x11, 0, 2, 0x0F, 0x0F, 0x04};
  seeds.add("done", done);
  seeds.add("data", with_data);
}

namespace {

std::vector<int> replies_in(std::span<const std::uint8_t> stream, std::size_t piece_size) {
  VinceReplyParser parser;
  std::vector<int> found;
  while (!stream.empty()) {
    std::span<const std::uint8_t> piece = stream.first(std::min(piece_size, stream.size()));
    stream = stream.subspan(piece.size());
    VinceReply reply;
    while (parser.next(piece, reply)) found.push_back(reply.command << 8 | reply.status);
  }
  return found;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> stream(data, data + size);
  stream.insert(stream.end(), 128, 0x20);  // ends any unfinished reply
  stream.insert(stream.end(), {0x0F, 0x0F, 0x7B, 0x2A, 0, 0, 0x04});
  const auto whole = replies_in(stream, stream.size());
  if (whole != replies_in(stream, 1) || whole != replies_in(stream, 7)) std::abort();
  if (whole.empty() || whole.back() != 0x7B2A) std::abort();
  return 0;
}

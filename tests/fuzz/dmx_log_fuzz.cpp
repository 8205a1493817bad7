// Fuzzes the reader of DMX logs. The first byte says how the rest is taken: as a file (0: checksums checked, 1:
// ignored), or as the inside of a block (2 and up), so that mutations reach the decoder past checksums and compression.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/sim/dmx_log/exercise.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::vector<std::uint8_t> bytes(data + 1, data + size);
  switch (data[0] % 3) {
    case 0: footlight::testing::exercise_log(std::move(bytes), true); break;
    case 1: footlight::testing::exercise_log(std::move(bytes), false); break;
    default: {
      constexpr footlight::DurationNs kFirstNs = 1'000'000;
      footlight::testing::exercise_block(bytes, static_cast<std::uint32_t>(1 + data[0] * 4), kFirstNs,
                                         60 * footlight::kNsPerS);
    }
  }
  return 0;
}

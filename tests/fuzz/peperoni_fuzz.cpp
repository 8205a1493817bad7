// Arbitrary bytes from a Peperoni interface, parsed as the answer to a frame.
#include <algorithm>
#include <iterator>

#include "drivers/widgets/peperoni_frame.h"
#include "tests/fuzz/fuzz.h"

using footlight::drivers::decode_peperoni_status;
using footlight::drivers::PeperoniStatus;

void footlight::testing::add_seeds(Seeds& seeds) {
  for (std::uint8_t status = 0; status < 5; ++status) {
    const std::uint8_t answer[] = {0x02, 0x4D, 0x6B, 0x32, 23, 0, status, 0};
    seeds.add("status-" + std::to_string(status), answer);
  }
  const std::uint8_t without_magic[] = {0, 1, 2, 3, 4, 5, 6, 7};
  seeds.add("no-answer", without_magic);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using footlight::testing::require;
  constexpr std::uint8_t kMagic[] = {0x02, 0x4D, 0x6B, 0x32};
  const auto status = decode_peperoni_status({data, size});
  // An answer has 8 bytes, a fixed start, and its status in the seventh byte.
  const bool is_answer = size == 8 && std::equal(std::begin(kMagic), std::end(kMagic), data);
  require(status.has_value() == is_answer);
  if (status) require(*status == static_cast<PeperoniStatus>(data[6]));
  return 0;
}

// Arbitrary OLA Show text. Times do not decrease; universes and levels are within their ranges.
#include "sim/dmx_log/ola_show.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  seeds.add("unix", "OLA Show\n1 0,255,7\n23\n2 9,9,9,9\n0\n1 0,255,7\n40\n3 \n1\n");
  seeds.add("dos", "OLA Show\r\n63999 1\r\n20\r\n\r\n1 2,\r\n1000\r\n");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto reader = OlaShowReader::open_text(std::string(reinterpret_cast<const char*>(data), size), "fuzz.show",
                                         static_cast<int>(size % 2));
  if (!reader) {
    require(reader.error().message.starts_with("fuzz.show"));
    return 0;
  }
  OlaShowFrame frame;
  DurationNs before_ns = 0;
  while (true) {
    const auto any = reader->next(frame);
    if (!any) require(any.error().message.starts_with("fuzz.show:"));
    if (!any || !*any) return 0;
    require(is_universe(frame.universe) && frame.slots.size() <= kSlotCountMax && frame.time_ns >= before_ns);
    before_ns = frame.time_ns;
  }
}

// Arbitrary bytes from a widget.
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/fuzz.h"
#include "tests/support/usb_pro_property.h"

void footlight::testing::add_seeds(Seeds& seeds) {
  using namespace footlight::drivers;
  const std::vector<std::uint8_t> slots(512, 0x7E);
  const std::uint8_t received[] = {0, 0, 1, 2, 3, 0xE7, 0x7E};
  const std::uint8_t changes[] = {0, 0x38, 0, 0, 0, 0, 0x16, 0x5D, 0x90};
  const std::uint8_t params[] = {0x44, 1, 9, 1, 40};
  const std::uint8_t serial[] = {0x89, 0x25, 0x17, 0x02};
  seeds.add("send", encode_send_dmx(slots).bytes());
  seeds.add("received", ProMessage(ProLabel::kReceived, received).bytes());
  seeds.add("changes", ProMessage(ProLabel::kChangeOfState, changes).bytes());
  seeds.add("params", ProMessage(ProLabel::kGetParams, params).bytes());
  seeds.add("serial", ProMessage(ProLabel::kSerialNumber, serial).bytes());
  seeds.add("mode", encode_receive_mode(ProReceiveMode::kOnChange).bytes());
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string broken = footlight::testing::check_pro_stream({data, size}, size);
  if (!broken.empty()) {
    std::fprintf(stderr, "%s\n", broken.c_str());
    std::abort();
  }
  return 0;
}

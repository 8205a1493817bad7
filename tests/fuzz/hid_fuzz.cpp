// Arbitrary bytes from HID interfaces: a report of the Nodle family, a configuration descriptor.
#include <cstdio>

#include "tests/fuzz/fuzz.h"
#include "tests/support/hid_descriptors_property.h"
#include "tests/support/nodle_property.h"

void footlight::testing::add_seeds(Seeds& seeds) {
  constexpr std::uint8_t kConfig[] = {9, 2, 41, 0,    1,  1, 0, 0x80, 50,   9, 4,  0, 0, 2, 3, 0, 0, 0,  9, 0x21, 0x11,
                                      1, 0, 1,  0x22, 27, 0, 7, 5,    0x81, 3, 33, 0, 1, 7, 5, 2, 3, 33, 0, 1};
  seeds.add("block", drivers::encode_nodle_block(15, Slots{}));
  seeds.add("mode", drivers::encode_nodle_mode(6));
  seeds.add("descriptor", kConfig);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  for (const std::string& broken :
       {footlight::testing::check_nodle_report({data, size}), footlight::testing::check_hid_descriptor({data, size})}) {
    if (!broken.empty()) std::fprintf(stderr, "%s\n", broken.c_str());
    footlight::testing::require(broken.empty());
  }
  return 0;
}

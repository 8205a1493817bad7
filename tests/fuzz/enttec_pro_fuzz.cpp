// Bytes from a widget, any whatever. Build with clang and -DFOOTLIGHT_FUZZ=ON; run: enttec_pro_fuzz -max_len=4096
#include <cstdio>
#include <cstdlib>

#include "tests/support/usb_pro_property.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string broken = footlight::testing::check_pro_stream({data, size}, size);
  if (!broken.empty()) {
    std::fprintf(stderr, "%s\n", broken.c_str());
    std::abort();
  }
  return 0;
}

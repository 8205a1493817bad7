#include "drivers/transport/hid_descriptors.h"

#include <doctest/doctest.h>

#include "drivers/mock/nodle_model.h"
#include "drivers/mock/velleman_model.h"
#include "tests/support/hid_descriptors_property.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;

TEST_CASE("the size and the interval of the output reports are found in a configuration descriptor") {
  mock::VellemanModel model;
  const auto original = find_hid_output(model.config_descriptor());
  REQUIRE(original);
  CHECK(original->address == 0x01);
  CHECK(original->report_size == 8);
  CHECK(original->interval_ms == 10);
  model.upgraded = true;
  model.interval_ms = 1;
  const auto upgraded = find_hid_output(model.config_descriptor());
  REQUIRE(upgraded);
  CHECK(upgraded->report_size == 64);
  CHECK(upgraded->interval_ms == 1);
}

TEST_CASE("the address of the output endpoint is the one in the descriptor") {
  const auto found = find_hid_output(mock::NodleModel().config_descriptor());
  REQUIRE(found);
  CHECK(found->address == 0x02);
}

TEST_CASE("endpoints towards the host, bulk ones and ones of size 0 are none") {
  CHECK_FALSE(find_hid_output(Bytes{7, 5, 0x81, 3, 64, 0, 10}));
  CHECK_FALSE(find_hid_output(Bytes{7, 5, 0x01, 2, 64, 0, 10}));
  CHECK_FALSE(find_hid_output(Bytes{7, 5, 0x01, 3, 0, 0, 10}));
  CHECK_FALSE(find_hid_output(Bytes{7, 5, 0x01, 3, 64, 0, 0}));
  CHECK(find_hid_output(Bytes{7, 5, 0x01, 3, 64, 0, 10}));
}

TEST_CASE("a descriptor that ends anywhere, or lies about its sizes, is no reason to read past it") {
  const Bytes whole = mock::NodleModel().config_descriptor();
  for (std::size_t size = 0; size <= whole.size(); ++size)
    for (int value : {0, 1, 2, 6, 7, 200, 255})
      for (std::size_t at = 0; at < size; ++at) {
        Bytes bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        bytes[at] = static_cast<std::uint8_t>(value);
        const std::string broken = testing::check_hid_descriptor(bytes);
        REQUIRE_MESSAGE(broken.empty(), broken);
      }
}

}  // namespace
}  // namespace footlight::drivers

// Arbitrary datagrams to the ports of VRSL's OSC feed.
//
// A packet is taken as a whole or not at all; messages lie inside it, and cells have a channel and levels of the grid.
#include <array>
#include <cmath>

#include "drivers/net/osc_packet.h"
#include "drivers/net/vrsl_osc.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using namespace footlight::drivers;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  std::array<std::uint8_t, 64> packet{};
  const auto add = [&](const char* name, std::string_view address, std::span<const std::int32_t> numbers) {
    seeds.add(name, std::span(packet).first(build_osc(address, numbers, packet)));
  };
  add("grey", "/VRSL/ch12", std::array<std::int32_t, 1>{200});
  add("colours", "/VRSL/ch1560", std::array<std::int32_t, 3>{1, 2, 255});
  add("by-argument", "/VRSL", std::array<std::int32_t, 2>{7, 8});
  add("refresh", kVrslOscRefresh, {});
  std::string bundle("#bundle\0\0\0\0\0\0\0\0\1", 16);
  const std::size_t size = build_osc("/VRSL/ch1", std::array<std::int32_t, 1>{9}, packet);
  bundle += std::string{'\0', '\0', '\0', static_cast<char>(size)};
  bundle.append(reinterpret_cast<const char*>(packet.data()), size);
  seeds.add("bundle", bundle);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<OscMessage> messages(1);
  const auto parsed = parse_osc({data, size}, messages);
  if (!parsed) {
    require(messages.size() == 1);
    require(text_of(parsed.error()) != nullptr);
    return 0;
  }
  for (std::size_t i = 1; i < messages.size(); ++i) {
    const OscMessage& message = messages[i];
    const auto* const first = reinterpret_cast<const char*>(data);
    require(message.address.data() >= first && message.address.data() + message.address.size() <= first + size);
    require(message.address.starts_with('/'));
    require(message.number_count <= kOscNumbersMax);
    const auto cell = vrsl_cell_of(message);
    if (!cell) continue;
    require(cell->channel >= 1 && cell->channel <= kVrslCells);
    require(cell->level_count == 1 || cell->level_count == kVrslPlanes);
  }
  return 0;
}

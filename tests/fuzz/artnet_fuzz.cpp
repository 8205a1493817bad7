// Datagrams on port 6454, any whatever. Build with clang and -DFOOTLIGHT_FUZZ=ON; run: artnet_fuzz -max_len=1280
//
// What is accepted lies in the ranges that artnet_packet.h states, and an ArtDmx built anew from what was read reads
// the same again, but for the slot that makes its length even.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "drivers/net/artnet_packet.h"

namespace {

using namespace footlight;
using namespace footlight::drivers;

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto packet = parse_artnet_packet({data, size});
  if (!packet || !std::holds_alternative<ArtnetDmx>(*packet)) return 0;
  const auto& dmx = std::get<ArtnetDmx>(*packet);
  require(dmx.port_address >= 0 && dmx.port_address <= kArtnetPortAddressMax);
  require(!dmx.slots.empty() && dmx.slots.size() <= kSlotCountMax);
  std::array<std::uint8_t, kArtnetDmxBytesMax> built;
  const std::size_t built_size = build_artnet_dmx(dmx, built);
  const auto again = parse_artnet_packet(std::span(built).first(built_size));
  require(again.has_value() && std::holds_alternative<ArtnetDmx>(*again));
  const auto& read = std::get<ArtnetDmx>(*again);
  require(read.port_address == dmx.port_address && read.sequence == dmx.sequence && read.physical == dmx.physical);
  require(read.slots.size() == std::max<std::size_t>(2, (dmx.slots.size() + 1) / 2 * 2));
  require(std::equal(dmx.slots.begin(), dmx.slots.end(), read.slots.begin()));
  return 0;
}

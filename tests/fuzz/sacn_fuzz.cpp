// Datagrams on port 5568, any whatever. Build with clang and -DFOOTLIGHT_FUZZ=ON; run: sacn_fuzz -max_len=1280
//
// What is accepted lies in the ranges that sacn_packet.h states, and a data packet built anew from what was read reads
// the same again.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "drivers/net/sacn_packet.h"

namespace {

using namespace footlight;
using namespace footlight::drivers;

void require(bool holds) {
  if (!holds) std::abort();
}

void check(const SacnData& data) {
  require(is_universe(data.universe));
  require(data.sync_universe == 0 || is_universe(data.sync_universe));
  require(data.priority <= kPriorityMax);
  require(data.slots.size() <= kSlotCountMax);
  std::array<std::uint8_t, kSacnDataBytesMax> packet;
  const std::size_t size = build_sacn_data(data, packet);
  const auto again = parse_sacn_packet(std::span(packet).first(size));
  require(again.has_value() && std::holds_alternative<SacnData>(*again));
  const auto& read = std::get<SacnData>(*again);
  require(read.cid == data.cid && read.universe == data.universe && read.sequence == data.sequence);
  require(read.priority == data.priority && read.sync_universe == data.sync_universe);
  require(read.preview == data.preview && read.terminated == data.terminated && read.force_sync == data.force_sync);
  require(read.start_code == data.start_code);
  require(std::equal(read.slots.begin(), read.slots.end(), data.slots.begin(), data.slots.end()));
}

void check(const SacnSync& sync) { require(is_universe(sync.sync_universe)); }

void check(const SacnDiscovery& discovery) {
  require(discovery.page <= discovery.last_page);
  for (std::size_t i = 0; i < discovery.universe_count(); ++i) require(is_universe(discovery.universe(i)));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto packet = parse_sacn_packet({data, size});
  if (packet) std::visit([](const auto& one) { check(one); }, *packet);
  return 0;
}

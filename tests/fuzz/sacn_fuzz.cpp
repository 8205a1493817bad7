// Datagrams on port 5568, any whatever.
//
// What is accepted lies in the ranges that sacn_packet.h states, and a data packet built anew from what was read reads
// the same again.
#include <algorithm>
#include <array>

#include "drivers/net/sacn_packet.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace footlight;
using namespace footlight::drivers;

using footlight::testing::require;

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

void footlight::testing::add_seeds(Seeds& seeds) {
  std::array<std::uint8_t, kSlotCountMax> slots;
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = static_cast<std::uint8_t>(i);
  std::array<std::uint8_t, kSacnDataBytesMax> packet;
  SacnData data;
  data.cid = {1, 2, 3};
  data.source_name = "Footlight";
  data.universe = 300;
  data.sync_universe = 7;
  data.sequence = 9;
  data.force_sync = true;
  for (const std::size_t count : {std::size_t{0}, std::size_t{24}, slots.size()}) {
    data.slots = std::span(slots).first(count);
    data.start_code = count == 24 ? 0xDD : 0;
    const std::size_t size = build_sacn_data(data, packet);
    seeds.add("data-" + std::to_string(count), std::span(packet).first(size));
  }
  using namespace std::string_literals;
  const std::string root =
      "\x00\x10\x00\x00"
      "ASC-E1.17\0\0\0"s;
  const std::string cid(16, 'c');
  seeds.add("sync", root + "\x70\x21\0\0\0\x08"s + cid + "\x70\x0B\0\0\0\x01\x05\x00\x07\0\0"s);
  seeds.add("discovery", root + "\x70\x6C\0\0\0\x08"s + cid + "\x70\x56\0\0\0\x02"s + std::string(64, 'n') +
                             std::string(4, '\0') + "\x70\x0C\0\0\0\x01\0\0\0\x01\0\x02"s);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto packet = parse_sacn_packet({data, size});
  if (packet) std::visit([](const auto& one) { check(one); }, *packet);
  return 0;
}

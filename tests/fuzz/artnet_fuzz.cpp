// Arbitrary datagrams on port 6454.
//
// Accepted packets are within the ranges of artnet_packet.h. An ArtDmx that is parsed, encoded and parsed again is
// unchanged, except for the slot that makes its length even. An ArtPollReply lists at most eight ports of one net and
// sub-net; encoded and parsed again, it lists the same ones.
#include <algorithm>
#include <array>
#include <vector>

#include "drivers/net/artnet_packet.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using namespace footlight::drivers;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  std::array<std::uint8_t, kSlotCountMax> slots;
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = static_cast<std::uint8_t>(i);
  std::array<std::uint8_t, kArtnetDmxBytesMax> packet;
  ArtnetDmx dmx;
  dmx.port_address = 0x1234;
  dmx.sequence = 7;
  for (const std::size_t count : {std::size_t{2}, std::size_t{24}, slots.size()}) {
    dmx.slots = std::span(slots).first(count);
    const std::size_t size = build_artnet_dmx(dmx, packet);
    seeds.add("dmx-" + std::to_string(count), std::span(packet).first(size));
  }
  ArtnetPollReply reply;
  reply.short_name = "Footlight";
  reply.long_name = "Footlight";
  reply.add({0x120, true, true, true});
  reply.add({0x121, true, false, false});
  reply.add({0x12F, false, true, false});
  std::array<std::uint8_t, kArtnetPollReplyBytes> reply_packet;
  seeds.add("poll-reply", std::span(reply_packet).first(build_artnet_poll_reply(reply, reply_packet)));
  using namespace std::string_view_literals;
  seeds.add("poll", "Art-Net\0\x00\x20\x00\x0E\x20\x00\x7F\xFF\x00\x00"sv);
  seeds.add("sync", "Art-Net\0\x00\x52\x00\x0E\x00\x00"sv);
}

namespace {

std::vector<int> ports_of(const ArtnetPollReply& reply) {
  std::vector<int> ports;
  for (const auto& port : reply.ports()) {
    require(port.port_address >= 0 && port.port_address <= kArtnetPortAddressMax);
    require(port.port_address >> 4 == reply.port_list[0].port_address >> 4);
    ports.push_back(port.port_address * 8 + port.output * 4 + port.active * 2 + port.merging);
  }
  std::sort(ports.begin(), ports.end());
  return ports;
}

void check(const ArtnetPollReply& reply) {
  require(reply.short_name.size() <= 18 && reply.long_name.size() <= 64 && reply.report.size() <= 64);
  std::array<std::uint8_t, kArtnetPollReplyBytes> built;
  build_artnet_poll_reply(reply, built);
  const auto again = parse_artnet_packet(built);
  require(again.has_value() && std::holds_alternative<ArtnetPollReply>(*again));
  const auto& read = std::get<ArtnetPollReply>(*again);
  require(ports_of(read) == ports_of(reply));
  require(read.ip == reply.ip && read.mac == reply.mac && read.bind_index == reply.bind_index);
  require(read.style == reply.style && read.rdm == reply.rdm);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto packet = parse_artnet_packet({data, size});
  if (!packet) return 0;
  if (const auto* reply = std::get_if<ArtnetPollReply>(&*packet)) check(*reply);
  if (!std::holds_alternative<ArtnetDmx>(*packet)) return 0;
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

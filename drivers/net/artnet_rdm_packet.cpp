#include "drivers/net/artnet_rdm_packet.h"

#include "drivers/net/artnet_header.h"
#include "drivers/net/bytes.h"
#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kAtRdmVersion = 12, kAtRdmNet = 21, kAtCommand = 22, kAtAddress = 23;
constexpr std::size_t kHeaderSize = 24;  // all four have net, command and address at the same place
constexpr std::size_t kAtTodPort = 13, kAtTodBindIndex = 20, kAtTodTotal = 24, kAtTodBlock = 26, kAtTodCount = 27;
constexpr std::size_t kTodHeaderSize = 28, kUidSize = 6;
constexpr std::size_t kRequestAddressesMax = 32;
constexpr std::uint8_t kRdmVersion = 1;  // of the standard, not of its draft
constexpr std::uint8_t kTodNak = 0xFF, kTodFlush = 1;

Octets header_of(std::uint16_t op_code, int port_address, std::size_t size) {
  FL_CHECK(port_address >= 0 && port_address <= kArtnetPortAddressMax);
  Octets packet(size);
  artnet::write_header(packet, op_code);
  packet[kAtRdmNet] = static_cast<std::uint8_t>(port_address >> 8);
  packet[kAtAddress] = static_cast<std::uint8_t>(port_address & 0xFF);
  return packet;
}

Octets build(const ArtnetTodRequest& request) {
  const auto& addresses = request.port_addresses;
  FL_CHECK(!addresses.empty() && addresses.size() <= kRequestAddressesMax);
  Octets packet = header_of(kArtnetOpTodRequest, addresses.front() & 0x7F00, kHeaderSize);
  packet[kAtAddress] = static_cast<std::uint8_t>(addresses.size());
  for (const int address : addresses) {
    FL_CHECK_EQ(address >> 8, addresses.front() >> 8);
    packet.push_back(static_cast<std::uint8_t>(address & 0xFF));
  }
  packet.resize(kHeaderSize + kRequestAddressesMax);
  return packet;
}

Octets build(const ArtnetTodData& data) {
  FL_CHECK_LE(data.uids.size(), kArtnetTodUidsMax);
  Octets packet = header_of(kArtnetOpTodData, data.port_address, kTodHeaderSize);
  packet[kAtRdmVersion] = kRdmVersion;
  packet[kAtTodPort] = data.port;
  packet[kAtTodBindIndex] = data.bind_index;
  packet[kAtCommand] = data.available ? 0 : kTodNak;
  write_u16_be(packet, kAtTodTotal, data.total);
  packet[kAtTodBlock] = data.block;
  packet[kAtTodCount] = static_cast<std::uint8_t>(data.uids.size());
  for (const RdmUid& uid : data.uids) add_uid(packet, uid);
  return packet;
}

Octets build(const ArtnetTodControl& control) {
  Octets packet = header_of(kArtnetOpTodControl, control.port_address, kHeaderSize);
  packet[kAtCommand] = control.flush ? kTodFlush : 0;
  return packet;
}

Octets build(const ArtnetRdm& rdm) {
  FL_CHECK_GE(rdm.message.size(), std::size_t{1});
  FL_CHECK_LE(rdm.message.size(), kRdmMessageSizeMax);
  Octets packet = header_of(kArtnetOpRdm, rdm.port_address, kHeaderSize);
  packet[kAtRdmVersion] = kRdmVersion;
  packet.insert(packet.end(), rdm.message.begin() + 1, rdm.message.end());
  return packet;
}

}  // namespace

std::optional<ArtnetRdmPacket> parse_artnet_rdm_packet(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kHeaderSize || !artnet::starts_with_magic(datagram) ||
      read_u16_be(datagram, artnet::kAtVersion) < artnet::kVersion) {
    return std::nullopt;
  }
  const int net = (datagram[kAtRdmNet] & 0x7F) << 8;
  const int port_address = net | datagram[kAtAddress];
  switch (read_u16_le(datagram, artnet::kAtOpCode)) {
    case kArtnetOpTodRequest: {
      ArtnetTodRequest request;
      const std::size_t count = datagram[kAtAddress];
      if (count > kRequestAddressesMax || datagram.size() < kHeaderSize + count) return std::nullopt;
      for (std::size_t i = 0; i < count; ++i) request.port_addresses.push_back(net | datagram[kHeaderSize + i]);
      return request;
    }
    case kArtnetOpTodData: {
      if (datagram.size() < kTodHeaderSize) return std::nullopt;
      ArtnetTodData data;
      const std::size_t count = datagram[kAtTodCount];
      if (count > kArtnetTodUidsMax || datagram.size() < kTodHeaderSize + kUidSize * count) return std::nullopt;
      data.port_address = port_address;
      data.port = datagram[kAtTodPort];
      data.bind_index = datagram[kAtTodBindIndex];
      data.available = datagram[kAtCommand] != kTodNak;
      data.total = read_u16_be(datagram, kAtTodTotal);
      data.block = datagram[kAtTodBlock];
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t at = kTodHeaderSize + kUidSize * i;
        data.uids.push_back({read_u16_be(datagram, at), read_u32_be(datagram, at + 2)});
      }
      return data;
    }
    case kArtnetOpTodControl: return ArtnetTodControl{port_address, datagram[kAtCommand] == kTodFlush};
    case kArtnetOpRdm: {
      // Packets of the draft have another layout.
      if (datagram[kAtRdmVersion] != kRdmVersion || datagram[kAtCommand] != 0) return std::nullopt;
      const auto rest = datagram.subspan(kHeaderSize);
      if (rest.empty() || rest.size() >= kRdmMessageSizeMax) return std::nullopt;
      ArtnetRdm rdm;
      rdm.port_address = port_address;
      rdm.message.push_back(kRdmStartCode);
      rdm.message.insert(rdm.message.end(), rest.begin(), rest.end());
      return rdm;
    }
    default: return std::nullopt;
  }
}

Octets build_artnet_rdm_packet(const ArtnetRdmPacket& packet) {
  return std::visit([](const auto& one) { return build(one); }, packet);
}

}  // namespace footlight::drivers

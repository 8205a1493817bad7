#include "drivers/capture/packet_walk.h"

#include <algorithm>
#include <cstddef>

namespace footlight::drivers {
namespace {

constexpr std::uint16_t kTypeIpv4 = 0x0800;
constexpr std::uint16_t kTypeIpv6 = 0x86DD;
constexpr std::uint8_t kProtocolUdp = 17;
constexpr std::size_t kVlanTagsMax = 4;
constexpr std::size_t kIpv6ExtensionsMax = 8;

using Bytes = std::span<const std::uint8_t>;

std::uint16_t be16(Bytes bytes, std::size_t at) { return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]); }

struct Walk {
  bool cut;

  // Missing bytes were cut off by the capture, or never sent.
  [[nodiscard]] tl::unexpected<WalkFault> missing() const {
    return tl::unexpected(cut ? WalkFault::kCutShort : WalkFault::kMalformed);
  }

  // `at`: position of an EtherType.
  [[nodiscard]] tl::expected<UdpDatagram, WalkFault> from_type(Bytes packet, std::size_t at, std::size_t header) const {
    if (packet.size() < header) return missing();
    std::uint16_t type = be16(packet, at);
    packet = packet.subspan(header);
    for (std::size_t tags = 0; tags < kVlanTagsMax && (type == 0x8100 || type == 0x88A8 || type == 0x9100); ++tags) {
      if (packet.size() < 4) return missing();
      type = be16(packet, 2);
      packet = packet.subspan(4);
    }
    if (type == kTypeIpv4) return ipv4(packet);
    if (type == kTypeIpv6) return ipv6(packet);
    return tl::unexpected(WalkFault::kNotUdp);
  }

  [[nodiscard]] tl::expected<UdpDatagram, WalkFault> ip(Bytes packet) const {
    if (packet.empty()) return missing();
    if (packet[0] >> 4 == 4) return ipv4(packet);
    if (packet[0] >> 4 == 6) return ipv6(packet);
    return tl::unexpected(WalkFault::kNotUdp);
  }

  // RFC 791.
  [[nodiscard]] tl::expected<UdpDatagram, WalkFault> ipv4(Bytes packet) const {
    if (packet.size() < 20) return missing();
    const std::size_t header = std::size_t{packet[0] & 0x0Fu} * 4;
    const std::size_t total = be16(packet, 2);
    if (packet[0] >> 4 != 4 || header < 20 || total < header) return tl::unexpected(WalkFault::kMalformed);
    if (packet[9] != kProtocolUdp) return tl::unexpected(WalkFault::kNotUdp);
    if ((be16(packet, 6) & 0x3FFF) != 0) return tl::unexpected(WalkFault::kFragment);  // more fragments, or an offset
    if (packet.size() < header) return missing();
    // Ethernet may add padding after the end of the IP packet.
    return udp(packet.first(std::min(packet.size(), total)).subspan(header), total - header, packet.subspan(12, 4));
  }

  // RFC 8200.
  [[nodiscard]] tl::expected<UdpDatagram, WalkFault> ipv6(Bytes packet) const {
    if (packet.size() < 40) return missing();
    if (packet[0] >> 4 != 6) return tl::unexpected(WalkFault::kMalformed);
    const Bytes from = packet.subspan(8, 16);
    std::size_t length = be16(packet, 4);
    std::uint8_t next = packet[6];
    packet = packet.subspan(40);
    packet = packet.first(std::min(packet.size(), length));
    for (std::size_t i = 0; i < kIpv6ExtensionsMax; ++i) {
      if (next == 44) return tl::unexpected(WalkFault::kFragment);
      if (next != 0 && next != 43 && next != 60) break;  // hop-by-hop, routing and destination options are skipped
      if (packet.size() < 8) return missing();
      const std::size_t size = (std::size_t{packet[1]} + 1) * 8;
      if (size > length) return tl::unexpected(WalkFault::kMalformed);
      if (size > packet.size()) return missing();
      next = packet[0];
      packet = packet.subspan(size);
      length -= size;
    }
    if (next != kProtocolUdp) return tl::unexpected(WalkFault::kNotUdp);
    return udp(packet, length, from);
  }

  // RFC 768. `length`: of the datagram, from the IP header; `packet` has no more than that.
  [[nodiscard]] tl::expected<UdpDatagram, WalkFault> udp(Bytes packet, std::size_t length, Bytes from) const {
    if (length < 8) return tl::unexpected(WalkFault::kMalformed);
    if (packet.size() < 8) return missing();
    const std::size_t size = be16(packet, 4);
    if (size < 8 || size > length) return tl::unexpected(WalkFault::kMalformed);
    if (size > packet.size()) return missing();
    return UdpDatagram{from, be16(packet, 0), be16(packet, 2), packet.subspan(8, size - 8)};
  }
};

}  // namespace

tl::expected<UdpDatagram, WalkFault> find_udp(LinkLayer link, Bytes packet, bool cut) {
  const Walk walk{cut};
  switch (link) {
    case LinkLayer::kEthernet: return walk.from_type(packet, 12, 14);
    case LinkLayer::kLinuxCooked: return walk.from_type(packet, 14, 16);
    case LinkLayer::kLinuxCooked2: return walk.from_type(packet, 0, 20);
    case LinkLayer::kRawIp: return walk.ip(packet);
    case LinkLayer::kLoopback:
      if (packet.size() < 4) return walk.missing();
      return walk.ip(packet.subspan(4));
  }
  return tl::unexpected(WalkFault::kNotUdp);
}

}  // namespace footlight::drivers

// Finds the UDP datagram in a captured packet: link layer, VLAN tags, IPv4 or IPv6, UDP. Bytes only, no library; every
// length is checked against the captured bytes.
//
// Checksums are not checked, because network cards fill them in after the capture. Fragments are not reassembled: sACN
// and Art-Net packets fit one Ethernet frame, so a fragment means a misconfigured sender.
#pragma once

#include <cstdint>
#include <span>

#include <tl/expected.hpp>

namespace footlight::drivers {

enum class LinkLayer {
  kEthernet,
  kLinuxCooked,   // "any" interface, LINKTYPE_LINUX_SLL
  kLinuxCooked2,  // LINKTYPE_LINUX_SLL2
  kRawIp,         // IPv4 or IPv6 without a link header
  kLoopback,      // BSD: four bytes of address family, in either byte order
};

struct UdpDatagram {
  std::span<const std::uint8_t> from_address;  // 4 or 16 octets
  std::uint16_t from_port = 0;
  std::uint16_t to_port = 0;
  std::span<const std::uint8_t> payload;
};

enum class WalkFault {
  kNotUdp,     // ARP, TCP, IGMP, ...
  kFragment,   // part of a datagram
  kCutShort,   // the capture kept only the first bytes of the packet
  kMalformed,  // lengths that contradict each other
};

// The views refer to `packet`. `cut`: the packet on the wire was longer.
[[nodiscard]] tl::expected<UdpDatagram, WalkFault> find_udp(LinkLayer link, std::span<const std::uint8_t> packet,
                                                            bool cut);

}  // namespace footlight::drivers

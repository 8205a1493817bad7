// From the bytes of a captured packet to the UDP datagram inside: link layer, VLAN tags, IPv4 or IPv6, UDP. Bytes only,
// no library; every length is held against what was captured.
//
// Checksums are not looked at: network cards fill them in after a capture has seen the packet. Fragments are not put
// together: sACN and Art-Net fit one Ethernet frame, so a fragment of one is a sender that is misconfigured.
#pragma once

#include <cstdint>
#include <span>

#include <tl/expected.hpp>

namespace footlight::drivers {

enum class LinkLayer {
  kEthernet,
  kLinuxCooked,   // "any" interface, LINKTYPE_LINUX_SLL
  kLinuxCooked2,  // LINKTYPE_LINUX_SLL2
  kRawIp,         // IPv4 or IPv6 without anything before it
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

// The views look into `packet`. `cut`: the capture says that the packet was longer.
[[nodiscard]] tl::expected<UdpDatagram, WalkFault> find_udp(LinkLayer link, std::span<const std::uint8_t> packet,
                                                            bool cut);

}  // namespace footlight::drivers

// Encodes and decodes the packets of Art-Net 4 for Remote Device Management: a gateway's table of devices, and messages
// through it. Fields as in Wireshark's dissector, which the tests use to check the packets built here.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "drivers/net/artnet_packet.h"
#include "drivers/rdm/rdm_packet.h"

namespace footlight::drivers {

inline constexpr std::uint16_t kArtnetOpTodRequest = 0x8000;
inline constexpr std::uint16_t kArtnetOpTodData = 0x8100;
inline constexpr std::uint16_t kArtnetOpTodControl = 0x8200;
inline constexpr std::uint16_t kArtnetOpRdm = 0x8300;
[[nodiscard]] constexpr bool is_artnet_rdm(std::uint16_t op_code) {
  return op_code == kArtnetOpTodRequest || op_code == kArtnetOpTodData || op_code == kArtnetOpTodControl ||
         op_code == kArtnetOpRdm;
}
inline constexpr std::size_t kArtnetTodUidsMax = 200;  // in one packet

// Requests the tables of these ports from gateways: 1 to 32 ports of one net.
struct ArtnetTodRequest {
  std::vector<int> port_addresses;
};

// A block of a table. Every block has the total of the table.
struct ArtnetTodData {
  int port_address = 0;
  std::uint8_t port = 1;  // of the gateway, 1 to 4 within a bind index
  std::uint8_t bind_index = 1;
  bool available = true;  // false: discovery has not ended, or has failed
  std::uint16_t total = 0;
  std::uint8_t block = 0;
  std::vector<RdmUid> uids;  // at most kArtnetTodUidsMax
};

struct ArtnetTodControl {
  int port_address = 0;
  bool flush = false;  // discard the table and search again
};

// One message, in either direction.
struct ArtnetRdm {
  int port_address = 0;
  Octets message;  // with its start code, which is not on the wire
};

using ArtnetRdmPacket = std::variant<ArtnetTodRequest, ArtnetTodData, ArtnetTodControl, ArtnetRdm>;

// nullopt: another operation code, or malformed.
[[nodiscard]] std::optional<ArtnetRdmPacket> parse_artnet_rdm_packet(std::span<const std::uint8_t> datagram);
// FL_CHECK: the limits above.
[[nodiscard]] Octets build_artnet_rdm_packet(const ArtnetRdmPacket& packet);

}  // namespace footlight::drivers

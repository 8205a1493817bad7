// The packets of Art-Net 4 that carry Remote Device Management, in and out: a gateway's table of devices, and messages
// through it. Fields as in Wireshark's dissector, which the tests have judge what is built here.
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

// Asks gateways for the tables of these ports: 1 to 32 of one net.
struct ArtnetTodRequest {
  std::vector<int> port_addresses;
};

// A block of a table: all of them have its total.
struct ArtnetTodData {
  int port_address = 0;
  std::uint8_t port = 1;  // of the gateway, 1 to 4 within a bind index
  std::uint8_t bind_index = 1;
  bool available = true;  // false: discovery has not ended, or failed
  std::uint16_t total = 0;
  std::uint8_t block = 0;
  std::vector<RdmUid> uids;  // at most kArtnetTodUidsMax
};

struct ArtnetTodControl {
  int port_address = 0;
  bool flush = false;  // forget the table and search anew
};

// One message, either way.
struct ArtnetRdm {
  int port_address = 0;
  Octets message;  // with its start code, which is not on the wire
};

using ArtnetRdmPacket = std::variant<ArtnetTodRequest, ArtnetTodData, ArtnetTodControl, ArtnetRdm>;

// nullopt: another operation code, or broken.
[[nodiscard]] std::optional<ArtnetRdmPacket> parse_artnet_rdm_packet(std::span<const std::uint8_t> datagram);
// Checked (FL_CHECK): the limits above.
[[nodiscard]] Octets build_artnet_rdm_packet(const ArtnetRdmPacket& packet);

}  // namespace footlight::drivers

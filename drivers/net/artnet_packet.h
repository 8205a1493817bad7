// The packets of Art-Net 4 that this program speaks, as bytes: ArtDmx in and out, ArtPoll in, ArtPollReply out. ArtSync
// is recognised. No socket, no clock, no memory of its own.
//
// All begin with "Art-Net", a zero and a 16-bit operation code, low octet first; the other numbers are high octet first
// unless said otherwise.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "drivers/net/net.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::size_t kArtnetDmxHeaderBytes = 18;
inline constexpr std::size_t kArtnetDmxBytesMax = kArtnetDmxHeaderBytes + kSlotCountMax;
inline constexpr std::size_t kArtnetPollBytesMin = 14;
inline constexpr std::size_t kArtnetPollReplyBytes = 239;
inline constexpr int kArtnetPortAddressMax = 0x7FFF;
inline constexpr int kArtnetReplyPortsMax = 4;

// Wire universe 1 is port address 0.
[[nodiscard]] constexpr int artnet_port_address(int wire_universe) { return wire_universe - 1; }
[[nodiscard]] constexpr int artnet_wire_universe(int port_address) { return port_address + 1; }

struct ArtnetDmx {
  std::uint8_t sequence = 0;            // 1 to 255; 0: the sender does not number its frames
  std::uint8_t physical = 0;            // input that the frame came from, for information
  int port_address = 0;                 // 0 to 0x7FFF: net (7 bits), sub-net (4), universe (4)
  std::span<const std::uint8_t> slots;  // 1 to 512 as read; an even number from 2 to 512 as written
};

struct ArtnetPoll {
  std::uint8_t flags = 0;
  // Ports outside need not answer. The whole range unless bit 5 of flags asks for targeted mode.
  int port_address_first = 0;
  int port_address_last = kArtnetPortAddressMax;
};

struct ArtnetSync {};

// Any other operation code: well-formed as far as it can be told, and not for us.
struct ArtnetOther {
  std::uint16_t op_code = 0;
};

using ArtnetPacket = std::variant<ArtnetDmx, ArtnetPoll, ArtnetSync, ArtnetOther>;

enum class ArtnetFault {
  kTooShort,     // shorter than the header of its operation code
  kNotArtnet,    // does not begin with "Art-Net"
  kVersion,      // protocol version below 14
  kPortAddress,  // more than 15 bits
  kLength,       // length outside 1 to 512, or more than the datagram holds
};
[[nodiscard]] const char* text_of(ArtnetFault fault);

// An odd length is accepted though the specification asks for an even one: senders exist that send it, and nothing is
// lost. Octets past the length are ignored.
[[nodiscard]] tl::expected<ArtnetPacket, ArtnetFault> parse_artnet_packet(std::span<const std::uint8_t> datagram);
[[nodiscard]] Result<ArtnetPacket> parse_artnet(std::span<const std::uint8_t> datagram);

// Writes ArtDmx and returns its size in octets. The slots are padded with a zero to an even number, and to two at
// least. Checked (FL_CHECK): port address, at most 512 slots, `out` large enough.
std::size_t build_artnet_dmx(const ArtnetDmx& dmx, std::span<std::uint8_t> out);

// What this program tells about up to four of its ports. They share net and sub-net (the upper 11 bits).
struct ArtnetPollReply {
  std::array<std::uint8_t, 4> ip = {};  // ours, as the asker reaches it
  std::array<std::uint8_t, 6> mac = {};
  std::string_view short_name;  // at most 17 octets go out
  std::string_view long_name;   // at most 63
  std::string_view report;      // "#0001 [count] text", at most 63
  std::uint8_t bind_index = 1;  // 1 for the first four ports, 2 for the next, up to 255
  struct Port {
    int port_address = 0;
    bool active = false;  // frames have come for it lately
  };
  std::span<const Port> ports;  // 1 to 4
};

// Returns kArtnetPollReplyBytes.
std::size_t build_artnet_poll_reply(const ArtnetPollReply& reply, std::span<std::uint8_t> out);

}  // namespace footlight::drivers

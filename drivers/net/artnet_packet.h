// Encodes and decodes the packets of Art-Net 4 that this program uses: ArtDmx, ArtSync, ArtPoll, ArtPollReply. No
// socket, no clock, no memory of its own.
//
// Sources of the fields: the packet definitions of art-net.org.uk ("How it works"), and the dissector of Wireshark 4,
// which the tests use to check the packets built here.
//
// All packets start with "Art-Net", a zero and a 16-bit operation code, low octet first. Other numbers are high octet
// first unless stated otherwise.
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

inline constexpr std::uint16_t kArtnetOpPoll = 0x2000;
inline constexpr std::uint16_t kArtnetOpPollReply = 0x2100;
inline constexpr std::size_t kArtnetDmxHeaderBytes = 18;
inline constexpr std::size_t kArtnetDmxBytesMax = kArtnetDmxHeaderBytes + kSlotCountMax;
inline constexpr std::size_t kArtnetPollBytesMin = 14;
inline constexpr std::size_t kArtnetPollReplyBytes = 239;
inline constexpr std::size_t kArtnetSyncBytes = 14;
inline constexpr int kArtnetPortAddressMax = 0x7FFF;
inline constexpr int kArtnetReplyPortsMax = 4;  // each way: four outputs and four inputs

// Wire universe 1 is port address 0.
[[nodiscard]] constexpr int artnet_port_address(int wire_universe) { return wire_universe - 1; }
[[nodiscard]] constexpr int artnet_wire_universe(int port_address) { return port_address + 1; }

struct ArtnetDmx {
  std::uint8_t sequence = 0;            // 1 to 255; 0: the sender does not number its frames
  std::uint8_t physical = 0;            // input that the frame came from, for information
  int port_address = 0;                 // 0 to 0x7FFF: net (7 bits), sub-net (4), universe (4)
  std::span<const std::uint8_t> slots;  // decoded: 1 to 512; encoded: an even number from 2 to 512
};

inline constexpr std::uint8_t kArtnetPollOnChange = 0x02;  // reply again when something changes
inline constexpr std::uint8_t kArtnetPollTargeted = 0x20;

struct ArtnetPoll {
  std::uint8_t flags = 0;  // or-ed kArtnetPoll...; the other bits request diagnostics, which this program does not have
  // Ports outside need not answer. The whole range unless bit 5 of flags sets targeted mode.
  int port_address_first = 0;
  int port_address_last = kArtnetPortAddressMax;
};

struct ArtnetSync {};

// The description of a device and up to four of its output and four of its input ports. All of them share net and
// sub-net (the upper 11 bits).
struct ArtnetPollReply {
  enum class Style : std::uint8_t { kNode = 0, kController = 1 };  // other numbers are devices of other kinds
  struct Port {
    int port_address = 0;
    bool output = true;    // takes DMX from Art-Net; false: sends DMX to Art-Net
    bool active = false;   // frames were received recently
    bool merging = false;  // output: of several senders
  };
  std::array<std::uint8_t, 4> ip = {};  // the address that the requester can reach
  std::array<std::uint8_t, 6> mac = {};
  std::string_view short_name;  // at most 17 octets are sent
  std::string_view long_name;   // at most 63
  std::string_view report;      // "#0001 [count] text", at most 63
  std::uint8_t bind_index = 1;  // 1 for the first reply of a device, 2 for the next, up to 255; 0 as 1
  Style style = Style::kNode;
  bool rdm = false;                                                       // the ports can carry RDM
  std::array<Port, std::size_t{2}* kArtnetReplyPortsMax> port_list = {};  // the first port_count are valid
  std::size_t port_count = 0;
  [[nodiscard]] std::span<const Port> ports() const { return std::span(port_list).first(port_count); }
  // FL_CHECK: there is room.
  void add(const Port& port);
};

// A well-formed packet with any other operation code.
struct ArtnetOther {
  std::uint16_t op_code = 0;
};

using ArtnetPacket = std::variant<ArtnetDmx, ArtnetPoll, ArtnetPollReply, ArtnetSync, ArtnetOther>;

enum class ArtnetFault {
  kTooShort,     // shorter than the header for its operation code
  kNotArtnet,    // does not begin with "Art-Net"
  kVersion,      // protocol version below 14
  kPortAddress,  // more than 15 bits
  kLength,       // length outside 1 to 512, or more than the datagram holds
};
[[nodiscard]] const char* text_of(ArtnetFault fault);

// Accepts an odd length although the specification requires an even one: some senders use it, and nothing is lost.
// Octets past the length are ignored. ArtPollReply has grown over the versions: octets missing after octet 194 count as
// zero. That is a little less than the 198 and 207 that two versions of the specification require. Text refers to the
// datagram.
[[nodiscard]] tl::expected<ArtnetPacket, ArtnetFault> parse_artnet_packet(std::span<const std::uint8_t> datagram);
[[nodiscard]] Result<ArtnetPacket> parse_artnet(std::span<const std::uint8_t> datagram);

// Writes ArtDmx and returns its size in octets. The slots are padded with a zero to an even number, at least two.
// FL_CHECK: port address, at most 512 slots, `out` large enough.
std::size_t build_artnet_dmx(const ArtnetDmx& dmx, std::span<std::uint8_t> out);

// Writes an untargeted ArtPoll with these flags in its shortest form, which every version of the protocol accepts.
// Returns kArtnetPollBytesMin.
std::size_t build_artnet_poll(std::uint8_t flags, std::span<std::uint8_t> out);

// Returns kArtnetSyncBytes.
std::size_t build_artnet_sync(std::span<std::uint8_t> out);

// Returns kArtnetPollReplyBytes. FL_CHECK: at most four ports each way, of one net and sub-net.
std::size_t build_artnet_poll_reply(const ArtnetPollReply& reply, std::span<std::uint8_t> out);

}  // namespace footlight::drivers

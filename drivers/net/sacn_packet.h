// Encodes and decodes the packets of ANSI E1.31-2018: no socket, no clock, no memory of its own.
//
// A data packet is 126 octets of header and 0 to 512 levels, all numbers big endian. It has three nested layers. Each
// starts with a length that counts from its own first octet to the end of the packet (0x7000 | length). parse_sacn()
// checks every length against the size of the datagram.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "drivers/net/net.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::size_t kSacnDataHeaderBytes = 126;  // with the start code
inline constexpr std::size_t kSacnDataBytesMax = kSacnDataHeaderBytes + kSlotCountMax;
inline constexpr std::size_t kSacnSyncBytes = 49;
inline constexpr std::size_t kSacnDiscoveryHeaderBytes = 120;
inline constexpr int kSacnDiscoveryUniversesMax = 512;  // of one page
inline constexpr std::size_t kSacnDiscoveryBytesMax =
    kSacnDiscoveryHeaderBytes + std::size_t{2} * kSacnDiscoveryUniversesMax;
inline constexpr int kSacnDiscoveryUniverse = 64'214;
inline constexpr std::size_t kSacnSourceNameBytes = 64;  // with the closing zero

// One data packet. The views refer to the datagram (parsed) or to the caller's memory (to be built).
struct SacnData {
  Cid cid = {};
  std::string_view source_name;              // UTF-8, without the closing zero
  std::uint8_t priority = kPriorityDefault;  // 0 to 200
  int sync_universe = 0;                     // 0: not synchronised, else 1 to 63'999
  std::uint8_t sequence = 0;
  bool preview = false;     // options bit 7
  bool terminated = false;  // options bit 6; the levels are meaningless then
  bool force_sync = false;  // options bit 5: continue unsynchronised when synchronisation is lost
  int universe = 0;         // 1 to 63'999
  std::uint8_t start_code = kStartCodeLevels;
  std::span<const std::uint8_t> slots;  // 0 to 512
};

struct SacnSync {
  Cid cid = {};
  std::uint8_t sequence = 0;
  int sync_universe = 0;  // 1 to 63'999
};

struct SacnDiscovery {
  Cid cid = {};
  std::string_view source_name;
  int page = 0;                                // 0 to last_page
  int last_page = 0;                           // 0 to 255
  std::span<const std::uint8_t> universes_be;  // two octets each, big endian, as on the wire

  [[nodiscard]] std::size_t universe_count() const { return universes_be.size() / 2; }
  [[nodiscard]] int universe(std::size_t index) const {
    return universes_be[2 * index] << 8 | universes_be[2 * index + 1];
  }
};

using SacnPacket = std::variant<SacnData, SacnSync, SacnDiscovery>;

// Why a datagram is not an sACN packet. Plain values, so that a port under a flood of invalid packets builds no
// strings.
enum class SacnFault {
  kTooShort,        // shorter than the headers that it declares
  kNotAcn,          // preamble, postamble or ACN packet identifier differ
  kLength,          // a layer's length does not match the size of the datagram
  kVector,          // an unknown kind of packet
  kPropertyFormat,  // address type, first address or increment differ from E1.31
  kSlotCount,       // no start code, or more than 512 slots
  kUniverse,        // outside 1 to 63'999
  kSyncUniverse,    // the same for the synchronisation address
  kPriority,        // above 200
  kPage,            // a discovery page past the last page
};
[[nodiscard]] const char* text_of(SacnFault fault);

// Octets past the end of the root layer are an error too (kLength): E1.31 packets fill their datagram.
[[nodiscard]] tl::expected<SacnPacket, SacnFault> parse_sacn_packet(std::span<const std::uint8_t> datagram);

// As above, with the fault as an Error (kProtocol), for tools that show it.
[[nodiscard]] Result<SacnPacket> parse_sacn(std::span<const std::uint8_t> datagram);

// Writes a data packet and returns its size in octets. FL_CHECK: universe, priority, slot count, and `out` large
// enough. A source name longer than 63 octets is cut at the last whole character.
std::size_t build_sacn_data(const SacnData& data, std::span<std::uint8_t> out);

// Updates what differs between frames in a packet that build_sacn_data() wrote, so that a sink can keep one packet per
// universe. Returns the new size.
std::size_t update_sacn_data(std::span<std::uint8_t> packet, std::uint8_t sequence, bool terminated,
                             std::span<const std::uint8_t> slots);

void build_sacn_sync(const SacnSync& sync, std::span<std::uint8_t, kSacnSyncBytes> out);

// One page of the list of a sender's universes: ascending, at most 512. Returns its size in octets. FL_CHECK: the
// pages, the universes, and `out` large enough.
std::size_t build_sacn_discovery(const Cid& cid, std::string_view source_name, int page, int last_page,
                                 std::span<const int> universes, std::span<std::uint8_t> out);

// 239.255.hi.lo in host byte order (E1.31-2018 section 9.3.1). Universe 1 to 63'999, or kSacnDiscoveryUniverse.
[[nodiscard]] std::uint32_t sacn_group_ipv4(int universe);

}  // namespace footlight::drivers

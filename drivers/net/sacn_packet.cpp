#include "drivers/net/sacn_packet.h"

#include <algorithm>
#include <cstring>

#include "drivers/net/bytes.h"
#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::array<std::uint8_t, 16> kRootStart = {0x00, 0x10, 0x00, 0x00, 'A', 'S', 'C', '-',
                                                     'E',  '1',  '.',  '1',  '7', 0,   0,   0};
constexpr std::uint32_t kRootVectorData = 4;
constexpr std::uint32_t kRootVectorExtended = 8;
constexpr std::uint32_t kFramingVectorSync = 1;  // under kRootVectorExtended
constexpr std::uint32_t kFramingVectorDiscovery = 2;
constexpr std::uint32_t kFramingVectorData = 2;  // under kRootVectorData
constexpr std::uint32_t kDiscoveryVectorList = 1;
constexpr std::uint8_t kDmpVectorSet = 0x02;
constexpr std::uint8_t kDmpAddressType = 0xA1;
constexpr std::uint8_t kOptionPreview = 0x80;
constexpr std::uint8_t kOptionTerminated = 0x40;
constexpr std::uint8_t kOptionForceSync = 0x20;

// The position of each field, in octets from the start of the datagram.
constexpr std::size_t kAtRootLength = 16;
constexpr std::size_t kAtRootVector = 18;
constexpr std::size_t kAtCid = 22;
constexpr std::size_t kAtFramingLength = 38;
constexpr std::size_t kAtFramingVector = 40;
constexpr std::size_t kAtName = 44;
constexpr std::size_t kAtPriority = 108;
constexpr std::size_t kAtSyncUniverse = 109;
constexpr std::size_t kAtSequence = 111;
constexpr std::size_t kAtOptions = 112;
constexpr std::size_t kAtUniverse = 113;
constexpr std::size_t kAtDmpLength = 115;
constexpr std::size_t kAtDmpVector = 117;
constexpr std::size_t kAtDmpAddressType = 118;
constexpr std::size_t kAtDmpFirstAddress = 119;
constexpr std::size_t kAtDmpIncrement = 121;
constexpr std::size_t kAtDmpCount = 123;
constexpr std::size_t kAtStartCode = 125;
constexpr std::size_t kAtSyncPacketSequence = 44;
constexpr std::size_t kAtSyncPacketUniverse = 45;
constexpr std::size_t kAtListLength = 112;
constexpr std::size_t kAtListVector = 114;
constexpr std::size_t kAtListPage = 118;
constexpr std::size_t kAtListLastPage = 119;

// True if the layer's length (from its start at `at`) matches the remaining octets.
bool length_fits(std::span<const std::uint8_t> datagram, std::size_t at) {
  const unsigned flags_and_length = read_u16_be(datagram, at);
  return (flags_and_length & 0xF000u) == 0x7000u && (flags_and_length & 0x0FFFu) == datagram.size() - at;
}

void write_length(std::span<std::uint8_t> packet, std::size_t at) {
  write_u16_be(packet, at, static_cast<std::uint16_t>(0x7000u | (packet.size() - at)));
}

void write_name(std::span<std::uint8_t> packet, std::string_view source_name) {
  const std::string_view name = cut_utf8(source_name, kSacnSourceNameBytes - 1);
  std::copy(name.begin(), name.end(), packet.begin() + kAtName);
}

// Clears a packet with the extended vector and writes its first two layers up to the framing vector.
void write_extended(std::span<std::uint8_t> packet, const Cid& cid, std::uint32_t framing_vector) {
  std::fill(packet.begin(), packet.end(), std::uint8_t{0});
  std::copy(kRootStart.begin(), kRootStart.end(), packet.begin());
  write_length(packet, kAtRootLength);
  write_u32_be(packet, kAtRootVector, kRootVectorExtended);
  std::copy(cid.begin(), cid.end(), packet.begin() + kAtCid);
  write_length(packet, kAtFramingLength);
  write_u32_be(packet, kAtFramingVector, framing_vector);
}

Cid cid_at(std::span<const std::uint8_t> datagram) {
  Cid cid;
  std::copy_n(datagram.begin() + kAtCid, cid.size(), cid.begin());
  return cid;
}

std::string_view name_at(std::span<const std::uint8_t> datagram) {
  const auto field = datagram.subspan(kAtName, kSacnSourceNameBytes);
  const auto end = std::find(field.begin(), field.end(), std::uint8_t{0});
  // A name without a closing zero uses the whole field.
  return {reinterpret_cast<const char*>(field.data()), static_cast<std::size_t>(end - field.begin())};
}

tl::expected<SacnPacket, SacnFault> parse_data(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kSacnDataHeaderBytes) return tl::unexpected(SacnFault::kTooShort);
  if (read_u32_be(datagram, kAtFramingVector) != kFramingVectorData || datagram[kAtDmpVector] != kDmpVectorSet) {
    return tl::unexpected(SacnFault::kVector);
  }
  if (!length_fits(datagram, kAtFramingLength) || !length_fits(datagram, kAtDmpLength)) {
    return tl::unexpected(SacnFault::kLength);
  }
  if (datagram[kAtDmpAddressType] != kDmpAddressType || read_u16_be(datagram, kAtDmpFirstAddress) != 0 ||
      read_u16_be(datagram, kAtDmpIncrement) != 1) {
    return tl::unexpected(SacnFault::kPropertyFormat);
  }
  const std::size_t count = read_u16_be(datagram, kAtDmpCount);  // start code and slots
  if (count < 1 || count > kSlotCountMax + 1) return tl::unexpected(SacnFault::kSlotCount);
  if (count != datagram.size() - kAtStartCode) return tl::unexpected(SacnFault::kLength);

  SacnData data;
  data.cid = cid_at(datagram);
  data.source_name = name_at(datagram);
  data.priority = datagram[kAtPriority];
  data.sync_universe = read_u16_be(datagram, kAtSyncUniverse);
  data.sequence = datagram[kAtSequence];
  data.preview = (datagram[kAtOptions] & kOptionPreview) != 0;
  data.terminated = (datagram[kAtOptions] & kOptionTerminated) != 0;
  data.force_sync = (datagram[kAtOptions] & kOptionForceSync) != 0;
  data.universe = read_u16_be(datagram, kAtUniverse);
  data.start_code = datagram[kAtStartCode];
  data.slots = datagram.subspan(kSacnDataHeaderBytes);
  if (data.priority > kPriorityMax) return tl::unexpected(SacnFault::kPriority);
  if (!is_universe(data.universe)) return tl::unexpected(SacnFault::kUniverse);
  if (data.sync_universe != 0 && !is_universe(data.sync_universe)) return tl::unexpected(SacnFault::kSyncUniverse);
  return data;
}

tl::expected<SacnPacket, SacnFault> parse_sync(std::span<const std::uint8_t> datagram) {
  if (datagram.size() != kSacnSyncBytes) return tl::unexpected(SacnFault::kLength);
  if (!length_fits(datagram, kAtFramingLength)) return tl::unexpected(SacnFault::kLength);
  SacnSync sync;
  sync.cid = cid_at(datagram);
  sync.sequence = datagram[kAtSyncPacketSequence];
  sync.sync_universe = read_u16_be(datagram, kAtSyncPacketUniverse);
  if (!is_universe(sync.sync_universe)) return tl::unexpected(SacnFault::kSyncUniverse);
  return sync;
}

tl::expected<SacnPacket, SacnFault> parse_discovery(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kSacnDiscoveryHeaderBytes) return tl::unexpected(SacnFault::kTooShort);
  if (!length_fits(datagram, kAtFramingLength) || !length_fits(datagram, kAtListLength)) {
    return tl::unexpected(SacnFault::kLength);
  }
  if (read_u32_be(datagram, kAtListVector) != kDiscoveryVectorList) return tl::unexpected(SacnFault::kVector);
  SacnDiscovery discovery;
  discovery.cid = cid_at(datagram);
  discovery.source_name = name_at(datagram);
  discovery.page = datagram[kAtListPage];
  discovery.last_page = datagram[kAtListLastPage];
  discovery.universes_be = datagram.subspan(kSacnDiscoveryHeaderBytes);
  if (discovery.page > discovery.last_page) return tl::unexpected(SacnFault::kPage);
  if (discovery.universes_be.size() % 2 != 0 || discovery.universe_count() > kSacnDiscoveryUniversesMax) {
    return tl::unexpected(SacnFault::kLength);
  }
  for (std::size_t i = 0; i < discovery.universe_count(); ++i) {
    if (!is_universe(discovery.universe(i))) return tl::unexpected(SacnFault::kUniverse);
  }
  return discovery;
}

}  // namespace

const char* text_of(SacnFault fault) {
  switch (fault) {
    case SacnFault::kTooShort: return "the datagram is shorter than its headers";
    case SacnFault::kNotAcn: return "the datagram does not begin as an ACN packet";
    case SacnFault::kLength: return "the length of a layer does not match the size of the datagram";
    case SacnFault::kVector: return "the vector of a layer is unknown to E1.31";
    case SacnFault::kPropertyFormat: return "the address type, first address or increment is not that of E1.31";
    case SacnFault::kSlotCount: return "the count of slots is outside 0 to 512";
    case SacnFault::kUniverse: return "the universe is outside 1 to 63999";
    case SacnFault::kSyncUniverse: return "the synchronisation universe is outside 1 to 63999";
    case SacnFault::kPriority: return "the priority is above 200";
    case SacnFault::kPage: return "the page of a discovery list is past its last page";
  }
  return "unknown fault";
}

tl::expected<SacnPacket, SacnFault> parse_sacn_packet(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kSacnSyncBytes) return tl::unexpected(SacnFault::kTooShort);
  if (!std::equal(kRootStart.begin(), kRootStart.end(), datagram.begin())) return tl::unexpected(SacnFault::kNotAcn);
  if (!length_fits(datagram, kAtRootLength)) return tl::unexpected(SacnFault::kLength);
  const std::uint32_t root_vector = read_u32_be(datagram, kAtRootVector);
  if (root_vector == kRootVectorData) return parse_data(datagram);
  if (root_vector == kRootVectorExtended) {
    const std::uint32_t framing_vector = read_u32_be(datagram, kAtFramingVector);
    if (framing_vector == kFramingVectorSync) return parse_sync(datagram);
    if (framing_vector == kFramingVectorDiscovery) return parse_discovery(datagram);
  }
  return tl::unexpected(SacnFault::kVector);
}

Result<SacnPacket> parse_sacn(std::span<const std::uint8_t> datagram) {
  auto packet = parse_sacn_packet(datagram);
  if (!packet) return fail(ErrorCode::kProtocol, "sACN, {} octets: {}", datagram.size(), text_of(packet.error()));
  return *packet;
}

std::size_t build_sacn_data(const SacnData& data, std::span<std::uint8_t> out) {
  FL_CHECK(is_universe(data.universe));
  FL_CHECK(data.sync_universe == 0 || is_universe(data.sync_universe));
  FL_CHECK_LE(data.priority, kPriorityMax);
  FL_CHECK_LE(data.slots.size(), std::size_t{kSlotCountMax});
  const std::size_t size = kSacnDataHeaderBytes + data.slots.size();
  FL_CHECK_GE(out.size(), size);

  const auto packet = out.first(size);
  std::fill_n(packet.begin(), kSacnDataHeaderBytes, std::uint8_t{0});
  std::copy(kRootStart.begin(), kRootStart.end(), packet.begin());
  write_u32_be(packet, kAtRootVector, kRootVectorData);
  std::copy(data.cid.begin(), data.cid.end(), packet.begin() + kAtCid);
  write_u32_be(packet, kAtFramingVector, kFramingVectorData);
  write_name(packet, data.source_name);
  packet[kAtPriority] = data.priority;
  write_u16_be(packet, kAtSyncUniverse, static_cast<std::uint16_t>(data.sync_universe));
  packet[kAtOptions] =
      static_cast<std::uint8_t>((data.preview ? kOptionPreview : 0) | (data.force_sync ? kOptionForceSync : 0));
  write_u16_be(packet, kAtUniverse, static_cast<std::uint16_t>(data.universe));
  packet[kAtDmpVector] = kDmpVectorSet;
  packet[kAtDmpAddressType] = kDmpAddressType;
  write_u16_be(packet, kAtDmpIncrement, 1);
  packet[kAtStartCode] = data.start_code;
  return update_sacn_data(out, data.sequence, data.terminated, data.slots);
}

std::size_t update_sacn_data(std::span<std::uint8_t> packet, std::uint8_t sequence, bool terminated,
                             std::span<const std::uint8_t> slots) {
  const std::size_t size = kSacnDataHeaderBytes + slots.size();
  FL_CHECK_GE(packet.size(), size);
  const auto used = packet.first(size);
  write_length(used, kAtRootLength);
  write_length(used, kAtFramingLength);
  write_length(used, kAtDmpLength);
  write_u16_be(used, kAtDmpCount, static_cast<std::uint16_t>(slots.size() + 1));
  used[kAtSequence] = sequence;
  used[kAtOptions] =
      static_cast<std::uint8_t>((used[kAtOptions] & ~kOptionTerminated) | (terminated ? kOptionTerminated : 0));
  std::copy(slots.begin(), slots.end(), used.begin() + kSacnDataHeaderBytes);
  return size;
}

void build_sacn_sync(const SacnSync& sync, std::span<std::uint8_t, kSacnSyncBytes> out) {
  FL_CHECK(is_universe(sync.sync_universe));
  write_extended(out, sync.cid, kFramingVectorSync);
  out[kAtSyncPacketSequence] = sync.sequence;
  write_u16_be(out, kAtSyncPacketUniverse, static_cast<std::uint16_t>(sync.sync_universe));
}

std::size_t build_sacn_discovery(const Cid& cid, std::string_view source_name, int page, int last_page,
                                 std::span<const int> universes, std::span<std::uint8_t> out) {
  FL_CHECK(page >= 0 && page <= last_page && last_page <= 255);
  FL_CHECK_LE(universes.size(), std::size_t{kSacnDiscoveryUniversesMax});
  const std::size_t size = kSacnDiscoveryHeaderBytes + 2 * universes.size();
  FL_CHECK_GE(out.size(), size);
  const auto packet = out.first(size);
  write_extended(packet, cid, kFramingVectorDiscovery);
  write_name(packet, source_name);
  write_length(packet, kAtListLength);
  write_u32_be(packet, kAtListVector, kDiscoveryVectorList);
  packet[kAtListPage] = static_cast<std::uint8_t>(page);
  packet[kAtListLastPage] = static_cast<std::uint8_t>(last_page);
  for (std::size_t i = 0; i < universes.size(); ++i) {
    FL_CHECK(is_universe(universes[i]));
    write_u16_be(packet, kSacnDiscoveryHeaderBytes + 2 * i, static_cast<std::uint16_t>(universes[i]));
  }
  return size;
}

std::uint32_t sacn_group_ipv4(int universe) { return 0xEFFF'0000u | static_cast<std::uint32_t>(universe); }

}  // namespace footlight::drivers

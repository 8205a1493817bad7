#include "drivers/net/artnet_packet.h"

#include <algorithm>

#include "drivers/net/artnet_header.h"
#include "drivers/net/bytes.h"
#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::uint16_t kOpDmx = 0x5000;
constexpr std::uint16_t kOpSync = 0x5200;

constexpr std::size_t kAtDmxSequence = 12;
constexpr std::size_t kAtPhysical = 13;
constexpr std::size_t kAtSubUni = 14;
constexpr std::size_t kAtDmxNet = 15;
constexpr std::size_t kAtLength = 16;
constexpr std::size_t kAtPollFlags = 12;
constexpr std::size_t kAtPollLast = 14;  // the upper end of the range comes first
constexpr std::size_t kAtPollFirst = 16;

// ArtPollReply.
constexpr std::size_t kAtReplyIp = 10;
constexpr std::size_t kAtReplyUdpPort = 14;
constexpr std::size_t kAtReplyNet = 18;
constexpr std::size_t kAtReplySub = 19;
constexpr std::size_t kAtReplyOem = 20;
constexpr std::size_t kAtReplyStatus1 = 23;
constexpr std::size_t kAtReplyShortName = 26;
constexpr std::size_t kAtReplyLongName = 44;
constexpr std::size_t kAtReplyReport = 108;
constexpr std::size_t kAtReplyPortCount = 172;
constexpr std::size_t kAtReplyPortTypes = 174;
constexpr std::size_t kAtReplyGoodInput = 178;
constexpr std::size_t kAtReplyGoodOutput = 182;
constexpr std::size_t kAtReplySwIn = 186;
constexpr std::size_t kAtReplySwOut = 190;
constexpr std::size_t kAtReplyStyle = 200;
constexpr std::size_t kAtReplyMac = 201;
constexpr std::size_t kAtReplyBindIp = 207;
constexpr std::size_t kAtReplyBindIndex = 211;
constexpr std::size_t kAtReplyStatus2 = 212;
constexpr std::size_t kAtReplyGoodOutputB = 213;
constexpr std::uint16_t kOemUnknown = 0x00FF;
constexpr std::uint8_t kStatus1Normal = 0xD0;  // indicators normal, port addresses set locally, not over the network
constexpr std::uint8_t kStatus1Rdm = 0x02;
constexpr std::uint8_t kStatus2FifteenBits = 0x08;
constexpr std::uint8_t kPortTypeOutput = 0x80;  // takes DMX512 from Art-Net
constexpr std::uint8_t kPortTypeInput = 0x40;   // sends DMX512 to Art-Net
constexpr std::uint8_t kGoodActive = 0x80;
constexpr std::uint8_t kGoodOutputMerging = 0x08;
constexpr std::uint8_t kGoodOutputBNoRdm = 0xB0;  // RDM disabled, discovery not running, no background discovery
constexpr std::uint8_t kGoodOutputBRdm = 0x30;    // discovery runs on request, not in the background

void write_text(std::span<std::uint8_t> out, std::size_t at, std::size_t field_bytes, std::string_view text) {
  const std::string_view cut = cut_utf8(text, field_bytes - 1);
  std::copy(cut.begin(), cut.end(), out.begin() + static_cast<std::ptrdiff_t>(at));
}

// The text up to the first zero.
std::string_view read_text(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t field_bytes) {
  const auto field = bytes.subspan(at, field_bytes);
  const auto end = std::find(field.begin(), field.end(), 0);
  return {reinterpret_cast<const char*>(field.data()), static_cast<std::size_t>(end - field.begin())};
}

tl::expected<ArtnetPacket, ArtnetFault> parse_poll_reply(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kAtReplySwOut + kArtnetReplyPortsMax) return tl::unexpected(ArtnetFault::kTooShort);
  std::array<std::uint8_t, kArtnetPollReplyBytes> whole = {};
  std::copy_n(datagram.begin(), std::min(datagram.size(), whole.size()), whole.begin());
  ArtnetPollReply reply;
  std::copy_n(whole.begin() + kAtReplyIp, reply.ip.size(), reply.ip.begin());
  std::copy_n(whole.begin() + kAtReplyMac, reply.mac.size(), reply.mac.begin());
  reply.short_name = read_text(datagram, kAtReplyShortName, 18);
  reply.long_name = read_text(datagram, kAtReplyLongName, 64);
  reply.report = read_text(datagram, kAtReplyReport, 64);
  reply.bind_index = whole[kAtReplyBindIndex];
  reply.style = static_cast<ArtnetPollReply::Style>(whole[kAtReplyStyle]);
  reply.rdm = (whole[kAtReplyStatus1] & kStatus1Rdm) != 0;
  const int upper = (whole[kAtReplyNet] & 0x7F) << 8 | (whole[kAtReplySub] & 0x0F) << 4;
  // The types define which ports exist; the number of ports in the packet adds nothing.
  for (std::size_t i = 0; i < kArtnetReplyPortsMax; ++i) {
    const std::uint8_t type = whole[kAtReplyPortTypes + i];
    const std::uint8_t good_output = whole[kAtReplyGoodOutput + i];
    if ((type & kPortTypeOutput) != 0) {
      reply.add({upper | (whole[kAtReplySwOut + i] & 0x0F), true, (good_output & kGoodActive) != 0,
                 (good_output & kGoodOutputMerging) != 0});
    }
    if ((type & kPortTypeInput) != 0) {
      reply.add(
          {upper | (whole[kAtReplySwIn + i] & 0x0F), false, (whole[kAtReplyGoodInput + i] & kGoodActive) != 0, false});
    }
  }
  return reply;
}

tl::expected<ArtnetPacket, ArtnetFault> parse_dmx(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kArtnetDmxHeaderBytes) return tl::unexpected(ArtnetFault::kTooShort);
  if ((datagram[kAtDmxNet] & 0x80u) != 0) return tl::unexpected(ArtnetFault::kPortAddress);
  const std::size_t length = read_u16_be(datagram, kAtLength);
  if (length < 1 || length > kSlotCountMax || length > datagram.size() - kArtnetDmxHeaderBytes) {
    return tl::unexpected(ArtnetFault::kLength);
  }
  ArtnetDmx dmx;
  dmx.sequence = datagram[kAtDmxSequence];
  dmx.physical = datagram[kAtPhysical];
  dmx.port_address = datagram[kAtDmxNet] << 8 | datagram[kAtSubUni];
  dmx.slots = datagram.subspan(kArtnetDmxHeaderBytes, length);
  return dmx;
}

}  // namespace

const char* text_of(ArtnetFault fault) {
  switch (fault) {
    case ArtnetFault::kTooShort: return "the datagram is shorter than its header";
    case ArtnetFault::kNotArtnet: return "the datagram does not begin with \"Art-Net\"";
    case ArtnetFault::kVersion: return "the protocol version is below 14";
    case ArtnetFault::kPortAddress: return "the port address has more than 15 bits";
    case ArtnetFault::kLength: return "the length is outside 1 to 512 or more than the datagram holds";
  }
  return "unknown fault";
}

tl::expected<ArtnetPacket, ArtnetFault> parse_artnet_packet(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < artnet::kAtVersion) return tl::unexpected(ArtnetFault::kTooShort);
  if (!artnet::starts_with_magic(datagram)) return tl::unexpected(ArtnetFault::kNotArtnet);
  const std::uint16_t op_code = read_u16_le(datagram, artnet::kAtOpCode);
  // ArtPollReply is the only packet without a protocol version; it has the address there.
  if (op_code == kArtnetOpPollReply) return parse_poll_reply(datagram);
  if (datagram.size() < artnet::kAtVersion + 2) return tl::unexpected(ArtnetFault::kTooShort);
  if (read_u16_be(datagram, artnet::kAtVersion) < artnet::kVersion) return tl::unexpected(ArtnetFault::kVersion);
  if (op_code == kOpDmx) return parse_dmx(datagram);
  if (op_code == kOpSync) return ArtnetSync{};
  if (op_code != kArtnetOpPoll) return ArtnetOther{op_code};

  if (datagram.size() < kArtnetPollBytesMin) return tl::unexpected(ArtnetFault::kTooShort);
  ArtnetPoll poll;
  poll.flags = datagram[kAtPollFlags];
  if ((poll.flags & kArtnetPollTargeted) != 0 && datagram.size() >= kAtPollFirst + 2) {
    poll.port_address_last = read_u16_be(datagram, kAtPollLast);
    poll.port_address_first = read_u16_be(datagram, kAtPollFirst);
  }
  return poll;
}

Result<ArtnetPacket> parse_artnet(std::span<const std::uint8_t> datagram) {
  auto packet = parse_artnet_packet(datagram);
  if (!packet) return fail(ErrorCode::kProtocol, "Art-Net, {} octets: {}", datagram.size(), text_of(packet.error()));
  return *packet;
}

std::size_t build_artnet_dmx(const ArtnetDmx& dmx, std::span<std::uint8_t> out) {
  FL_CHECK(dmx.port_address >= 0 && dmx.port_address <= kArtnetPortAddressMax);
  FL_CHECK_LE(dmx.slots.size(), std::size_t{kSlotCountMax});
  const std::size_t length = std::max<std::size_t>(2, (dmx.slots.size() + 1) / 2 * 2);
  FL_CHECK_GE(out.size(), kArtnetDmxHeaderBytes + length);
  artnet::write_header(out, kOpDmx);
  out[kAtDmxSequence] = dmx.sequence;
  out[kAtPhysical] = dmx.physical;
  out[kAtSubUni] = static_cast<std::uint8_t>(dmx.port_address & 0xFF);
  out[kAtDmxNet] = static_cast<std::uint8_t>(dmx.port_address >> 8);
  write_u16_be(out, kAtLength, static_cast<std::uint16_t>(length));
  const auto data = out.subspan(kArtnetDmxHeaderBytes, length);
  const auto end = std::copy(dmx.slots.begin(), dmx.slots.end(), data.begin());
  std::fill(end, data.end(), std::uint8_t{0});
  return kArtnetDmxHeaderBytes + length;
}

std::size_t build_artnet_poll(std::uint8_t flags, std::span<std::uint8_t> out) {
  FL_CHECK_GE(out.size(), kArtnetPollBytesMin);
  artnet::write_header(out, kArtnetOpPoll);
  out[kAtPollFlags] = flags;
  out[kAtPollFlags + 1] = 0;  // lowest priority of diagnostics
  return kArtnetPollBytesMin;
}

std::size_t build_artnet_sync(std::span<std::uint8_t> out) {
  FL_CHECK_GE(out.size(), kArtnetSyncBytes);
  artnet::write_header(out, kOpSync);
  out[12] = out[13] = 0;
  return kArtnetSyncBytes;
}

void ArtnetPollReply::add(const Port& port) {
  FL_CHECK_LT(port_count, port_list.size());
  port_list[port_count++] = port;
}

std::size_t build_artnet_poll_reply(const ArtnetPollReply& reply, std::span<std::uint8_t> out) {
  FL_CHECK_GE(out.size(), kArtnetPollReplyBytes);
  const auto packet = out.first(kArtnetPollReplyBytes);
  std::fill(packet.begin(), packet.end(), std::uint8_t{0});
  artnet::write_start(packet, kArtnetOpPollReply);
  std::copy(reply.ip.begin(), reply.ip.end(), packet.begin() + kAtReplyIp);
  write_u16_le(packet, kAtReplyUdpPort, kArtnetPort);
  const int upper = reply.port_count == 0 ? 0 : reply.port_list[0].port_address >> 4;
  packet[kAtReplyNet] = static_cast<std::uint8_t>(upper >> 4);
  packet[kAtReplySub] = static_cast<std::uint8_t>(upper & 0x0F);
  write_u16_be(packet, kAtReplyOem, kOemUnknown);
  packet[kAtReplyStatus1] = static_cast<std::uint8_t>(kStatus1Normal | (reply.rdm ? kStatus1Rdm : 0));
  write_text(packet, kAtReplyShortName, 18, reply.short_name);
  write_text(packet, kAtReplyLongName, 64, reply.long_name);
  write_text(packet, kAtReplyReport, 64, reply.report);
  std::size_t outputs = 0, inputs = 0;
  for (const auto& port : reply.ports()) {
    FL_CHECK_EQ(port.port_address >> 4, upper);
    std::size_t& at = port.output ? outputs : inputs;
    FL_CHECK_LT(at, std::size_t{kArtnetReplyPortsMax});
    packet[kAtReplyPortTypes + at] |= port.output ? kPortTypeOutput : kPortTypeInput;
    std::uint8_t& good = packet[(port.output ? kAtReplyGoodOutput : kAtReplyGoodInput) + at];
    if (port.active) good |= kGoodActive;
    if (port.output && port.merging) good |= kGoodOutputMerging;
    if (port.output) packet[kAtReplyGoodOutputB + at] = reply.rdm ? kGoodOutputBRdm : kGoodOutputBNoRdm;
    packet[(port.output ? kAtReplySwOut : kAtReplySwIn) + at] = static_cast<std::uint8_t>(port.port_address & 0x0F);
    ++at;
  }
  write_u16_be(packet, kAtReplyPortCount, static_cast<std::uint16_t>(std::max(outputs, inputs)));
  packet[kAtReplyStyle] = static_cast<std::uint8_t>(reply.style);
  std::copy(reply.mac.begin(), reply.mac.end(), packet.begin() + kAtReplyMac);
  std::copy(reply.ip.begin(), reply.ip.end(), packet.begin() + kAtReplyBindIp);
  packet[kAtReplyBindIndex] = reply.bind_index;
  packet[kAtReplyStatus2] = kStatus2FifteenBits;
  return kArtnetPollReplyBytes;
}

}  // namespace footlight::drivers

#include "drivers/rdm/rdm_packet.h"

#include <algorithm>
#include <charconv>
#include <numeric>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kAtLength = 2, kAtTo = 3, kAtFrom = 9, kAtTransaction = 15, kAtPort = 16, kAtCount = 17,
                      kAtSubDevice = 18, kAtCommand = 20, kAtParameter = 21, kAtDataLength = 23;
constexpr std::uint8_t kPreamble = 0xFE, kSeparator = 0xAA;
constexpr std::size_t kPreambleMax = 7;
constexpr std::size_t kEncodedUidSize = 12, kEncodedSumSize = 4;

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

void add_word(Octets& bytes, unsigned value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

RdmUid uid_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return {word_at(bytes, at), std::uint32_t{word_at(bytes, at + 2)} << 16 | word_at(bytes, at + 4)};
}

std::uint16_t sum_of(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint16_t>(std::accumulate(bytes.begin(), bytes.end(), 0u));
}

// One octet as two: each bit of it is in one of them, where the other has a 1.
void add_doubled(Octets& bytes, unsigned value) {
  bytes.push_back(static_cast<std::uint8_t>(value | 0xAAu));
  bytes.push_back(static_cast<std::uint8_t>(value | 0x55u));
}

std::optional<unsigned> number_of(std::string_view text, std::size_t digits) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.size() != digits || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

void add_uid(Octets& bytes, const RdmUid& uid) {
  add_word(bytes, uid.manufacturer);
  add_word(bytes, uid.device >> 16);
  add_word(bytes, uid.device & 0xFFFF);
}

std::string text_of(const RdmUid& uid) {
  return uid == kRdmEverybody ? "all" : fmt::format("{:04X}:{:08X}", uid.manufacturer, uid.device);
}

Result<RdmUid> parse_rdm_uid(std::string_view text) {
  if (text == "all") return kRdmEverybody;
  const bool colon = text.size() == 13 && text[4] == ':';
  if (colon || text.size() == 12) {
    const auto manufacturer = number_of(text.substr(0, 4), 4);
    const auto device = number_of(text.substr(colon ? 5 : 4), 8);
    if (manufacturer && device) return RdmUid{static_cast<std::uint16_t>(*manufacturer), *device};
  }
  return fail(ErrorCode::kBadInput, "\"{}\": expected the UID of an RDM device as in 02B0:00012345, or all", text);
}

const char* text_of(RdmFault fault) {
  switch (fault) {
    case RdmFault::kTooShort: return "shorter than a message, or than its length field";
    case RdmFault::kStartCode: return "does not begin with CC 01";
    case RdmFault::kLength: return "the message length and the data length do not match";
    case RdmFault::kChecksum: return "the checksum is wrong";
    case RdmFault::kCommand: return "an unknown command class";
    case RdmFault::kResponseType: return "an unknown type of response";
  }
  return "unknown fault";
}

tl::expected<RdmMessage, RdmFault> parse_rdm_message(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kRdmMessageSizeMin) return tl::unexpected(RdmFault::kTooShort);
  if (bytes[0] != kRdmStartCode || bytes[1] != kRdmSubStartCode) return tl::unexpected(RdmFault::kStartCode);
  const std::size_t length = bytes[kAtLength];
  const std::size_t data_length = bytes[kAtDataLength];
  if (length != kRdmHeaderSize + data_length || data_length > kRdmDataSizeMax) return tl::unexpected(RdmFault::kLength);
  if (bytes.size() < length + 2) return tl::unexpected(RdmFault::kTooShort);
  if (word_at(bytes, length) != sum_of(bytes.first(length))) return tl::unexpected(RdmFault::kChecksum);
  RdmMessage message;
  message.to = uid_at(bytes, kAtTo);
  message.from = uid_at(bytes, kAtFrom);
  message.transaction = bytes[kAtTransaction];
  message.port_or_type = bytes[kAtPort];
  message.message_count = bytes[kAtCount];
  message.sub_device = word_at(bytes, kAtSubDevice);
  message.command = static_cast<RdmCommand>(bytes[kAtCommand]);
  message.parameter = word_at(bytes, kAtParameter);
  switch (message.command) {
    case RdmCommand::kDiscovery:
    case RdmCommand::kDiscoveryResponse:
    case RdmCommand::kGet:
    case RdmCommand::kGetResponse:
    case RdmCommand::kSet:
    case RdmCommand::kSetResponse: break;
    default: return tl::unexpected(RdmFault::kCommand);
  }
  if (is_response(message.command) && message.port_or_type > 3) return tl::unexpected(RdmFault::kResponseType);
  const auto data = bytes.subspan(kRdmHeaderSize, data_length);
  message.data.assign(data.begin(), data.end());
  return message;
}

Result<RdmMessage> parse_rdm(std::span<const std::uint8_t> bytes) {
  auto message = parse_rdm_message(bytes);
  if (!message) return fail(ErrorCode::kProtocol, "RDM, {} octets: {}", bytes.size(), text_of(message.error()));
  return std::move(*message);
}

Octets build_rdm(const RdmMessage& message) {
  FL_CHECK_LE(message.data.size(), kRdmDataSizeMax);
  Octets bytes = {kRdmStartCode, kRdmSubStartCode, static_cast<std::uint8_t>(kRdmHeaderSize + message.data.size())};
  bytes.reserve(kRdmMessageSizeMin + message.data.size());
  add_uid(bytes, message.to);
  add_uid(bytes, message.from);
  bytes.push_back(message.transaction);
  bytes.push_back(message.port_or_type);
  bytes.push_back(message.message_count);
  add_word(bytes, message.sub_device);
  bytes.push_back(static_cast<std::uint8_t>(message.command));
  add_word(bytes, message.parameter);
  bytes.push_back(static_cast<std::uint8_t>(message.data.size()));
  bytes.insert(bytes.end(), message.data.begin(), message.data.end());
  add_word(bytes, sum_of(bytes));
  return bytes;
}

Octets build_discovery_answer(const RdmUid& uid, std::size_t preamble) {
  FL_CHECK_LE(preamble, kPreambleMax);
  Octets plain;
  add_uid(plain, uid);
  Octets doubled;
  for (const std::uint8_t octet : plain) add_doubled(doubled, octet);
  const std::uint16_t sum = sum_of(doubled);
  add_doubled(doubled, sum >> 8);
  add_doubled(doubled, sum & 0xFFu);
  Octets bytes(preamble, kPreamble);
  bytes.push_back(kSeparator);
  bytes.insert(bytes.end(), doubled.begin(), doubled.end());
  return bytes;
}

std::optional<RdmUid> parse_discovery_answer(std::span<const std::uint8_t> bytes) {
  std::size_t at = 0;
  while (at < bytes.size() && at < kPreambleMax && bytes[at] == kPreamble) ++at;
  if (bytes.size() < at + 1 + kEncodedUidSize + kEncodedSumSize || bytes[at] != kSeparator) return std::nullopt;
  const auto doubled = bytes.subspan(at + 1, kEncodedUidSize + kEncodedSumSize);
  Octets plain;
  for (std::size_t i = 0; i < doubled.size(); i += 2) {
    // In an undisturbed answer the filler bits are 1.
    if ((doubled[i] & 0xAAu) != 0xAAu || (doubled[i + 1] & 0x55u) != 0x55u) return std::nullopt;
    plain.push_back(doubled[i] & doubled[i + 1]);
  }
  if (word_at(plain, 6) != sum_of(doubled.first(kEncodedUidSize))) return std::nullopt;
  return uid_at(plain, 0);
}

std::string_view text_of_nack(std::uint16_t reason) {
  constexpr std::array<std::string_view, 20> kTexts = {"unknown parameter",
                                                       "format error",
                                                       "hardware fault",
                                                       "proxy reject",
                                                       "write protect",
                                                       "unsupported command class",
                                                       "data out of range",
                                                       "buffer full",
                                                       "packet size unsupported",
                                                       "sub-device out of range",
                                                       "proxy buffer full",
                                                       "action not supported",
                                                       "endpoint number invalid",
                                                       "invalid endpoint mode",
                                                       "unknown UID",
                                                       "unknown scope",
                                                       "invalid static configuration type",
                                                       "invalid IPv4 address",
                                                       "invalid IPv6 address",
                                                       "invalid port"};
  return reason < kTexts.size() ? kTexts[reason] : "a manufacturer-specific reason";
}

}  // namespace footlight::drivers

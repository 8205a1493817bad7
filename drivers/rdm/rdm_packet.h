// Encodes and decodes the messages of Remote Device Management (ANSI E1.20). No line, no clock, no memory of its own.
//
// A message starts with start code 0xCC and sub-start code 0x01 and ends with a checksum; numbers are high octet first.
// The only other format is the answer to DISC_UNIQUE_BRANCH, which has no start code and doubles every octet, so that
// simultaneous answers of several devices can be detected.
//
// Numbers are those of Wireshark's RDM dissector, which the tests use to check the messages built here. The layout of
// messages follows E1.20 as other implementations have it. The standard itself was not available.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/result.h"

namespace footlight::drivers {

using Octets = std::vector<std::uint8_t>;

inline constexpr std::uint8_t kRdmStartCode = 0xCC;
inline constexpr std::uint8_t kRdmSubStartCode = 0x01;
inline constexpr std::size_t kRdmHeaderSize = 24;  // from the start code to the length of the data
inline constexpr std::size_t kRdmDataSizeMax = 231;
inline constexpr std::size_t kRdmMessageSizeMin = kRdmHeaderSize + 2;
inline constexpr std::size_t kRdmMessageSizeMax = kRdmMessageSizeMin + kRdmDataSizeMax;

// Identifies one responder (or controller) permanently: the manufacturer, and a number that the manufacturer assigns.
struct RdmUid {
  std::uint16_t manufacturer = 0;
  std::uint32_t device = 0;

  friend auto operator<=>(const RdmUid&, const RdmUid&) = default;
  // 48 bits, in the same order.
  [[nodiscard]] constexpr std::uint64_t number() const { return std::uint64_t{manufacturer} << 32 | device; }
  [[nodiscard]] static constexpr RdmUid of_number(std::uint64_t number) {
    return {static_cast<std::uint16_t>(number >> 32), static_cast<std::uint32_t>(number)};
  }
  // Addressed to all devices, of all manufacturers or of one; no device answers.
  [[nodiscard]] constexpr bool is_broadcast() const { return device == 0xFFFF'FFFF; }
};
inline constexpr RdmUid kRdmEverybody{0xFFFF, 0xFFFF'FFFF};
inline constexpr RdmUid kRdmUidMax{0xFFFF, 0xFFFF'FFFE};  // the highest that a responder may have

// "02B0:00012345".
[[nodiscard]] std::string text_of(const RdmUid& uid);
// Also accepts a UID without the colon, and "all". kBadInput names what was expected.
[[nodiscard]] Result<RdmUid> parse_rdm_uid(std::string_view text);

enum class RdmCommand : std::uint8_t {
  kDiscovery = 0x10,
  kDiscoveryResponse = 0x11,
  kGet = 0x20,
  kGetResponse = 0x21,
  kSet = 0x30,
  kSetResponse = 0x31,
};
[[nodiscard]] constexpr bool is_response(RdmCommand command) { return (static_cast<unsigned>(command) & 1u) != 0; }
[[nodiscard]] constexpr RdmCommand response_to(RdmCommand command) {
  return static_cast<RdmCommand>(static_cast<std::uint8_t>(command) | 1u);
}

enum class RdmResponseType : std::uint8_t { kAck = 0, kAckTimer = 1, kNack = 2, kAckOverflow = 3 };

// Parameters that the protocol itself needs; the others are in rdm_parameters.h.
inline constexpr std::uint16_t kRdmUniqueBranch = 0x0001;
inline constexpr std::uint16_t kRdmMute = 0x0002;
inline constexpr std::uint16_t kRdmUnmute = 0x0003;
inline constexpr std::uint16_t kRdmQueuedMessage = 0x0020;
inline constexpr std::uint16_t kRdmStatusMessages = 0x0030;

// Appends the six octets of a UID as messages have them.
void add_uid(Octets& bytes, const RdmUid& uid);

struct RdmMessage {
  RdmUid to;
  RdmUid from;
  std::uint8_t transaction = 0;    // of the request; its response repeats it
  std::uint8_t port_or_type = 1;   // request: the controller's port, 1 to 255; response: an RdmResponseType
  std::uint8_t message_count = 0;  // response: messages waiting in the responder's queue
  std::uint16_t sub_device = 0;    // 0: the device itself; 0xFFFF: all its sub-devices
  RdmCommand command = RdmCommand::kGet;
  std::uint16_t parameter = 0;
  Octets data;  // 0 to 231

  [[nodiscard]] RdmResponseType response_type() const { return static_cast<RdmResponseType>(port_or_type); }
};

enum class RdmFault {
  kTooShort,   // shorter than a message without data, or than its length field
  kStartCode,  // does not begin with CC 01
  kLength,     // the message length and the data length do not match
  kChecksum,   // the checksum differs
  kCommand,    // a command class unknown to E1.20
  kResponseType,
};
[[nodiscard]] const char* text_of(RdmFault fault);

// `bytes` start with the start code; octets after the checksum are ignored.
[[nodiscard]] tl::expected<RdmMessage, RdmFault> parse_rdm_message(std::span<const std::uint8_t> bytes);
[[nodiscard]] Result<RdmMessage> parse_rdm(std::span<const std::uint8_t> bytes);
// FL_CHECK: at most 231 octets of data.
[[nodiscard]] Octets build_rdm(const RdmMessage& message);

// The answer of one device to DISC_UNIQUE_BRANCH. `preamble`: 0 to 7 octets of FE before it.
[[nodiscard]] Octets build_discovery_answer(const RdmUid& uid, std::size_t preamble = 7);
// nullopt: not the undisturbed answer of one device. The preamble may be short or missing: devices may omit part of it,
// and splitters on the line remove some.
[[nodiscard]] std::optional<RdmUid> parse_discovery_answer(std::span<const std::uint8_t> bytes);

// The reason of a refusal as text: "write protect".
[[nodiscard]] std::string_view text_of_nack(std::uint16_t reason);
inline constexpr std::uint16_t kRdmNackUnknownPid = 0, kRdmNackFormat = 1, kRdmNackHardwareFault = 2,
                               kRdmNackWriteProtect = 4, kRdmNackCommandClass = 5, kRdmNackOutOfRange = 6,
                               kRdmNackSubDevice = 9;

}  // namespace footlight::drivers

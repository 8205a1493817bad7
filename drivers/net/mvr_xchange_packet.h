// Packets of MVR-xchange in TCP mode (DIN SPEC 15801, annex on communication): a header of 28 octets, big-endian, and a
// payload. A message is JSON or a file, in one packet or in several of one kind in a row.
//
// Functions on bytes: no socket, no clock, no thread. A file is passed on in pieces as it arrives, so that it needs no
// memory; a JSON text is kept until it is whole.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::size_t kMvrPacketHeaderBytes = 28;
inline constexpr std::uint32_t kMvrPacketMark = 778'682;
inline constexpr std::uint32_t kMvrPacketVersion = 1;
inline constexpr std::uint64_t kMvrJsonBytesMax = 1u << 20;    // of a message
inline constexpr std::uint64_t kMvrFileBytesMax = 2ull << 30;  // of a message
inline constexpr std::uint32_t kMvrPacketsMax = 1u << 20;      // of a message

enum class MvrPayload : std::uint32_t { kJson = 0, kFile = 1 };

struct MvrPacketHeader {
  std::uint32_t number = 0;  // of this packet in its message, from 0
  std::uint32_t count = 1;   // packets of the message
  MvrPayload payload = MvrPayload::kJson;
  std::uint64_t payload_bytes = 0;
  bool operator==(const MvrPacketHeader&) const = default;
};

[[nodiscard]] std::array<std::uint8_t, kMvrPacketHeaderBytes> build_mvr_header(const MvrPacketHeader& header);
// Errors (kProtocol): another mark, version or kind, a number that is not below the count, a length or count above the
// limits.
[[nodiscard]] Result<MvrPacketHeader> parse_mvr_header(std::span<const std::uint8_t, kMvrPacketHeaderBytes> bytes);

// A JSON text as one packet.
[[nodiscard]] std::string build_mvr_json(std::string_view json);

// Receives the messages of a stream. An error ends the stream, and read() returns it.
class MvrPacketReceiver {
 public:
  virtual ~MvrPacketReceiver() = default;
  virtual Status receive_json(std::string_view text) = 0;
  // A piece of a file, not empty. `total_bytes`: what the headers have announced up to now.
  virtual Status receive_file_part(std::span<const std::uint8_t> bytes, std::uint64_t total_bytes) = 0;
  virtual Status receive_file_end() = 0;
};

// Cuts a stream into messages. After an error nothing more can be read.
class MvrPacketReader {
 public:
  // Any number of octets, split anywhere.
  Status read(std::span<const std::uint8_t> bytes, MvrPacketReceiver& receiver);
  // Reads at most to the end of one message. Returns how many octets it took.
  [[nodiscard]] Result<std::size_t> read_message(std::span<const std::uint8_t> all, MvrPacketReceiver& receiver);
  // Between two messages: the stream may end here.
  [[nodiscard]] bool between_messages() const { return header_size_ == 0 && !in_message_; }

 private:
  Status begin_packet();
  Status end_packet(MvrPacketReceiver& receiver);

  std::array<std::uint8_t, kMvrPacketHeaderBytes> header_bytes_ = {};
  std::size_t header_size_ = 0;    // of the header that is being read; full: the payload is
  bool in_message_ = false;        // from the first whole header of a message on
  MvrPacketHeader first_;          // of the message
  std::uint32_t next_number_ = 0;  // of the message's next packet
  std::uint64_t message_bytes_ = 0;
  std::uint64_t left_bytes_ = 0;  // of the payload
  std::string json_;
};

}  // namespace footlight::drivers

// The messages of an ENTTEC DMX USB Pro and its relatives: bytes only, no I/O, no allocation, no time.
//
// A message is  7E label length_low length_high payload[length] E7  with length 0 to 600; 7E and E7 may occur inside
// the payload. Payload layouts follow ENTTEC's "DMX USB Pro Widget API Specification 1.44".
//
// Threads: none of its own; a ProParser belongs to one thread. Errors: kProtocol if a payload does not match its label,
// kBadInput if the caller passes values that the wire cannot carry.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::uint8_t kProStart = 0x7E;
inline constexpr std::uint8_t kProEnd = 0xE7;
inline constexpr std::size_t kProPayloadSizeMax = 600;
inline constexpr std::size_t kProEnvelopeSize = 5;  // start, label, two length bytes, end
inline constexpr std::size_t kProMessageSizeMax = kProPayloadSizeMax + kProEnvelopeSize;

enum class ProLabel : std::uint8_t {
  kGetParams = 3,      // both ways
  kSetParams = 4,      // to the widget, no answer
  kReceived = 5,       // from the widget: one frame of the line
  kSendDmx = 6,        // to the widget; it repeats the frame itself
  kSendRdm = 7,        // to the widget: an RDM request from its start code on; then its port is an input
  kReceiveMode = 8,    // to the widget; turns its port into an input
  kChangeOfState = 9,  // from the widget: changes, in receive mode kOnChange
  kSerialNumber = 10,  // both ways
  kRdmDiscovery = 11,  // as kSendRdm, for DISC_UNIQUE_BRANCH
  kRdmTimeout = 12,    // from the widget: no response; not sent by every firmware
  kApiKey = 13,        // to the widget: opens the labels of a second port
  // Not ENTTEC's: relatives answer, others ignore them.
  kManufacturer = 77,   // both ways: ESTA id, low byte first, then a name
  kDeviceName = 78,     // both ways: device id, low byte first, then a name
  kPortCount = 99,      // both ways: one byte
  kSendDmxFirst = 100,  // as kSendDmx, to one of two ports
  kSendDmxSecond = 101,
};

// One frame as it is on the line: the start code, then up to 512 slots.
inline constexpr std::size_t kLineFrameSizeMax = 1 + kSlotCountMax;
using LineFrame = std::array<std::uint8_t, kLineFrameSizeMax>;

// --- Envelope

// An encoded message; bytes() is its wire format.
class ProMessage {
 public:
  // payload: 0 to 600 bytes; FL_CHECK.
  ProMessage(ProLabel label, std::span<const std::uint8_t> payload);
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return {buffer_.data(), size_}; }

 private:
  std::array<std::uint8_t, kProMessageSizeMax> buffer_;
  std::size_t size_;
};

// Ends an unfinished message, whatever its length field is: enough bytes that are neither a start nor an end, which a
// widget ignores between messages.
[[nodiscard]] std::span<const std::uint8_t> pro_flush_bytes();

struct ProMessageView {
  std::uint8_t label = 0;                 // may be missing in ProLabel
  std::span<const std::uint8_t> payload;  // valid until the parser is used again
};

// Finds messages in a stream that may begin anywhere, be cut anywhere and contain noise. The result does not depend on
// how the stream is divided. Only the first byte of a wrong candidate (length above 600, no E7 at its end) is
// discarded. All bytes after it are examined again, so a true message inside a false one is not lost.
class ProParser {
 public:
  // Consumes bytes from the front of `stream` until a message is complete. Returns true and fills `message`, or false
  // when the stream is used up:
  //   while (parser.next(stream, message)) use(message);
  [[nodiscard]] bool next(std::span<const std::uint8_t>& stream, ProMessageView& message);
  // Stops waiting for the rest of a started message: its first byte counts as garbage, and next() examines the rest
  // again. Call it after a timeout: a widget sends a whole message at once, so a pause inside one means lost bytes.
  void abandon();
  // Inside a message, or of something that may be one.
  [[nodiscard]] bool pending() const { return held_size_ > taken_size_; }
  // Drops held bytes, after a reconnect; the counters stay.
  void reset() { held_size_ = taken_size_ = 0; }

  [[nodiscard]] std::uint64_t message_count() const { return message_count_; }
  // Bytes that belong to no message.
  [[nodiscard]] std::uint64_t garbage_byte_count() const { return garbage_byte_count_; }
  // Start bytes that did not start a message.
  [[nodiscard]] std::uint64_t rejected_count() const { return rejected_count_; }

 private:
  enum class Verdict { kNeedsMore, kMessage, kFalseStart };
  [[nodiscard]] Verdict judge() const;
  // How many bytes the candidate needs before judge() can decide further.
  [[nodiscard]] std::size_t wanted_size() const;
  [[nodiscard]] std::size_t declared_payload_size() const;
  void drop_false_start();
  void drop_taken();
  void drop_front(std::size_t count);

  std::array<std::uint8_t, kProMessageSizeMax> held_;
  std::size_t held_size_ = 0;   // held_[0] is a start byte if this is above 0
  std::size_t taken_size_ = 0;  // bytes at the front of held_ that belong to the last returned message
  std::uint64_t message_count_ = 0;
  std::uint64_t garbage_byte_count_ = 0;
  std::uint64_t rejected_count_ = 0;
};

// --- Payloads

// Labels 3 and 4. Break and mark after break are in units of 32/3 us.
struct ProParams {
  std::uint16_t firmware = 0;    // high byte 1: DMX, 2: RDM (no labels 8 and 9), 3: sniffer; ignored when set
  std::uint8_t break_units = 9;  // 9 to 127
  std::uint8_t mab_units = 1;    // 1 to 127
  std::uint8_t rate_hz = 40;     // 1 to 40; 0: as fast as possible
};
inline constexpr double kProTimeUnitUs = 32.0 / 3.0;
[[nodiscard]] constexpr double us_of_pro_units(std::uint8_t units) { return units * kProTimeUnitUs; }

[[nodiscard]] ProMessage encode_get_params(std::uint16_t user_size = 0);
[[nodiscard]] Result<ProMessage> encode_set_params(const ProParams& params, std::span<const std::uint8_t> user = {});
// Values outside the ranges above are returned unchanged: the widget decides what it does.
[[nodiscard]] Result<ProParams> decode_params(std::span<const std::uint8_t> payload);

// Label 6. Always the start code and 512 slots, missing ones 0: some widgets accept no other length.
[[nodiscard]] ProMessage encode_send_dmx(std::span<const std::uint8_t> slots, std::uint8_t start_code = 0);
// The whole frame, start code first; 25 to 513 bytes.
[[nodiscard]] Result<std::span<const std::uint8_t>> decode_send_dmx(std::span<const std::uint8_t> payload);

// Label 5.
struct ProReceived {
  bool queue_overflow = false;          // status bit 0: the widget lost bytes between its line and USB
  bool overrun = false;                 // status bit 1: the widget lost bytes on the line
  std::span<const std::uint8_t> frame;  // start code first; 1 to 513 bytes; refers to the payload
};
[[nodiscard]] Result<ProReceived> decode_received(std::span<const std::uint8_t> payload);

// Label 8.
enum class ProReceiveMode : std::uint8_t { kEveryFrame = 0, kOnChange = 1 };
[[nodiscard]] ProMessage encode_receive_mode(ProReceiveMode mode);
[[nodiscard]] Result<ProReceiveMode> decode_receive_mode(std::span<const std::uint8_t> payload);

// Label 9: block b, a 40-bit field (bit i, lowest first, is frame byte 8b + i), then one value for every set bit. Frame
// byte 0 is the start code, so frame byte n is DMX address n. Updates the changed bytes of `frame` and returns their
// number. On an error nothing is written.
[[nodiscard]] Result<int> apply_change_of_state(std::span<const std::uint8_t> payload, LineFrame& frame);

// Label 10: four bytes, lowest digits first, two decimal digits each: 89 25 17 02 is 2172589.
[[nodiscard]] ProMessage encode_get_serial();
[[nodiscard]] Result<std::uint32_t> decode_serial(std::span<const std::uint8_t> payload);

}  // namespace footlight::drivers

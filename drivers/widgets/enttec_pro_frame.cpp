#include "drivers/widgets/enttec_pro_frame.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kHeaderSize = 4;  // start, label, two length bytes

constexpr std::uint8_t low_byte(std::size_t value) { return static_cast<std::uint8_t>(value & 0xFF); }
constexpr std::uint8_t high_byte(std::size_t value) { return static_cast<std::uint8_t>((value >> 8) & 0xFF); }

}  // namespace

ProMessage::ProMessage(ProLabel label, std::span<const std::uint8_t> payload)
    : size_(payload.size() + kProEnvelopeSize) {
  FL_CHECK_LE(payload.size(), kProPayloadSizeMax);
  buffer_[0] = kProStart;
  buffer_[1] = static_cast<std::uint8_t>(label);
  buffer_[2] = low_byte(payload.size());
  buffer_[3] = high_byte(payload.size());
  std::copy(payload.begin(), payload.end(), buffer_.begin() + kHeaderSize);
  buffer_[size_ - 1] = kProEnd;
}

std::span<const std::uint8_t> pro_flush_bytes() {
  static constexpr std::array<std::uint8_t, kProMessageSizeMax> kZeros{};
  return kZeros;
}

std::size_t ProParser::declared_payload_size() const { return held_[2] | static_cast<std::size_t>(held_[3]) << 8; }

ProParser::Verdict ProParser::judge() const {
  if (held_size_ < kHeaderSize) return Verdict::kNeedsMore;
  const std::size_t payload_size = declared_payload_size();
  if (payload_size > kProPayloadSizeMax) return Verdict::kFalseStart;
  if (held_size_ < payload_size + kProEnvelopeSize) return Verdict::kNeedsMore;
  return held_[payload_size + kProEnvelopeSize - 1] == kProEnd ? Verdict::kMessage : Verdict::kFalseStart;
}

std::size_t ProParser::wanted_size() const {
  return held_size_ < kHeaderSize ? kHeaderSize : declared_payload_size() + kProEnvelopeSize;
}

void ProParser::drop_front(std::size_t count) {
  std::memmove(held_.data(), held_.data() + count, held_size_ - count);
  held_size_ -= count;
}

void ProParser::drop_false_start() {
  const auto rest = std::find(held_.begin() + 1, held_.begin() + static_cast<std::ptrdiff_t>(held_size_), kProStart);
  const auto dropped = static_cast<std::size_t>(rest - held_.begin());
  garbage_byte_count_ += dropped;
  ++rejected_count_;
  drop_front(dropped);
}

void ProParser::drop_taken() {
  if (taken_size_ == 0) return;
  // The bytes after a message were stored before it was recognised, so they may start with noise.
  const auto held_end = held_.begin() + static_cast<std::ptrdiff_t>(held_size_);
  const auto rest = std::find(held_.begin() + static_cast<std::ptrdiff_t>(taken_size_), held_end, kProStart);
  const auto dropped = static_cast<std::size_t>(rest - held_.begin());
  garbage_byte_count_ += dropped - taken_size_;
  drop_front(dropped);
  taken_size_ = 0;
}

bool ProParser::next(std::span<const std::uint8_t>& stream, ProMessageView& message) {
  drop_taken();
  while (true) {
    if (held_size_ > 0) {
      switch (judge()) {
        case Verdict::kMessage:
          message = {held_[1], {held_.data() + kHeaderSize, declared_payload_size()}};
          taken_size_ = message.payload.size() + kProEnvelopeSize;
          ++message_count_;
          return true;
        case Verdict::kFalseStart: drop_false_start(); continue;
        case Verdict::kNeedsMore: break;
      }
    } else {
      const auto start = std::find(stream.begin(), stream.end(), kProStart);
      const auto skipped = static_cast<std::size_t>(start - stream.begin());
      garbage_byte_count_ += skipped;
      stream = stream.subspan(skipped);
    }
    if (stream.empty()) return false;
    const std::size_t count = std::min(wanted_size() - held_size_, stream.size());
    std::memcpy(held_.data() + held_size_, stream.data(), count);
    held_size_ += count;
    stream = stream.subspan(count);
  }
}

void ProParser::abandon() {
  drop_taken();
  if (held_size_ > 0) drop_false_start();
}

ProMessage encode_get_params(std::uint16_t user_size) {
  const std::uint8_t payload[] = {low_byte(user_size), high_byte(user_size)};
  return ProMessage(ProLabel::kGetParams, payload);
}

Result<ProMessage> encode_set_params(const ProParams& params, std::span<const std::uint8_t> user) {
  constexpr std::size_t kFixedSize = 5;
  constexpr std::size_t kUserSizeMax = 508;  // the widget's capacity
  if (params.break_units < 9 || params.break_units > 127)
    return fail(ErrorCode::kBadInput, "break of {} units: expected 9 to 127 units of 10.67 us", params.break_units);
  if (params.mab_units < 1 || params.mab_units > 127)
    return fail(ErrorCode::kBadInput, "mark after break of {} units: expected 1 to 127 units of 10.67 us",
                params.mab_units);
  if (params.rate_hz > 40)
    return fail(ErrorCode::kBadInput, "rate of {} Hz: expected 1 to 40, or 0 for as fast as possible", params.rate_hz);
  if (user.size() > kUserSizeMax)
    return fail(ErrorCode::kBadInput, "user configuration of {} bytes: expected at most {}", user.size(), kUserSizeMax);
  std::array<std::uint8_t, kFixedSize + kUserSizeMax> payload{low_byte(user.size()), high_byte(user.size()),
                                                              params.break_units, params.mab_units, params.rate_hz};
  std::copy(user.begin(), user.end(), payload.begin() + kFixedSize);
  return ProMessage(ProLabel::kSetParams, std::span(payload).first(kFixedSize + user.size()));
}

Result<ProParams> decode_params(std::span<const std::uint8_t> payload) {
  if (payload.size() < 5)
    return fail(ErrorCode::kProtocol, "parameters (label 3) of {} bytes: expected at least 5", payload.size());
  return ProParams{.firmware = static_cast<std::uint16_t>(payload[0] | payload[1] << 8),
                   .break_units = payload[2],
                   .mab_units = payload[3],
                   .rate_hz = payload[4]};
}

ProMessage encode_send_dmx(std::span<const std::uint8_t> slots, std::uint8_t start_code) {
  FL_CHECK_LE(slots.size(), static_cast<std::size_t>(kSlotCountMax));
  LineFrame frame{};
  frame[0] = start_code;
  std::copy(slots.begin(), slots.end(), frame.begin() + 1);
  return ProMessage(ProLabel::kSendDmx, frame);
}

Result<std::span<const std::uint8_t>> decode_send_dmx(std::span<const std::uint8_t> payload) {
  if (payload.size() < 25 || payload.size() > kLineFrameSizeMax)
    return fail(ErrorCode::kProtocol, "frame to send (label 6) of {} bytes: expected 25 to 513", payload.size());
  return payload;
}

Result<ProReceived> decode_received(std::span<const std::uint8_t> payload) {
  if (payload.size() < 2 || payload.size() > 1 + kLineFrameSizeMax)
    return fail(ErrorCode::kProtocol, "received frame (label 5) of {} bytes: expected 2 to 514", payload.size());
  return ProReceived{
      .queue_overflow = (payload[0] & 1u) != 0, .overrun = (payload[0] & 2u) != 0, .frame = payload.subspan(1)};
}

ProMessage encode_receive_mode(ProReceiveMode mode) {
  const std::uint8_t payload[] = {static_cast<std::uint8_t>(mode)};
  return ProMessage(ProLabel::kReceiveMode, payload);
}

Result<ProReceiveMode> decode_receive_mode(std::span<const std::uint8_t> payload) {
  if (payload.size() != 1 || payload[0] > 1)
    return fail(ErrorCode::kProtocol, "receive mode (label 8): expected one byte, 0 or 1, got {} bytes",
                payload.size());
  return static_cast<ProReceiveMode>(payload[0]);
}

Result<int> apply_change_of_state(std::span<const std::uint8_t> payload, LineFrame& frame) {
  constexpr std::size_t kFieldSize = 5;
  constexpr std::size_t kValuesAt = 1 + kFieldSize;
  if (payload.size() < kValuesAt)
    return fail(ErrorCode::kProtocol, "change of state (label 9) of {} bytes: expected at least 6", payload.size());
  std::uint64_t changed = 0;
  for (std::size_t i = 0; i < kFieldSize; ++i) changed |= static_cast<std::uint64_t>(payload[1 + i]) << (8 * i);
  const std::span<const std::uint8_t> values = payload.subspan(kValuesAt);
  const auto changed_count = static_cast<std::size_t>(std::popcount(changed));
  if (changed_count != values.size())
    return fail(ErrorCode::kProtocol, "change of state (label 9) marks {} changes and carries {} values", changed_count,
                values.size());
  const std::size_t first = std::size_t{8} * payload[0];
  const std::size_t last = first + static_cast<std::size_t>(std::bit_width(changed));  // one past the last marked byte
  if (changed != 0 && last > frame.size())
    return fail(ErrorCode::kProtocol, "change of state (label 9) marks frame byte {}: expected at most 512", last - 1);
  for (std::size_t i = 0, used = 0; used < values.size(); ++i)
    if ((changed >> i & 1u) != 0) frame[first + i] = values[used++];
  return static_cast<int>(values.size());
}

ProMessage encode_get_serial() { return ProMessage(ProLabel::kSerialNumber, {}); }

Result<std::uint32_t> decode_serial(std::span<const std::uint8_t> payload) {
  if (payload.size() != 4)
    return fail(ErrorCode::kProtocol, "serial number (label 10) of {} bytes: expected 4", payload.size());
  std::uint32_t serial = 0;
  for (std::size_t i = 4; i-- > 0;) {
    const unsigned tens = payload[i] >> 4;
    const unsigned ones = payload[i] & 0x0Fu;
    if (tens > 9 || ones > 9)
      return fail(ErrorCode::kProtocol, "serial number (label 10) {:02x} {:02x} {:02x} {:02x}: expected decimal digits",
                  payload[3], payload[2], payload[1], payload[0]);
    serial = serial * 100 + tens * 10 + ones;
  }
  return serial;
}

}  // namespace footlight::drivers

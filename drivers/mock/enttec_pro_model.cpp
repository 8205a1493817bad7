#include "drivers/mock/enttec_pro_model.h"

#include <algorithm>

namespace footlight::drivers::mock {
namespace {

constexpr std::uint8_t kModemStatus = 0x01, kLineStatus = 0x60;  // of an idle FT232: transmitter empty
constexpr std::size_t kPacketSize = 64;
constexpr std::size_t kPayloadSizeMax = 600;

}  // namespace

Bytes EnttecProModel::device_descriptor() const {
  return {18, 1, 0x00, 0x02, 0, 0, 0, 8, 0x03, 0x04, 0x01, 0x60, 0x00, 0x06, 1, 2, 3, 1};  // 0403:6001, release 6.00
}

Bytes EnttecProModel::config_descriptor() const {
  return {9, 2, 32,   0, 1,           1,    0,    0xA0, 45,  // one interface, bus powered, 90 mA
          9, 4, 0,    0, 2,           0xFF, 0xFF, 0xFF, 2,   // vendor class, two endpoints
          7, 5, 0x81, 2, kPacketSize, 0,    0,    7,    5,  0x02, 2, kPacketSize, 0, 0};
}

void EnttecProModel::power_on() {
  ++power_on_count;
  awaits_ = Awaits::kStart;
  to_host_.clear();
  payload_.clear();
  receive_mode = 0;  // a fresh widget listens until it is told to send
  latency_ms = 16;
  line_.fill(0);
}

std::optional<Bytes> EnttecProModel::control(const SetupPacket& setup, std::span<const std::uint8_t>) {
  constexpr unsigned kTypeMask = 0x60, kStandard = 0x00, kVendor = 0x40;
  if ((setup.request_type & kTypeMask) == kStandard) return standard_request(*this, setup);
  if ((setup.request_type & kTypeMask) != kVendor) return std::nullopt;
  if ((setup.request_type & 0x80u) != 0) {
    switch (setup.request) {
      case 0x05: return Bytes{kModemStatus, kLineStatus};
      case 0x0A: return Bytes{latency_ms};
      case 0x90: return Bytes{0xFF, 0xFF};  // a word of a blank EEPROM
      default: return std::nullopt;
    }
  }
  switch (setup.request) {
    case 0x00:
      ++reset_count;
      if (setup.value != 1) to_host_.clear();
      return Bytes{};
    case 0x03: baud_value = setup.value; return Bytes{};
    case 0x04: line_data = setup.value; return Bytes{};
    case 0x09: latency_ms = static_cast<std::uint8_t>(setup.value); return Bytes{};
    case 0x01:
    case 0x02:
    case 0x06:
    case 0x07:
    case 0x0B: return Bytes{};  // modem lines, flow control, event and error characters, bit mode
    default: return std::nullopt;
  }
}

void EnttecProModel::data_out(std::uint8_t, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) take(byte);
}

void EnttecProModel::take(std::uint8_t byte) {
  const auto refuse = [this] {
    ++false_start_count;
    awaits_ = Awaits::kStart;
  };
  switch (awaits_) {
    case Awaits::kStart:
      if (byte == 0x7E)
        awaits_ = Awaits::kLabel;
      else
        ++false_start_count;
      break;
    case Awaits::kLabel:
      label_ = byte;
      awaits_ = Awaits::kLengthLow;
      break;
    case Awaits::kLengthLow:
      payload_size_ = byte;
      awaits_ = Awaits::kLengthHigh;
      break;
    case Awaits::kLengthHigh:
      payload_size_ |= static_cast<std::size_t>(byte) << 8;
      payload_.clear();
      if (payload_size_ > kPayloadSizeMax)
        refuse();
      else
        awaits_ = payload_size_ == 0 ? Awaits::kEnd : Awaits::kPayload;
      break;
    case Awaits::kPayload:
      payload_.push_back(byte);
      if (payload_.size() == payload_size_) awaits_ = Awaits::kEnd;
      break;
    case Awaits::kEnd:
      if (byte != 0xE7) return refuse();
      awaits_ = Awaits::kStart;
      obey(label_, payload_);
      break;
  }
}

void EnttecProModel::obey(std::uint8_t label, const Bytes& payload) {
  switch (label) {
    case 3: {
      const std::size_t wanted = payload.size() == 2 ? payload[0] | static_cast<std::size_t>(payload[1]) << 8 : 0;
      Bytes answer{static_cast<std::uint8_t>(firmware & 0xFF), static_cast<std::uint8_t>(firmware >> 8), break_units,
                   mab_units, rate_hz};
      for (std::size_t i = 0; i < std::min<std::size_t>(wanted, 508); ++i)
        answer.push_back(i < user_.size() ? user_[i] : std::uint8_t{0xFF});
      send(3, answer);
      break;
    }
    case 4:
      if (payload.size() < 5) break;
      break_units = payload[2];
      mab_units = payload[3];
      rate_hz = payload[4];
      user_.assign(payload.begin() + 5, payload.end());
      break;
    case 6:
      receive_mode = -1;
      frame = payload;
      ++frame_count;
      if (on_frame) on_frame(frame);
      break;
    case 8:
      if (payload.size() != 1) break;
      receive_mode = payload[0];
      line_.fill(0);
      break;
    case 10: {
      Bytes answer;
      for (int shift = 0; shift < 32; shift += 8)
        answer.push_back(static_cast<std::uint8_t>(widget_serial_bcd >> shift & 0xFF));
      send(10, answer);
      break;
    }
    default: break;  // the widget ignores what it does not know
  }
}

void EnttecProModel::send(std::uint8_t label, std::span<const std::uint8_t> payload) {
  if (!answers) return;
  const std::uint8_t head[] = {0x7E, label, static_cast<std::uint8_t>(payload.size() & 0xFF),
                               static_cast<std::uint8_t>(payload.size() >> 8)};
  const std::uint8_t end[] = {0xE7};
  say(head);
  say(payload);
  say(end);
}

void EnttecProModel::receive_line_frame(std::span<const std::uint8_t> line_frame, std::uint8_t status) {
  constexpr std::size_t kBlockSize = 8, kBlockSpan = 40;  // a message covers 40 bytes from a multiple of 8
  if (receive_mode == 0) {
    Bytes payload{status};
    payload.insert(payload.end(), line_frame.begin(), line_frame.end());
    send(5, payload);
  } else if (receive_mode == 1) {
    for (std::size_t i = 0; i < line_frame.size();) {
      if (line_frame[i] == line_[i]) {
        ++i;
        continue;
      }
      const std::size_t first = i / kBlockSize * kBlockSize;
      Bytes payload{static_cast<std::uint8_t>(first / kBlockSize), 0, 0, 0, 0, 0};
      for (; i < std::min(first + kBlockSpan, line_frame.size()); ++i) {
        if (line_frame[i] == line_[i]) continue;
        line_[i] = line_frame[i];
        payload[1 + (i - first) / 8] =
            static_cast<std::uint8_t>(payload[1 + (i - first) / 8] | 1u << ((i - first) % 8));
        payload.push_back(line_frame[i]);
      }
      send(9, payload);
    }
  }
}

Bytes EnttecProModel::data_in(std::uint8_t, std::size_t size_max) {
  Bytes transfer;
  // Every packet starts with the status; one that is not full ends the transfer.
  while (transfer.size() + 2 <= size_max) {
    const std::size_t count = std::min({kPacketSize - 2, to_host_.size(), size_max - transfer.size() - 2});
    transfer.push_back(kModemStatus);
    transfer.push_back(kLineStatus);
    transfer.insert(transfer.end(), to_host_.begin(), to_host_.begin() + static_cast<std::ptrdiff_t>(count));
    to_host_.erase(to_host_.begin(), to_host_.begin() + static_cast<std::ptrdiff_t>(count));
    if (count < kPacketSize - 2) break;
  }
  return transfer;
}

}  // namespace footlight::drivers::mock

#include "drivers/mock/serial_model.h"

#include <algorithm>

namespace footlight::drivers::mock {
namespace {

constexpr std::size_t kPacketSize = 64;
constexpr std::uint8_t kNotifyEndpoint = 0x83;  // of CDC-ACM; it never sends a notification

}  // namespace

Bytes SerialModel::device_descriptor() const {
  const auto low = [](std::uint16_t word) { return static_cast<std::uint8_t>(word & 0xFF); };
  const auto high = [](std::uint16_t word) { return static_cast<std::uint8_t>(word >> 8); };
  const std::uint8_t device_class = chip == SerialChip::kCdcAcm ? 2 : 0;
  return {18,
          1,
          0x00,
          0x02,
          device_class,
          0,
          0,
          8,
          low(vendor),
          high(vendor),
          low(product_id),
          high(product_id),
          low(release),
          high(release),
          1,
          2,
          3,
          1};
}

Bytes SerialModel::config_descriptor() const {
  // clang-format off
  if (chip == SerialChip::kCdcAcm)
    return {9, 2, 67, 0, 2, 1, 0, 0x80, 50,         // two interfaces
            9, 4, 0, 0, 1, 2, 2, 1, 0,              // control, one endpoint
            5, 0x24, 0x00, 0x10, 0x01,              // Linux refuses it without these four (CDC 1.2, section 5.2.3):
            5, 0x24, 0x01, 0x00, 0x01,              // its version, call management,
            4, 0x24, 0x02, 0x06,                    // capabilities: line coding and break,
            5, 0x24, 0x06, 0x00, 0x01,              // and that interface 0 controls interface 1
            7, 5, kNotifyEndpoint, 3, 8, 0, 10,
            9, 4, 1, 0, 2, 10, 0, 0, 0,             // data, two endpoints
            7, 5, 0x81, 2, kPacketSize, 0, 0, 7, 5, 0x02, 2, kPacketSize, 0, 0};
  // clang-format on
  return {9, 2, 32,   0, 1,           1,    0,    0xA0, 45,  // one interface, bus powered, 90 mA
          9, 4, 0,    0, 2,           0xFF, 0xFF, 0xFF, 2,   // vendor class, two endpoints
          7, 5, 0x81, 2, kPacketSize, 0,    0,    7,    5,  0x02, 2, kPacketSize, 0, 0};
}

void SerialModel::power_on() {
  UsbModel::power_on();
  ++power_on_count;
  to_host_.clear();
  latency_ms = 16;
}

std::optional<Bytes> SerialModel::control(const SetupPacket& setup, std::span<const std::uint8_t>) {
  constexpr unsigned kTypeMask = 0x60, kStandard = 0x00, kClass = 0x20, kVendor = 0x40;
  if ((setup.request_type & kTypeMask) == kStandard) return standard_request(*this, setup);
  if (chip == SerialChip::kCdcAcm) {
    const bool known = setup.request >= 0x20 && setup.request <= 0x23;  // line coding, control lines, break
    return (setup.request_type & kTypeMask) == kClass && known ? std::optional(Bytes{}) : std::nullopt;
  }
  if ((setup.request_type & kTypeMask) != kVendor) return std::nullopt;
  if ((setup.request_type & 0x80u) != 0) {
    switch (setup.request) {
      case 0x05: return Bytes{kModemStatus, line_status()};
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
    case 0x03:
      baud_value = setup.value;
      baud_index = setup.index;
      return Bytes{};
    case 0x04:
      line_data = setup.value;
      line_settings_changed();
      return Bytes{};
    case 0x09: latency_ms = static_cast<std::uint8_t>(setup.value); return Bytes{};
    case 0x01:
    case 0x02:
    case 0x06:
    case 0x07:
    case 0x0B: return Bytes{};  // modem lines, flow control, event and error characters, bit mode
    default: return std::nullopt;
  }
}

bool SerialModel::has_data(std::uint8_t endpoint) const {
  return !to_host_.empty() && (chip == SerialChip::kFtdi || endpoint != kNotifyEndpoint);
}

void SerialModel::data_out(std::uint8_t, std::span<const std::uint8_t> bytes) { take(bytes); }

Bytes SerialModel::read(std::size_t size_max) {
  const auto count = static_cast<std::ptrdiff_t>(std::min(size_max, to_host_.size()));
  Bytes bytes(to_host_.begin(), to_host_.begin() + count);
  to_host_.erase(to_host_.begin(), to_host_.begin() + count);
  return bytes;
}

Bytes SerialModel::data_in(std::uint8_t, std::size_t size_max) {
  if (chip == SerialChip::kCdcAcm) return read(size_max);
  Bytes transfer;
  // Every packet starts with the status; a packet that is not full ends the transfer.
  while (transfer.size() + 2 <= size_max) {
    const Bytes data = read(std::min(kPacketSize - 2, size_max - transfer.size() - 2));
    transfer.push_back(kModemStatus);
    transfer.push_back(line_status());
    transfer.insert(transfer.end(), data.begin(), data.end());
    if (data.size() < kPacketSize - 2) break;
  }
  return transfer;
}

}  // namespace footlight::drivers::mock

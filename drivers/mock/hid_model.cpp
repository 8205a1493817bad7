#include "drivers/mock/hid_model.h"

namespace footlight::drivers::mock {
namespace {

std::uint8_t low(unsigned value) { return static_cast<std::uint8_t>(value & 0xFF); }
std::uint8_t high(unsigned value) { return static_cast<std::uint8_t>(value >> 8); }

}  // namespace

Bytes HidModel::report_descriptor() const {
  const std::uint8_t size = shape().report_size;
  return {0x06, 0x00, 0xFF,                    // usage page: vendor-defined
          0x09, 0x01, 0xA1, 0x01,              // one application collection
          0x15, 0x00, 0x26, 0xFF, 0x00,        // values 0 to 255
          0x75, 0x08, 0x95, size,              // number of bytes
          0x09, 0x01, 0x81, 0x02,              // to the host
          0x95, size, 0x09, 0x01, 0x91, 0x02,  // to the device
          0xC0};
}

Bytes HidModel::device_descriptor() const {
  const Shape s = shape();
  return {18,
          1,
          low(s.low_speed ? 0x0110 : 0x0200),
          high(s.low_speed ? 0x0110 : 0x0200),
          0,
          0,
          0,
          8,
          low(s.vendor),
          high(s.vendor),
          low(s.product),
          high(s.product),
          0x00,
          0x01,
          1,
          2,
          static_cast<std::uint8_t>(serial.empty() ? 0 : 3),
          1};
}

Bytes HidModel::config_descriptor() const {
  const Shape s = shape();
  const auto descriptor_size = static_cast<std::uint8_t>(report_descriptor().size());
  return {9,
          2,
          41,
          0,
          1,
          1,
          0,
          0x80,
          50,  // one interface, bus powered
          9,
          4,
          0,
          0,
          2,
          3,
          0,
          0,
          0,  // HID, two endpoints
          9,
          0x21,
          0x11,
          1,
          0,
          1,
          0x22,
          descriptor_size,
          0,  // HID 1.11
          7,
          5,
          s.endpoint_in,
          3,
          s.report_size,
          0,
          interval_ms,  // interrupt
          7,
          5,
          s.endpoint_out,
          3,
          s.report_size,
          0,
          interval_ms};
}

void HidModel::power_on() {
  UsbModel::power_on();
  ++power_on_count;
  to_host_.clear();
}

std::optional<Bytes> HidModel::control(const SetupPacket& setup, std::span<const std::uint8_t> data) {
  constexpr unsigned kTypeMask = 0x60, kClass = 0x20;
  constexpr std::uint8_t kSetReport = 9, kSetIdle = 10, kSetProtocol = 11, kGetDescriptor = 6;
  constexpr unsigned kReportDescriptor = 0x22, kOutputReport = 2;
  if ((setup.request_type & kTypeMask) == 0) {
    if (setup.request == kGetDescriptor && setup.value >> 8 == kReportDescriptor) {
      Bytes bytes = report_descriptor();
      if (bytes.size() > setup.length) bytes.resize(setup.length);
      return bytes;
    }
    return standard_request(*this, setup);
  }
  if ((setup.request_type & kTypeMask) != kClass) return std::nullopt;
  if (setup.request == kSetReport && setup.value >> 8 == kOutputReport) {
    data_out(shape().endpoint_out, data);
    return Bytes{};
  }
  if (setup.request == kSetIdle || setup.request == kSetProtocol) return Bytes{};
  return std::nullopt;
}

Bytes HidModel::data_in(std::uint8_t, std::size_t size_max) {
  if (to_host_.empty()) return {};
  Bytes report = std::move(to_host_.front());
  to_host_.pop_front();
  if (report.size() > size_max) report.resize(size_max);
  return report;
}

}  // namespace footlight::drivers::mock

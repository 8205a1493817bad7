#include "tests/kernel/cp2112_model.h"

namespace footlight::testing {

using drivers::mock::Bytes;
using drivers::mock::SetupPacket;

namespace {

constexpr std::uint8_t kReportDescriptor[] = {
    0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01,              // a vendor-defined collection
    0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,              // of bytes
    0x85, 0x02, 0x95, 4,    0x09, 0x01, 0xB1, 0x02,        // report 2: feature
    0x85, 0x13, 0x95, 63,   0x09, 0x01, 0x81, 0x02,        // report 19: to the host
    0x85, 0x10, 0x95, 63,   0x09, 0x01, 0x91, 0x02, 0xC0,  // report 16: to the device
};
constexpr int kPinSettings = 2, kGetPins = 3, kSetPins = 4, kVersion = 5, kSmbusSettings = 6;  // AN495

}  // namespace

Bytes Cp2112Model::device_descriptor() const {
  return {18, 1, 0x00, 0x02, 0, 0, 0, 64, 0xC4, 0x10, 0x90, 0xEA, 0x00, 0x01, 1, 2, 3, 1};  // 10C4:EA90
}

Bytes Cp2112Model::config_descriptor() const {
  return {9,  2,    41,   0,  1,  1, 0,    0x80,
          50,  // one interface
          9,  4,    0,    0,  2,  3, 0,    0,
          0,  // HID, two endpoints
          9,  0x21, 0x01, 1,  0,  1, 0x22, sizeof kReportDescriptor,
          0,  //
          7,  5,    0x81, 3,  64, 0, 1,    7,
          5,  0x01, 3,    64, 0,  1};
}

void Cp2112Model::power_on() {
  UsbModel::power_on();
  outputs_ = latch_ = 0;
}

std::optional<Bytes> Cp2112Model::control(const SetupPacket& setup, std::span<const std::uint8_t> data) {
  constexpr std::uint8_t kGetDescriptor = 6, kGetReport = 1, kSetReport = 9, kSetIdle = 10, kSetProtocol = 11;
  const auto clipped = [&](Bytes bytes) {
    if (bytes.size() > setup.length) bytes.resize(setup.length);
    return bytes;
  };
  const int report = setup.value & 0xFF;
  if ((setup.request_type & 0x60) == 0) {
    if (setup.request == kGetDescriptor && setup.value >> 8 == 0x22)
      return clipped(Bytes(std::begin(kReportDescriptor), std::end(kReportDescriptor)));
    return standard_request(*this, setup);
  }
  switch (setup.request) {
    case kGetReport: {
      const auto bytes = feature(report);
      return bytes ? std::optional(clipped(*bytes)) : std::nullopt;
    }
    case kSetReport:
      if (report == kPinSettings && data.size() >= 2) outputs_ = data[1];
      if (report == kSetPins && data.size() >= 3)
        latch_ = static_cast<std::uint8_t>((latch_ & ~data[2]) | (data[1] & data[2]));
      return Bytes{};
    case kSetIdle:
    case kSetProtocol: return Bytes{};
    default: return std::nullopt;
  }
}

std::optional<Bytes> Cp2112Model::feature(int report) {
  switch (report) {
    case kPinSettings: return Bytes{2, outputs_, 0, 0, 0};
    case kGetPins: ++read_count; return Bytes{3, static_cast<std::uint8_t>((pins & ~outputs_) | (latch_ & outputs_))};
    case kVersion: return Bytes{5, 0x0C, 0x02};
    case kSmbusSettings: return Bytes{6, 0, 1, 0x86, 0xA0, 2, 0, 0, 0, 0, 0, 0, 0, 0};
    default: return std::nullopt;
  }
}

}  // namespace footlight::testing

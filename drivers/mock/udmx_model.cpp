#include "drivers/mock/udmx_model.h"

#include <algorithm>

namespace footlight::drivers::mock {

Bytes UdmxModel::device_descriptor() const {
  const auto low = [](unsigned value) { return static_cast<std::uint8_t>(value & 0xFF); };
  const auto high = [](unsigned value) { return static_cast<std::uint8_t>(value >> 8); };
  return {18,
          1,
          0x10,
          0x01,
          0xFF,
          0,
          0,
          8,
          low(usb_vendor),
          high(usb_vendor),
          low(usb_product),
          high(usb_product),
          0x02,
          0x01,
          1,
          2,
          static_cast<std::uint8_t>(serial.empty() ? 0 : 3),
          1};
}

Bytes UdmxModel::config_descriptor() const {
  return {9, 2, 18, 0, 1, 1,    0, 0x80, 50,  // one interface, bus powered
          9, 4, 0,  0, 0, 0xFF, 0, 0,    0};  // vendor class, no endpoint but 0
}

void UdmxModel::power_on() {
  UsbModel::power_on();
  ++power_on_count;
  memory.fill(0);
  line_slot_count = 0;
}

std::optional<Bytes> UdmxModel::control(const SetupPacket& setup, std::span<const std::uint8_t> data) {
  constexpr unsigned kTypeMask = 0x60, kStandard = 0x00, kVendor = 0x40;
  constexpr std::uint8_t kBadChannel = 1, kBadValue = 2;
  if ((setup.request_type & kTypeMask) == kStandard) return standard_request(*this, setup);
  if ((setup.request_type & kTypeMask) != kVendor) return std::nullopt;
  packet_count += 2 + (setup.length + 7u) / 8u;
  if (stall_count > 0) {
    --stall_count;
    return std::nullopt;
  }
  const auto refuse = [&](std::uint8_t why) {
    ++broken_count;
    return Bytes{why};
  };
  switch (setup.request) {
    case 1:
      if (setup.index > 511) return refuse(kBadChannel);
      if (setup.value > 255) return refuse(kBadValue);
      memory[setup.index] = static_cast<std::uint8_t>(setup.value);
      line_slot_count = std::max(line_slot_count, setup.index + 1);
      ++single_count;
      ++slot_count;
      break;
    case 2: {
      const unsigned end = setup.index + setup.value;
      if (setup.value > setup.length || data.size() < setup.length) return refuse(kBadValue);
      if (setup.index > 511 || end > 512) return refuse(kBadChannel);
      std::copy_n(data.begin(), setup.value, memory.begin() + setup.index);
      line_slot_count = std::max(line_slot_count, static_cast<int>(end));
      ++range_count;
      slot_count += setup.value;
      break;
    }
    default:
      ++broken_count;  // 0xF8 would start its boot loader
      return Bytes{};
  }
  Bytes frame{0};
  frame.insert(frame.end(), memory.begin(), memory.begin() + line_slot_count);
  show(0, std::move(frame));
  return Bytes{};
}

}  // namespace footlight::drivers::mock

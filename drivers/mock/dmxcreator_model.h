// A model of a DMXCreator 512 Basic: receives an announcement, then one or two halves of the universe. They appear on
// line 0 when all announced bytes have arrived, and the device repeats them itself.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

class DmxCreatorModel final : public UsbModel {
 public:
  DmxCreatorModel() {
    manufacturer = "DMXCreator";
    product = "512 Basic";
    serial = "0815";
  }
  // --- Observed; read only.
  std::array<std::uint8_t, 512> memory{};  // what it repeats on its line
  std::uint64_t broken_count = 0;          // invalid announcements, and halves without an announcement
  std::uint64_t cut_count = 0;             // snapshots cut short by another announcement
  int power_on_count = 0;

  Bytes device_descriptor() const override;
  Bytes config_descriptor() const override;
  void power_on() override;
  std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) override;
  void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;
  bool has_data(std::uint8_t) const override { return false; }
  Bytes data_in(std::uint8_t, std::size_t) override { return {}; }

 private:
  Bytes announcement_, levels_;
  std::size_t awaited_ = 0;  // bytes of levels still expected
};

}  // namespace footlight::drivers::mock

// A model of a Silicon Labs CP2112, with the features that the kernel's hid-cp2112 needs to make a GPIO chip of eight
// lines: the reports of AN495 for pins. It has no interrupt; the kernel reads the pins every 40 ms while an edge is
// awaited.
#pragma once

#include <cstdint>

#include "drivers/mock/usb_model.h"

namespace footlight::testing {

class Cp2112Model final : public drivers::mock::UsbModel {
 public:
  Cp2112Model() {
    manufacturer = "Silicon Laboratories";
    product = "CP2112 HID USB-to-SMBus Bridge";
    serial = "0001";
  }
  std::uint8_t pins = 0;         // levels at the inputs, one bit per line
  std::uint64_t read_count = 0;  // how often the host has read them

  drivers::mock::Bytes device_descriptor() const override;
  drivers::mock::Bytes config_descriptor() const override;
  void power_on() override;
  std::optional<drivers::mock::Bytes> control(const drivers::mock::SetupPacket& setup,
                                              std::span<const std::uint8_t> data) override;
  void data_out(std::uint8_t, std::span<const std::uint8_t>) override {}
  bool has_data(std::uint8_t) const override { return false; }
  drivers::mock::Bytes data_in(std::uint8_t, std::size_t) override { return {}; }

 private:
  [[nodiscard]] std::optional<drivers::mock::Bytes> feature(int report);

  std::uint8_t outputs_ = 0;  // lines that are outputs, one bit each
  std::uint8_t latch_ = 0;    // their levels
};

}  // namespace footlight::testing

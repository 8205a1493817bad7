// A model of a Eurolite USB-DMX512 PRO: one bulk endpoint that receives one kind of message; it never answers.
#pragma once

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

class EuroliteModel final : public UsbModel {
 public:
  EuroliteModel() {
    manufacturer = "Eurolite";
    product = "USB-DMX512 PRO";
    serial = "000000123456";
  }

  std::uint64_t stray_byte_count = 0;  // outside of a message; read only

  Bytes device_descriptor() const override;
  Bytes config_descriptor() const override;
  void power_on() override {
    UsbModel::power_on();
    held_.clear();
  }
  std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) override;
  void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;
  bool has_data(std::uint8_t) const override { return false; }
  Bytes data_in(std::uint8_t, std::size_t) override { return {}; }

 private:
  Bytes held_;  // of an incomplete message
};

}  // namespace footlight::drivers::mock

// A model of a DMX4ALL NanoDMX, with its own parser.
#pragma once

#include <string>

#include "drivers/mock/serial_model.h"

namespace footlight::drivers::mock {

class Dmx4allModel final : public SerialModel {
 public:
  Dmx4allModel() {
    manufacturer = "DMX4ALL";
    product = "NanoDMX Interface";
    serial = "NANO0042";
    chip = SerialChip::kCdcAcm;
    vendor = 0x03EB;
    product_id = 0x2018;
    release = 0x0100;
  }

  bool answers = true;  // --- Settings.
  int slot_count = 0;   // --- Observed; read only. From "N", which gives the last slot.
  std::uint64_t command_count = 0;
  std::uint64_t refused_count = 0;  // bytes that start no command

  void power_on() override;
  void take(std::span<const std::uint8_t> bytes) override;

 private:
  void take_byte(std::uint8_t byte);
  void done();
  Bytes held_;
  Bytes frame_;
};

}  // namespace footlight::drivers::mock

// A model of a Vince USB-DMX512 converter, with its own parser.
#pragma once

#include "drivers/mock/serial_model.h"

namespace footlight::drivers::mock {

class VinceModel final : public SerialModel {
 public:
  VinceModel() {
    manufacturer = "FTDI";
    product = "USB-DMX512 CONVERTER";
    serial = "VINCE001";
  }

  // --- Settings.
  std::uint8_t status = 0;  // of its replies
  bool answers = true;

  // --- Observed; read only.
  bool started = false;
  std::uint64_t broken_count = 0;  // messages without their end

  void power_on() override;
  void take(std::span<const std::uint8_t> bytes) override;

 private:
  void obey();
  Bytes held_;
};

}  // namespace footlight::drivers::mock

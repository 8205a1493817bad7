// A Vince USB-DMX512 converter from its host's side, with a parser of its own.
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

  // --- What it is.
  std::uint8_t status = 0;  // of its replies
  bool answers = true;

  // --- What it saw; only to be read.
  bool started = false;
  std::uint64_t broken_count = 0;  // messages without their end

  void power_on() override;
  void take(std::span<const std::uint8_t> bytes) override;

 private:
  void obey();
  Bytes held_;
};

}  // namespace footlight::drivers::mock

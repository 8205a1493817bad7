// A model of a DMXControl Projects Nodle U1 and its relatives.
//
// Line 0 is its output and line 1 its input; both work at the same time. Each received block appears on the output at
// once, and the device repeats its levels itself.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/mock/hid_model.h"

namespace footlight::drivers::mock {

class NodleModel final : public HidModel {
 public:
  NodleModel() {
    manufacturer = "DMXControl Projects e.V.";
    product = "Nodle U1";
    serial = "A0042";
    interval_ms = 1;
  }
  // --- Settings; may be changed before it is plugged in.
  std::uint16_t usb_vendor = 0x16D0, usb_product = 0x0830;

  // --- Observed; read only.
  int mode = 0;                            // of the last mode report: 1 through, 2 output, 4 input
  std::array<std::uint8_t, 512> memory{};  // levels from the host
  std::uint64_t block_count = 0, mode_count = 0;
  std::uint64_t broken_count = 0;  // reports of the wrong size or number

  // Reports the changed blocks, all 16 after a mode report.
  void receive_line_frame(int line, std::span<const std::uint8_t> line_frame, std::uint8_t status = 0) override;
  bool listens(int line) const override { return line == 1 && (mode & 4) != 0; }
  void power_on() override;
  void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;

 protected:
  Shape shape() const override { return {usb_vendor, usb_product, false, 0x02, 0x81, 33}; }

 private:
  std::array<std::uint8_t, 512> received_{};
  bool received_any_ = false;
};

}  // namespace footlight::drivers::mock

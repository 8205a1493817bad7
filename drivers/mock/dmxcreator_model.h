// A DMXCreator 512 Basic, modelled from its host's side: an announcement, then one or two halves of the universe. They
// show on line 0 when all that was announced has come, and it repeats them by itself.
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
  // --- What it saw; only to be read.
  std::array<std::uint8_t, 512> memory{};  // what it repeats on its line
  std::uint64_t broken_count = 0;          // announcements that say nothing, halves that nobody announced
  std::uint64_t cut_count = 0;             // looks that another announcement ended
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
  std::size_t awaited_ = 0;  // bytes of levels
};

}  // namespace footlight::drivers::mock

// A model of an Anyma uDMX, after its firmware (uDMX.c): vendor requests on endpoint 0 only. Levels appear on line 0 at
// once, and the device repeats them itself.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

class UdmxModel final : public UsbModel {
 public:
  UdmxModel() {
    manufacturer = "www.anyma.ch";
    product = "uDMX";
  }
  // --- Settings; may be changed before it is plugged in.
  std::uint16_t usb_vendor = 0x16C0, usb_product = 0x05DC;
  int stall_count = 0;  // number of next vendor requests to refuse, as real devices sometimes do

  // --- Observed; read only.
  std::array<std::uint8_t, 512> memory{};  // levels that it repeats on its line
  int line_slot_count = 0;                 // it sends up to the highest slot that was ever set
  std::uint64_t range_count = 0, single_count = 0, slot_count = 0;
  std::uint64_t broken_count = 0;  // requests that its firmware answers with an error
  std::uint64_t packet_count = 0;  // of low speed: set-up, 8 bytes of data each, status
  int power_on_count = 0;

  Bytes device_descriptor() const override;
  Bytes config_descriptor() const override;
  void power_on() override;
  std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) override;
  void data_out(std::uint8_t, std::span<const std::uint8_t>) override {}
  bool has_data(std::uint8_t) const override { return false; }
  Bytes data_in(std::uint8_t, std::size_t) override { return {}; }
};

}  // namespace footlight::drivers::mock

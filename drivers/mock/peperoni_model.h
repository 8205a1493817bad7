// A model of a Peperoni Rodin or USBDMX21: one class for its three generations of firmware.
#pragma once

#include <cstdint>
#include <deque>

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

class PeperoniModel final : public UsbModel {
 public:
  PeperoniModel() {
    manufacturer = "Peperoni-Light";
    product = "Rodin1";
    serial = "1234";
  }
  // --- Settings; may be changed before it is plugged in.
  std::uint16_t usb_product = 0x0002;  // 0x0004: USBDMX21, two universes
  std::uint16_t release = 0x0504;      // of its firmware
  std::uint8_t status = 0;             // of its next answers
  bool answers = true;                 // false: it accepts snapshots without an answer

  // --- Observed; read only.
  std::uint64_t broken_count = 0;                            // messages that its firmware would reject
  int start_code = -1;                                       // of its transmitter, as set; -1: not yet
  std::uint8_t break_code = 0, mark_code = 0, settings = 0;  // of the newest snapshot
  int power_on_count = 0;

  // Queues one transfer.
  void send_to_host(std::span<const std::uint8_t> bytes) override { to_host_.emplace_back(bytes.begin(), bytes.end()); }
  Bytes device_descriptor() const override;
  Bytes config_descriptor() const override;
  void power_on() override;
  std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) override;
  void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;
  bool has_data(std::uint8_t) const override { return !to_host_.empty(); }
  Bytes data_in(std::uint8_t endpoint, std::size_t size_max) override;

 private:
  void show_levels(int universe, std::span<const std::uint8_t> levels);
  void take_message();

  Bytes coming_;  // a message may arrive in several transfers
  std::deque<Bytes> to_host_;
};

}  // namespace footlight::drivers::mock

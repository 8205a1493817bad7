// A device that is a stream of bytes both ways, behind an FTDI chip or as a serial device of the USB communication
// class (CDC-ACM): the chip, without the processor behind it.
//
// The same object can stand at the far end of a tty: then take() is called with what the host writes, and hear() gives
// what it reads.
#pragma once

#include <cstdint>
#include <deque>

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

enum class SerialChip : std::uint8_t { kFtdi, kCdcAcm };

class SerialModel : public UsbModel {
 public:
  // --- What it is.
  SerialChip chip = SerialChip::kFtdi;
  std::uint16_t vendor = 0x0403, product_id = 0x6001, release = 0x0600;  // of an FT232R

  // --- What it saw; only to be read.
  int power_on_count = 0, reset_count = 0;
  std::uint16_t baud_value = 0xFFFF, baud_index = 0xFFFF, line_data = 0xFFFF;
  std::uint8_t latency_ms = 16;

  // Bytes of the host, as they come out of the chip.
  virtual void take(std::span<const std::uint8_t> bytes) = 0;
  // Takes what the processor has said: at most size_max bytes.
  Bytes hear(std::size_t size_max);
  [[nodiscard]] bool has_said() const { return !to_host_.empty(); }

  // --- UsbModel
  void say(std::span<const std::uint8_t> bytes) override {
    to_host_.insert(to_host_.end(), bytes.begin(), bytes.end());
  }
  Bytes device_descriptor() const override;
  Bytes config_descriptor() const override;
  void power_on() override;
  std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) override;
  void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;
  bool has_data(std::uint8_t endpoint) const override;
  Bytes data_in(std::uint8_t endpoint, std::size_t size_max) override;
  std::size_t in_overhead() const override { return chip == SerialChip::kFtdi ? 2 : 0; }
  int in_latency_ms(std::uint8_t) const override { return chip == SerialChip::kFtdi ? latency_ms : -1; }

 protected:
  // The chip's second status byte as it is now, and whether the line is held low.
  [[nodiscard]] virtual std::uint8_t line_status() const { return 0x60; }  // transmitter empty
  virtual void line_settings_changed() {}
  [[nodiscard]] bool line_held_low() const { return (line_data & 0x4000u) != 0 && line_data != 0xFFFF; }

 private:
  std::deque<std::uint8_t> to_host_;
};

}  // namespace footlight::drivers::mock

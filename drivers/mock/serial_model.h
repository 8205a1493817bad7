// The USB chip of a device that is a byte stream in both directions: an FTDI chip or a serial device of the USB
// communication class (CDC-ACM). Without the processor behind the chip.
//
// The same object can also be the far end of a tty: then take() gets what the host writes, and read() returns what the
// host reads.
#pragma once

#include <cstdint>
#include <deque>

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

enum class SerialChip : std::uint8_t { kFtdi, kCdcAcm };

class SerialModel : public UsbModel {
 public:
  // --- Settings.
  SerialChip chip = SerialChip::kFtdi;
  std::uint16_t vendor = 0x0403, product_id = 0x6001, release = 0x0600;  // of an FT232R

  // --- Observed; read only.
  int power_on_count = 0, reset_count = 0;
  std::uint16_t baud_value = 0xFFFF, baud_index = 0xFFFF, line_data = 0xFFFF;
  std::uint8_t latency_ms = 16;

  // Receives bytes from the host, as they leave the chip.
  virtual void take(std::span<const std::uint8_t> bytes) = 0;
  // Removes and returns at most size_max bytes that the processor has sent.
  Bytes read(std::size_t size_max);
  [[nodiscard]] bool has_output() const { return !to_host_.empty(); }

  // --- UsbModel
  void send_to_host(std::span<const std::uint8_t> bytes) override {
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
  static constexpr std::uint8_t kModemStatus = 0x01;  // the chip's first status byte

  // The chip's second status byte, current value.
  [[nodiscard]] virtual std::uint8_t line_status() const { return 0x60; }  // transmitter empty
  virtual void line_settings_changed() {}
  [[nodiscard]] bool line_held_low() const { return (line_data & 0x4000u) != 0 && line_data != 0xFFFF; }

 private:
  std::deque<std::uint8_t> to_host_;
};

}  // namespace footlight::drivers::mock

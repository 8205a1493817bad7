// An ENTTEC DMX USB Pro, modelled from its host's side: the FTDI chip on the bus and the widget's processor behind it.
//
// It parses with code of its own, byte by byte as the widget's firmware would, and not with the driver's parser: a
// mistake in one does not hide the same mistake in the other.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

class EnttecProModel final : public UsbModel {
 public:
  // --- What it is; free to change before it is plugged in.
  std::string manufacturer = "ENTTEC";
  std::string product = "DMX USB PRO";
  std::string serial = "EN172589";               // of the USB descriptor
  std::uint32_t widget_serial_bcd = 0x02172589;  // label 10
  std::uint16_t firmware = 0x0144;
  std::uint8_t break_units = 9, mab_units = 1, rate_hz = 40;
  bool answers = true;  // false: takes everything and says nothing

  // --- What it saw; only to be read.
  Bytes frame;                                       // payload of the newest label 6, start code first
  std::uint64_t frame_count = 0;                     // label 6 messages
  std::function<void(const Bytes& frame)> on_frame;  // called for each; empty: none
  std::uint64_t false_start_count = 0;               // bytes that began no message
  int receive_mode = -1;                             // of label 8; -1: it sends
  int power_on_count = 0, reset_count = 0;
  std::uint16_t baud_value = 0xFFFF, line_data = 0xFFFF;
  std::uint8_t latency_ms = 16;

  // --- What happens to it.
  // A frame on its DMX input, start code first. Ignored while it sends, as the hardware does: line and transmitter are
  // one.
  void receive_line_frame(std::span<const std::uint8_t> line_frame, std::uint8_t status = 0);
  // Bytes towards the host as they are: noise, or messages that the real widget would not send.
  void say(std::span<const std::uint8_t> bytes) { to_host_.insert(to_host_.end(), bytes.begin(), bytes.end()); }

  // --- UsbModel
  Bytes device_descriptor() const override;
  Bytes config_descriptor() const override;
  std::vector<std::string> strings() const override { return {manufacturer, product, serial}; }
  void power_on() override;
  std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) override;
  void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;
  bool has_data(std::uint8_t) const override { return !to_host_.empty(); }
  Bytes data_in(std::uint8_t endpoint, std::size_t size_max) override;
  int in_latency_ms(std::uint8_t) const override { return latency_ms; }

 private:
  enum class Awaits { kStart, kLabel, kLengthLow, kLengthHigh, kPayload, kEnd };
  void take(std::uint8_t byte);
  void obey(std::uint8_t label, const Bytes& payload);
  void send(std::uint8_t label, std::span<const std::uint8_t> payload);

  Awaits awaits_ = Awaits::kStart;
  std::uint8_t label_ = 0;
  std::size_t payload_size_ = 0;
  Bytes payload_;
  Bytes user_;  // label 4's user configuration
  std::deque<std::uint8_t> to_host_;
  std::array<std::uint8_t, 513> line_{};  // last frame of the line, for on-change mode
};

}  // namespace footlight::drivers::mock

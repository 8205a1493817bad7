// A model of a bare FT232R with a DMX line: its transmit buffer and shift register over time, and a receiver at the end
// of the line that is as strict as a fixture. The receiver counts frames cut by a break, and breaks and marks that are
// too short.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "drivers/mock/serial_model.h"

namespace footlight::drivers::mock {

class OpenDmxModel final : public SerialModel {
 public:
  OpenDmxModel() {
    manufacturer = "FTDI";
    product = "FT232R USB UART";
    serial = "A50285BI";
  }

  // --- Settings.
  DurationNs slot_ns = 44 * kNsPerUs;
  std::size_t fifo_size = 128;
  // What the receiver accepts: E1.11's minimum for receivers.
  DurationNs break_min_ns = 88 * kNsPerUs;
  DurationNs mark_min_ns = 8 * kNsPerUs;

  // --- Observed by the receiver; read only.
  struct Timing {
    TimeNs begin_ns = 0;  // of the break
    DurationNs break_ns = 0;
    DurationNs mark_ns = 0;
    std::size_t size = 0;  // bytes, start code included
    bool cut = false;      // the next break started before the transmitter was empty
  };
  std::vector<Timing> timings;  // of every complete frame
  std::uint64_t cut_count = 0;
  std::uint64_t bad_break_count = 0;  // too short, or followed by too short a mark

  // --- Input: bytes on its receiving side.
  void receive_break();
  void receive_byte(std::uint8_t byte, bool framing_error = false);
  void receive_overrun();  // before the next byte

  // --- UsbModel
  void receive_line_frame(int line, std::span<const std::uint8_t> line_frame, std::uint8_t status = 0) override;
  bool listens(int line) const override { return line == 0 && !has_sent_; }
  void power_on() override;
  TimeNs pass_time(TimeNs now_ns) override;
  std::size_t room(std::uint8_t endpoint) const override;
  void take(std::span<const std::uint8_t> bytes) override;
  bool has_data(std::uint8_t) const override { return !symbols_.empty(); }
  Bytes data_in(std::uint8_t endpoint, std::size_t size_max) override;

 protected:
  std::uint8_t line_status() const override;
  void line_settings_changed() override;

 private:
  struct Symbol {
    std::uint8_t value;
    std::uint8_t flags;  // of the second status byte
  };
  [[nodiscard]] bool transmitter_empty() const { return fifo_.empty() && now_ns_ >= shift_end_ns_; }
  void end_frame(bool cut);

  TimeNs now_ns_ = 0;
  std::deque<std::uint8_t> fifo_;
  TimeNs shift_end_ns_ = 0;  // when the byte in the shift register is out
  bool low_ = false;         // a break is active
  TimeNs low_ns_ = 0, high_ns_ = 0;
  bool in_frame_ = false;  // after a break: bytes belong to a frame
  Timing timing_;
  Bytes frame_;
  bool has_sent_ = false;
  std::deque<Symbol> symbols_;  // received, to be read by the host
};

}  // namespace footlight::drivers::mock

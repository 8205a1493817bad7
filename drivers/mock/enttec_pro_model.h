// A model of an ENTTEC DMX USB Pro: the USB chip and the widget's processor. With other settings: its Mk2 with a second
// port, and DMXking's relatives.
//
// It has its own parser, byte by byte like the widget's firmware, and does not use the driver's: a mistake in one does
// not hide the same mistake in the other.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/driver.h"
#include "drivers/mock/rdm_line_model.h"
#include "drivers/mock/serial_model.h"

namespace footlight::drivers::mock {

class EnttecProModel final : public SerialModel {
 public:
  EnttecProModel() {
    manufacturer = "ENTTEC";
    product = "DMX USB PRO";
    serial = "EN172589";
  }

  // --- Settings; may be changed before it is plugged in.
  std::uint32_t widget_serial_bcd = 0x02172589;  // label 10
  std::uint16_t firmware = 0x0144;
  std::uint8_t break_units = 9, mab_units = 1, rate_hz = 40;
  bool answers = true;                    // false: accepts everything and never answers
  std::optional<SecondPort> second_port;  // answers these labels after the key was received
  std::optional<std::uint16_t> esta_id;   // label 77; none: ignores it
  std::uint16_t device_id = 0;            // label 78, if it has an ESTA id
  std::uint8_t port_count = 0;            // label 99; 0: ignores it
  std::optional<RdmLineModel> rdm_line;   // on port 1; none: ignores labels 7 and 11, as DMX firmware does
  bool reports_rdm_timeout = true;        // label 12

  // --- Observed; read only.
  std::uint64_t byte_count = 0;              // of everything received
  std::uint64_t false_start_count = 0;       // bytes that start no message
  std::array<int, 2> receive_modes{-1, -1};  // of label 8, per line; -1: it transmits
  bool second_port_open = false;             // the key was received
  std::uint8_t newest_label = 0;
  std::uint64_t rdm_request_count = 0;  // labels 7 and 11

  // --- UsbModel
  void receive_line_frame(int line, std::span<const std::uint8_t> line_frame, std::uint8_t status = 0) override;
  bool listens(int line) const override;
  void power_on() override;
  void take(std::span<const std::uint8_t> bytes) override;

 private:
  enum class Awaits { kStart, kLabel, kLengthLow, kLengthHigh, kPayload, kEnd };
  void take_byte(std::uint8_t byte);
  void obey(std::uint8_t label, const Bytes& payload);
  void send(std::uint8_t label, std::span<const std::uint8_t> payload);

  Awaits awaits_ = Awaits::kStart;
  std::uint8_t label_ = 0;
  std::size_t payload_size_ = 0;
  Bytes payload_;
  Bytes user_;                                           // label 4's user configuration
  std::array<std::array<std::uint8_t, 513>, 2> seen_{};  // last frame of each line, for on-change mode
};

}  // namespace footlight::drivers::mock

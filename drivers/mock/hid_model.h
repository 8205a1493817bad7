// A model of a USB device of the HID class.
//
// Reports have no number of their own (no Report ID in the report descriptor), so each transfer is one report.
#pragma once

#include <deque>

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

class HidModel : public UsbModel {
 public:
  // --- Settings; may be changed before it is plugged in.
  std::uint8_t interval_ms = 10;  // the host's polling interval; one report each time

  // The descriptor of its reports and their sizes in bytes (HID 1.11, section 6.2.2).
  [[nodiscard]] Bytes report_descriptor() const;

  // --- UsbModel
  // Queues one report; the content is not checked.
  void send_to_host(std::span<const std::uint8_t> report) override {
    to_host_.emplace_back(report.begin(), report.end());
  }
  Bytes device_descriptor() const override;
  Bytes config_descriptor() const override;
  void power_on() override;
  std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) override;
  bool has_data(std::uint8_t) const override { return !to_host_.empty(); }
  Bytes data_in(std::uint8_t endpoint, std::size_t size_max) override;

  int power_on_count = 0;  // read only

 protected:
  struct Shape {
    std::uint16_t vendor = 0, product = 0;
    bool low_speed = false;
    std::uint8_t endpoint_out = 0, endpoint_in = 0;
    std::uint8_t report_size = 0;  // both ways
  };
  [[nodiscard]] virtual Shape shape() const = 0;

 private:
  std::deque<Bytes> to_host_;
};

}  // namespace footlight::drivers::mock

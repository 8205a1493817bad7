// A USB device as its host sees it, without a bus: what a front end needs in order to play one.
//
// A model has no thread, no clock and no lock, so the same class stands behind the in-process transport
// (drivers/mock/mock_usb.h) and behind the emulated usbfs of the tests (tests/support/usb_fs.h). Its owner calls it
// from one thread at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace footlight::drivers::mock {

using Bytes = std::vector<std::uint8_t>;

// The eight bytes in front of every control transfer (USB 2.0, section 9.3).
struct SetupPacket {
  std::uint8_t request_type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
};

class UsbModel {
 public:
  virtual ~UsbModel() = default;
  [[nodiscard]] virtual Bytes device_descriptor() const = 0;  // 18 bytes
  [[nodiscard]] virtual Bytes config_descriptor() const = 0;  // with its interfaces and endpoints
  // Manufacturer, product, serial number; empty ones are not reported.
  [[nodiscard]] virtual std::vector<std::string> strings() const = 0;
  // Power comes: volatile state is as new, what the device stores stays.
  virtual void power_on() = 0;
  // nullopt: the device refuses (STALL). Data of the answer for requests to the host, else empty.
  virtual std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) = 0;
  virtual void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) = 0;
  [[nodiscard]] virtual bool has_data(std::uint8_t endpoint) const = 0;
  // What one IN transfer of at most size_max bytes brings now.
  virtual Bytes data_in(std::uint8_t endpoint, std::size_t size_max) = 0;
  // After how many ms an IN transfer is answered although there is no data; negative: never.
  [[nodiscard]] virtual int in_latency_ms(std::uint8_t /*endpoint*/) const { return -1; }
};

// The requests that every device answers (USB 2.0, section 9.4), from the model's descriptors.
std::optional<Bytes> standard_request(const UsbModel& model, const SetupPacket& setup);

}  // namespace footlight::drivers::mock

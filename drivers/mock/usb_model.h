// A model of a USB device, without a bus: what a front end needs to simulate one.
//
// A model has no thread, no clock and no lock. So the same class works behind the in-process transport
// (drivers/mock/mock_usb.h) and behind the emulated usbfs of the tests (tests/support/usb_fs.h). Its owner calls it
// from one thread at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/core/clock.h"

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

  // --- Settings; may be changed before it is plugged in.
  std::string manufacturer, product;
  std::string serial;  // of the USB descriptor; empty: none

  // --- Frames sent on its DMX connectors; read only. A frame starts with its start code.
  struct Line {
    Bytes frame;                    // the newest since power-on; empty: none
    std::uint64_t frame_count = 0;  // since construction
  };
  [[nodiscard]] const Line& line(int number) const;            // from 0; without frames if none was sent
  std::function<void(int line, const Bytes& frame)> on_frame;  // called for each; empty: none

  // A frame on one of its DMX inputs, start code first. Dropped if the line does not exist or is no input now.
  virtual void receive_line_frame(int line, std::span<const std::uint8_t> line_frame, std::uint8_t status = 0);
  // True if a frame on this line would be received.
  [[nodiscard]] virtual bool listens(int /*line*/) const { return false; }
  // Queues bytes for the host as they are: noise, or answers that the real device would not send.
  virtual void send_to_host(std::span<const std::uint8_t> bytes);

  // --- The host's view.
  [[nodiscard]] virtual Bytes device_descriptor() const = 0;  // 18 bytes
  [[nodiscard]] virtual Bytes config_descriptor() const = 0;  // with its interfaces and endpoints
  // Manufacturer, product, serial number; empty ones are not reported.
  [[nodiscard]] std::vector<std::string> strings() const { return {manufacturer, product, serial}; }
  // Power-on: resets volatile state, keeps what the device stores. Overrides must call this one, which clears the
  // lines.
  virtual void power_on();
  // nullopt: the device refuses (STALL). The answer's data for requests to the host, else empty.
  virtual std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) = 0;
  virtual void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) = 0;
  [[nodiscard]] virtual bool has_data(std::uint8_t endpoint) const = 0;
  // The data of one IN transfer of at most size_max bytes.
  virtual Bytes data_in(std::uint8_t endpoint, std::size_t size_max) = 0;
  // How many bytes data_out() accepts now; the rest must wait.
  [[nodiscard]] virtual std::size_t room(std::uint8_t /*endpoint*/) const { return SIZE_MAX; }
  // Bytes of an IN transfer without data of the device (an FTDI chip's status).
  [[nodiscard]] virtual std::size_t in_overhead() const { return 0; }
  // Time in ms after which an IN transfer is answered without data; negative: never.
  [[nodiscard]] virtual int in_latency_ms(std::uint8_t /*endpoint*/) const { return -1; }
  // Advances time, for models whose line has its own timing. Called before every other call. Returns the time of the
  // next event without input.
  virtual TimeNs pass_time(TimeNs /*now_ns*/) { return kTimeNever; }

 protected:
  void show(int line, Bytes frame);  // sends it on that line

 private:
  std::vector<Line> lines_;
};

// The requests that every device answers (USB 2.0, section 9.4), from the model's descriptors.
std::optional<Bytes> standard_request(const UsbModel& model, const SetupPacket& setup);

}  // namespace footlight::drivers::mock

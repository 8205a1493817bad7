// A USB device as its host sees it, without a bus: what a front end needs in order to play one.
//
// A model has no thread, no clock and no lock, so the same class stands behind the in-process transport
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

  // --- What it is; free to change before it is plugged in.
  std::string manufacturer, product;
  std::string serial;  // of the USB descriptor; empty: it has none

  // --- What left on its DMX connectors; only to be read. A frame has its start code first.
  struct Line {
    Bytes frame;                    // the newest since power came; empty: none
    std::uint64_t frame_count = 0;  // ever
  };
  [[nodiscard]] const Line& line(int number) const;            // from 0; one without frames where nothing left there
  std::function<void(int line, const Bytes& frame)> on_frame;  // called for each; empty: none

  // A frame on one of its DMX inputs, start code first. Dropped where the line is none or does not listen.
  virtual void receive_line_frame(int line, std::span<const std::uint8_t> line_frame, std::uint8_t status = 0);
  // Whether one would be heard.
  [[nodiscard]] virtual bool listens(int /*line*/) const { return false; }
  // Bytes towards the host as they are: noise, or answers that the real device would not give.
  virtual void say(std::span<const std::uint8_t> bytes);

  // --- As its host sees it.
  [[nodiscard]] virtual Bytes device_descriptor() const = 0;  // 18 bytes
  [[nodiscard]] virtual Bytes config_descriptor() const = 0;  // with its interfaces and endpoints
  // Manufacturer, product, serial number; empty ones are not reported.
  [[nodiscard]] std::vector<std::string> strings() const { return {manufacturer, product, serial}; }
  // Power comes: volatile state is as new, what the device stores stays.
  // Every model calls this one, which has its lines show nothing.
  virtual void power_on();
  // nullopt: the device refuses (STALL). Data of the answer for requests to the host, else empty.
  virtual std::optional<Bytes> control(const SetupPacket& setup, std::span<const std::uint8_t> data) = 0;
  virtual void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) = 0;
  [[nodiscard]] virtual bool has_data(std::uint8_t endpoint) const = 0;
  // What one IN transfer of at most size_max bytes brings now.
  virtual Bytes data_in(std::uint8_t endpoint, std::size_t size_max) = 0;
  // How many bytes data_out() may be given at the moment; what is more has to wait.
  [[nodiscard]] virtual std::size_t room(std::uint8_t /*endpoint*/) const { return SIZE_MAX; }
  // Bytes of an IN transfer that carry no data of the device (an FTDI chip's status).
  [[nodiscard]] virtual std::size_t in_overhead() const { return 0; }
  // After how many ms an IN transfer is answered although there is no data; negative: never.
  [[nodiscard]] virtual int in_latency_ms(std::uint8_t /*endpoint*/) const { return -1; }
  // Time goes on, for models whose line has timing of its own. Called before everything else; returns when something
  // will happen by itself.
  virtual TimeNs pass_time(TimeNs /*now_ns*/) { return kTimeNever; }

 protected:
  void show(int line, Bytes frame);  // it leaves on that line

 private:
  std::vector<Line> lines_;
};

// The requests that every device answers (USB 2.0, section 9.4), from the model's descriptors.
std::optional<Bytes> standard_request(const UsbModel& model, const SetupPacket& setup);

}  // namespace footlight::drivers::mock

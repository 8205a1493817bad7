// FTDI's serial chips (FT232, FT2232, FT4232, FT-X, FT245): makes a Transport with bytes and breaks from one with
// control transfers and bulk endpoints, which is libusb's or that of a model.
//
// Sources: requests, status bytes and release numbers from the Linux kernel's drivers/usb/serial/ftdi_sio.h and .c.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "drivers/transport/transport.h"
#include "sim/core/clock.h"

namespace footlight::drivers {

namespace ftdi {

// Every packet from the chip begins with two status bytes. When the latency timer expires the chip sends a packet even
// without data. A transfer is a sequence of full packets and a last, shorter one.
inline constexpr std::size_t kStatusSize = 2;
inline constexpr std::size_t kFullSpeedPacketSize = 64;

// Removes the status bytes from an IN transfer, in place. Returns the number of data bytes; they are at the front then.
// packet_size: of the endpoint (64 at full speed, 512 at high speed), above kStatusSize.
[[nodiscard]] std::size_t strip_status(std::span<std::uint8_t> transfer, std::size_t packet_size);

inline constexpr std::uint8_t kRequestOut = 0x40;  // bmRequestType: vendor, to the device
inline constexpr std::uint8_t kRequestIn = 0xC0;

inline constexpr std::uint8_t kEndpointIn = 0x81;
inline constexpr std::uint8_t kEndpointOut = 0x02;

inline constexpr std::uint8_t kReset = 0;  // value 0: all, 1: bytes to the line, 2: bytes from the line
inline constexpr std::uint8_t kModemControl = 1;
inline constexpr std::uint8_t kFlowControl = 2;
inline constexpr std::uint8_t kBaudRate = 3;
inline constexpr std::uint8_t kLineData = 4;  // bits 0-7: data bits, 8-10: parity, 11-13: stop bits, 14: break
inline constexpr std::uint8_t kModemStatus = 5;
inline constexpr std::uint8_t kLatencyTimer = 9;  // value in ms, 1 to 255; 16 after reset

// Second status byte.
inline constexpr std::uint8_t kOverrun = 0x02;
inline constexpr std::uint8_t kFramingError = 0x08;
inline constexpr std::uint8_t kBreak = 0x10;
inline constexpr std::uint8_t kTransmitterEmpty = 0x40;

// bcdDevice tells the chips apart.
struct Chip {
  std::uint16_t release;
  bool is_fast;         // can divide its baud rate from 12 MHz
  bool has_more_lines;  // wIndex names the line, 1 for the first
};
[[nodiscard]] constexpr Chip chip_of(std::uint16_t release) {
  const int kind = release >> 8;
  return {release, kind == 7 || kind == 8 || kind == 9, kind == 5 || kind == 7 || kind == 8};
}

// wValue and wIndex of the baud rate request. The divisor is an integer: 250000 is exact, other rates are rounded.
struct BaudRequest {
  std::uint16_t value;
  std::uint16_t index;
};
[[nodiscard]] BaudRequest baud_request(const Chip& chip, int baud);

}  // namespace ftdi

// Resets the chip and sets 250000 baud, 8 data bits, 2 stop bits. `usb`: the open device, its interface claimed.
// `release`: its bcdDevice. In many widgets a parallel bus (FT245) connects the chip to the processor, and settings of
// the line have no effect. They are made all the same, since compatible widgets use a serial line.
[[nodiscard]] Result<std::unique_ptr<Transport>> open_ftdi(std::unique_ptr<Transport> usb, std::uint16_t release,
                                                           Clock& clock);

}  // namespace footlight::drivers

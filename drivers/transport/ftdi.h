// FTDI's serial chips (FT232, FT2232, FT4232, FT-X, FT245) as seen from the bus: a Transport with bytes and breaks
// above one with control transfers and bulk endpoints, whether those go through libusb or to a model.
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

// Every packet that the chip sends begins with two status bytes, also one without data, which it sends whenever its
// latency timer runs out. A transfer is a row of full packets and a last, shorter one.
inline constexpr std::size_t kStatusSize = 2;
inline constexpr std::size_t kFullSpeedPacketSize = 64;

// Moves the data of one IN transfer to its front and returns how many bytes they are. packet_size > kStatusSize: of the
// endpoint (64 full speed, 512 high speed).
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
  bool is_fast;         // baud rates from 12 MHz, where it is told so
  bool has_more_lines;  // wIndex names the line, 1 for the first
};
[[nodiscard]] constexpr Chip chip_of(std::uint16_t release) {
  const int kind = release >> 8;
  return {release, kind == 7 || kind == 8 || kind == 9, kind == 5 || kind == 7 || kind == 8};
}

// Two numbers of the baud rate request. Divisors without a fraction: 250000 is exact, others are rounded.
struct BaudRequest {
  std::uint16_t value;
  std::uint16_t index;
};
[[nodiscard]] BaudRequest baud_request(const Chip& chip, int baud);

}  // namespace ftdi

// Resets the chip and sets 250000 baud, 8 data bits, 2 stop bits. `usb` is the open device, its interface claimed;
// `release` its bcdDevice. The processor of a widget often sits behind a parallel bus (FT245), where the line's
// settings have no effect; they are made because look-alikes put a serial line in its place.
[[nodiscard]] Result<std::unique_ptr<Transport>> open_ftdi(std::unique_ptr<Transport> usb, std::uint16_t release,
                                                           Clock& clock);

}  // namespace footlight::drivers

// The chip between USB and the widget's processor: FTDI FT232 and FT245 as seen from the bus.
// Source of the layout: the Linux kernel's drivers/usb/serial/ftdi_sio.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace footlight::drivers::ftdi {

// Every packet that the chip sends begins with two status bytes, also one without data, which it sends whenever its
// latency timer runs out. A transfer is a row of full packets and a last, shorter one.
inline constexpr std::size_t kStatusSize = 2;
inline constexpr std::size_t kFullSpeedPacketSize = 64;

// Moves the data of one IN transfer to its front and returns how many bytes they are. packet_size > kStatusSize: of the
// endpoint (64 full speed, 512 high speed).
[[nodiscard]] inline std::size_t strip_status(std::span<std::uint8_t> transfer, std::size_t packet_size) {
  std::size_t kept = 0;
  for (std::size_t packet = 0; packet < transfer.size(); packet += packet_size) {
    const std::size_t end = packet + packet_size < transfer.size() ? packet + packet_size : transfer.size();
    for (std::size_t i = packet + kStatusSize; i < end; ++i) transfer[kept++] = transfer[i];
  }
  return kept;
}

// A vendor request without data. bmRequestType 0x40 (to the device), wIndex: the chip's port, 0 on single chips.
inline constexpr std::uint8_t kRequestTypeOut = 0x40;
struct Request {
  std::uint8_t request;
  std::uint16_t value;
  std::uint16_t index;
};

inline constexpr std::uint8_t kEndpointIn = 0x81;
inline constexpr std::uint8_t kEndpointOut = 0x02;

inline constexpr std::uint8_t kReset = 0;  // value 0: all, 1: bytes to the widget, 2: bytes from the widget
inline constexpr std::uint8_t kFlowControl = 2;
inline constexpr std::uint8_t kBaudRate = 3;
inline constexpr std::uint8_t kLineData = 4;
inline constexpr std::uint8_t kLatencyTimer = 9;  // value in ms, 1 to 255; 16 after reset

// Before the first byte. The widget's processor sits behind a parallel bus (FT245), so the baud rate has no effect
// there; it is set (250000, 8 bits, 2 stop bits) because look-alikes put a serial line in its place.
inline constexpr Request kOpening[] = {
    {kReset, 0, 0},       {kReset, 1, 0},         {kReset, 2, 0},
    {kFlowControl, 0, 0}, {kBaudRate, 0x000C, 0}, {kLineData, 0x1008, 0},
};

}  // namespace footlight::drivers::ftdi

#include "drivers/transport/transport.h"

namespace footlight::drivers {

Status Transport::control_out(const ControlRequest&, std::span<const std::uint8_t>, TimeNs) {
  return fail(ErrorCode::kUnsupported, "{}: takes no control transfers", where());
}

Result<std::size_t> Transport::control_in(const ControlRequest&, std::span<std::uint8_t>, TimeNs) {
  return fail(ErrorCode::kUnsupported, "{}: takes no control transfers", where());
}

Status Transport::write_endpoint(std::uint8_t, std::span<const std::uint8_t>, TimeNs) {
  return fail(ErrorCode::kUnsupported, "{}: has no endpoints of its own", where());
}

Result<std::size_t> Transport::read_endpoint(std::uint8_t, std::span<std::uint8_t>, TimeNs) {
  return fail(ErrorCode::kUnsupported, "{}: has no endpoints of its own", where());
}

std::size_t Transport::packet_size(std::uint8_t) const { return 64; }

Status Transport::set_line(const LineSettings&, TimeNs) {
  return fail(ErrorCode::kUnsupported, "{}: is not a serial line", where());
}

Status Transport::set_break(bool, TimeNs) { return fail(ErrorCode::kUnsupported, "{}: is not a serial line", where()); }

Result<bool> Transport::transmitter_empty(TimeNs) {
  return fail(ErrorCode::kUnsupported, "{}: is not a serial line", where());
}

Result<std::size_t> Transport::read_line(std::span<LineByte>, TimeNs) {
  return fail(ErrorCode::kUnsupported, "{}: is not a serial line", where());
}

}  // namespace footlight::drivers

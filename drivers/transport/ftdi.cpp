#include "drivers/transport/ftdi.h"

#include <algorithm>
#include <array>
#include <vector>

namespace footlight::drivers {
namespace {

constexpr DurationNs kControlTimeoutNs = 500 * kNsPerMs;
constexpr std::uint16_t kBreakBit = 1u << 14;

class FtdiTransport final : public Transport {
 public:
  FtdiTransport(std::unique_ptr<Transport> usb, std::uint16_t release, Clock& clock)
      : usb_(std::move(usb)),
        chip_(ftdi::chip_of(release)),
        index_(chip_.has_more_lines ? 1 : 0),
        packet_size_(std::max(usb_->packet_size(ftdi::kEndpointIn), ftdi::kStatusSize + 1)),
        clock_(clock) {}

  Status start() {
    for (std::uint16_t what = 0; what < 3; ++what) FL_TRY(request(ftdi::kReset, what));
    FL_TRY(request(ftdi::kModemControl, 0x0200));  // RTS low: cables whose driver chip it switches then send
    FL_TRY(request(ftdi::kFlowControl, 0));
    return set_line({}, clock_.now_ns() + kControlTimeoutNs);
  }

  std::string where() const override { return usb_->where(); }
  std::string serial() const override { return usb_->serial(); }
  std::size_t packet_size(std::uint8_t endpoint) const override { return usb_->packet_size(endpoint); }
  Status wait(TimeNs deadline_ns) override { return usb_->wait(deadline_ns); }

  Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    return usb_->write_endpoint(ftdi::kEndpointOut, bytes, deadline_ns);
  }

  Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    while (unread_ == unread_end_) {
      FL_ASSIGN(const std::size_t count, usb_->read_endpoint(ftdi::kEndpointIn, transfer_, deadline_ns));
      if (count == 0) return 0;
      unread_ = 0;
      unread_end_ = ftdi::strip_status(std::span(transfer_).first(count), packet_size_);
    }
    const std::size_t count = std::min(into.size(), unread_end_ - unread_);
    std::copy_n(transfer_.begin() + static_cast<std::ptrdiff_t>(unread_), count, into.begin());
    unread_ += count;
    return count;
  }

  Status set_line(const LineSettings& settings, TimeNs deadline_ns) override {
    const ftdi::BaudRequest baud = ftdi::baud_request(chip_, settings.baud);
    FL_TRY(usb_->control_out({ftdi::kRequestOut, ftdi::kBaudRate, baud.value, baud.index}, {}, deadline_ns));
    line_data_ = static_cast<std::uint16_t>(8 | (settings.stop_bits == 2 ? 2 : 0) << 11);
    FL_TRY(request(ftdi::kLineData, line_data_));
    return request(ftdi::kLatencyTimer, static_cast<std::uint16_t>(std::clamp(settings.latency_ms, 1, 255)));
  }

  Status set_break(bool on, TimeNs deadline_ns) override {
    return usb_->control_out(
        {ftdi::kRequestOut, ftdi::kLineData, static_cast<std::uint16_t>(line_data_ | (on ? kBreakBit : 0)), index_}, {},
        deadline_ns);
  }

  Result<bool> transmitter_empty(TimeNs deadline_ns) override {
    std::array<std::uint8_t, 2> status{};
    FL_ASSIGN(const std::size_t count,
              usb_->control_in({ftdi::kRequestIn, ftdi::kModemStatus, 0, index_}, status, deadline_ns));
    if (count < status.size())
      return fail(ErrorCode::kProtocol, "{}: answered the line status with {} bytes, 2 were expected", where(), count);
    return (status[1] & ftdi::kTransmitterEmpty) != 0;
  }

  // The flags of a packet apply to its last byte. A break is a zero there (ftdi_process_packet in ftdi_sio.c).
  Result<std::size_t> read_line(std::span<LineByte> into, TimeNs deadline_ns) override {
    while (line_unread_ == line_bytes_.size()) {
      FL_ASSIGN(const std::size_t count, usb_->read_endpoint(ftdi::kEndpointIn, transfer_, deadline_ns));
      if (count == 0) return 0;
      line_bytes_.clear();
      line_unread_ = 0;
      const TimeNs now_ns = clock_.now_ns();
      for (std::size_t packet = 0; packet < count; packet += packet_size_)
        take_packet(std::span(transfer_).first(std::min(count, packet + packet_size_)).subspan(packet), now_ns);
    }
    const std::size_t count = std::min(into.size(), line_bytes_.size() - line_unread_);
    std::copy_n(line_bytes_.begin() + static_cast<std::ptrdiff_t>(line_unread_), count, into.begin());
    line_unread_ += count;
    return count;
  }

  Status control_out(const ControlRequest& request, std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    return usb_->control_out(request, bytes, deadline_ns);
  }
  Result<std::size_t> control_in(const ControlRequest& request, std::span<std::uint8_t> into,
                                 TimeNs deadline_ns) override {
    return usb_->control_in(request, into, deadline_ns);
  }

 private:
  Status request(std::uint8_t what, std::uint16_t value) {
    return usb_->control_out({ftdi::kRequestOut, what, value, index_}, {}, clock_.now_ns() + kControlTimeoutNs);
  }

  void take_packet(std::span<const std::uint8_t> packet, TimeNs now_ns) {
    if (packet.size() < ftdi::kStatusSize) return;
    const std::uint8_t status = packet[1];
    const auto data = packet.subspan(ftdi::kStatusSize);
    if ((status & ftdi::kOverrun) != 0) lost_ = true;
    for (std::size_t i = 0; i < data.size(); ++i) {
      const bool last = i + 1 == data.size();
      const bool is_break = last && data[i] == 0 && (status & ftdi::kBreak) != 0;
      line_bytes_.push_back({.value = data[i],
                             .is_break = is_break,
                             .framing_error = last && !is_break && (status & ftdi::kFramingError) != 0,
                             .lost_before = std::exchange(lost_, false),
                             .stamp_ns = now_ns});
    }
  }

  const std::unique_ptr<Transport> usb_;
  const ftdi::Chip chip_;
  const std::uint16_t index_;
  const std::size_t packet_size_;
  Clock& clock_;
  std::uint16_t line_data_ = 0;
  std::array<std::uint8_t, kUsbTransferSizeMax> transfer_{};
  std::size_t unread_ = 0, unread_end_ = 0;  // range in transfer_, status bytes removed
  std::vector<LineByte> line_bytes_;
  std::size_t line_unread_ = 0;
  bool lost_ = false;  // bytes are missing before the next one
};

}  // namespace

std::size_t ftdi::strip_status(std::span<std::uint8_t> transfer, std::size_t packet_size) {
  std::size_t kept = 0;
  for (std::size_t packet = 0; packet < transfer.size(); packet += packet_size)
    for (std::size_t i = packet + kStatusSize; i < std::min(transfer.size(), packet + packet_size); ++i)
      transfer[kept++] = transfer[i];
  return kept;
}

ftdi::BaudRequest ftdi::baud_request(const Chip& chip, int baud) {
  constexpr int kSlowBaseHz = 3'000'000, kFastBaseHz = 12'000'000;
  constexpr std::uint16_t kUseFastBase = 1u << 9;  // bit 17 of the divisor, in the high byte of the index
  const int base_hz = chip.is_fast ? kFastBaseHz : kSlowBaseHz;
  const int divisor = std::clamp((base_hz + baud / 2) / std::max(baud, 1), 1, 0x3FFF);
  const int line = chip.has_more_lines ? 1 : 0;
  return {static_cast<std::uint16_t>(divisor), static_cast<std::uint16_t>((chip.is_fast ? kUseFastBase : 0) | line)};
}

Result<std::unique_ptr<Transport>> open_ftdi(std::unique_ptr<Transport> usb, std::uint16_t release, Clock& clock) {
  auto transport = std::make_unique<FtdiTransport>(std::move(usb), release, clock);
  FL_TRY(transport->start());
  return transport;
}

}  // namespace footlight::drivers

#include "drivers/mock/open_dmx_model.h"

#include <algorithm>

namespace footlight::drivers::mock {
namespace {

constexpr std::uint8_t kOverrun = 0x02, kFramingError = 0x08, kBreak = 0x10, kHoldingEmpty = 0x20, kAllEmpty = 0x40;
constexpr std::size_t kPacketDataMax = 62;
constexpr std::size_t kFrameSizeMax = 513;
constexpr std::size_t kReceivedMax = 8 * kFrameSizeMax;  // then the oldest is lost, as in a chip that is not read

}  // namespace

void OpenDmxModel::power_on() {
  SerialModel::power_on();
  fifo_.clear();
  symbols_.clear();
  frame_.clear();
  low_ = in_frame_ = has_sent_ = false;
  shift_end_ns_ = high_ns_ = now_ns_;
}

// Bytes leave the buffer one after the other.
TimeNs OpenDmxModel::pass_time(TimeNs now_ns) {
  while (!fifo_.empty() && !low_ && shift_end_ns_ <= now_ns) {
    const TimeNs begin_ns = std::max(shift_end_ns_, now_ns_);
    if (in_frame_ && frame_.empty()) {
      timing_.mark_ns = begin_ns - high_ns_;
      if (timing_.break_ns < break_min_ns || timing_.mark_ns < mark_min_ns) {
        ++bad_break_count;
        in_frame_ = false;
      }
    }
    if (in_frame_ && frame_.size() < kFrameSizeMax) frame_.push_back(fifo_.front());
    fifo_.pop_front();
    shift_end_ns_ = begin_ns + slot_ns;
    if (in_frame_ && frame_.size() == kFrameSizeMax) show(0, frame_);
  }
  now_ns_ = now_ns;
  return fifo_.empty() || low_ ? kTimeNever : shift_end_ns_;
}

std::size_t OpenDmxModel::room(std::uint8_t) const { return fifo_size - std::min(fifo_size, fifo_.size()); }

void OpenDmxModel::take(std::span<const std::uint8_t> bytes) {
  has_sent_ = has_sent_ || !bytes.empty();
  fifo_.insert(fifo_.end(), bytes.begin(), bytes.end());
  (void)pass_time(now_ns_);
}

void OpenDmxModel::end_frame(bool cut) {
  if (cut) ++cut_count;
  if (!in_frame_ || frame_.empty()) return;
  timing_.size = frame_.size();
  timing_.cut = cut;
  timings.push_back(timing_);
  if (!cut && frame_.size() < kFrameSizeMax) show(0, frame_);
}

void OpenDmxModel::line_settings_changed() {
  const bool low = line_held_low();
  if (low == low_) return;
  low_ = low;
  if (low) {
    end_frame(!transmitter_empty());
    fifo_.clear();
    frame_.clear();
    low_ns_ = now_ns_;
    in_frame_ = false;
  } else {
    high_ns_ = now_ns_;
    shift_end_ns_ = now_ns_;
    timing_ = {.begin_ns = low_ns_, .break_ns = high_ns_ - low_ns_};
    in_frame_ = true;
  }
}

std::uint8_t OpenDmxModel::line_status() const {
  return static_cast<std::uint8_t>((fifo_.empty() ? kHoldingEmpty : 0) | (transmitter_empty() ? kAllEmpty : 0));
}

void OpenDmxModel::receive_break() { symbols_.push_back({0, kBreak | kFramingError}); }
void OpenDmxModel::receive_byte(std::uint8_t byte, bool framing_error) {
  symbols_.push_back({byte, framing_error ? kFramingError : std::uint8_t{0}});
}
void OpenDmxModel::receive_overrun() { symbols_.push_back({0, kOverrun}); }

void OpenDmxModel::receive_line_frame(int line, std::span<const std::uint8_t> line_frame, std::uint8_t) {
  if (!listens(line)) return;
  receive_break();
  for (const std::uint8_t byte : line_frame) receive_byte(byte);
  while (symbols_.size() > kReceivedMax) symbols_.pop_front();
}

// One packet: a byte with a flag ends it, because the flags are those of a packet's last byte.
Bytes OpenDmxModel::data_in(std::uint8_t, std::size_t size_max) {
  Bytes packet{kModemStatus, line_status()};
  while (!symbols_.empty() && packet.size() < std::min(size_max, kPacketDataMax + 2)) {
    const Symbol symbol = symbols_.front();
    symbols_.pop_front();
    packet[1] = static_cast<std::uint8_t>(packet[1] | symbol.flags);
    if (symbol.flags != kOverrun) packet.push_back(symbol.value);
    if (symbol.flags != 0) break;
  }
  return packet;
}

}  // namespace footlight::drivers::mock

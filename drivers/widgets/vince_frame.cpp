#include "drivers/widgets/vince_frame.h"

#include <algorithm>

namespace footlight::drivers {
namespace {

constexpr std::uint8_t kStart = 0x0F, kEnd = 0x04;

}  // namespace

std::array<std::uint8_t, kVinceUpdateSize> encode_vince_update(std::span<const std::uint8_t, kSlotCountMax> snapshot) {
  constexpr std::size_t kLength = kSlotCountMax + 2;
  std::array<std::uint8_t, kVinceUpdateSize> message{kStart,
                                                     kStart,
                                                     static_cast<std::uint8_t>(VinceCommand::kUpdate),
                                                     static_cast<std::uint8_t>(kLength >> 8),
                                                     static_cast<std::uint8_t>(kLength & 0xFF),
                                                     0,
                                                     0};
  std::copy(snapshot.begin(), snapshot.end(), message.begin() + 7);
  message.back() = kEnd;
  return message;
}

VinceReplyParser::Verdict VinceReplyParser::judge() const {
  if (held_[0] != kStart || (size_ > 1 && held_[1] != kStart)) return Verdict::kFalseStart;
  if (size_ < kHeadSize) return Verdict::kNeedsMore;
  const auto data_size = static_cast<std::size_t>(held_[4] << 8 | held_[5]);
  if (data_size > kDataSizeMax) return Verdict::kFalseStart;
  if (size_ < kHeadSize + data_size + 1) return Verdict::kNeedsMore;
  return held_[kHeadSize + data_size] == kEnd ? Verdict::kReply : Verdict::kFalseStart;
}

bool VinceReplyParser::next(std::span<const std::uint8_t>& stream, VinceReply& reply) {
  const auto drop_front = [this] {
    std::copy(held_.begin() + 1, held_.begin() + static_cast<std::ptrdiff_t>(size_), held_.begin());
    --size_;
  };
  while (true) {
    // The rest of a false start is checked again before more is added.
    while (size_ > 0 && judge() == Verdict::kFalseStart) {
      ++garbage_byte_count_;
      drop_front();
    }
    if (size_ > 0 && judge() == Verdict::kReply) {
      reply = {held_[2], held_[3]};
      const std::size_t used = kHeadSize + static_cast<std::size_t>(held_[4] << 8 | held_[5]) + 1;
      for (std::size_t i = 0; i < used; ++i) drop_front();
      return true;
    }
    if (stream.empty()) return false;
    held_[size_++] = stream.front();
    stream = stream.subspan(1);
  }
}

}  // namespace footlight::drivers

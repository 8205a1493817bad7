#include "drivers/widgets/peperoni_frame.h"

#include <algorithm>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::uint8_t kMagic[] = {0x02, 0x4D, 0x6B, 0x32};
// As in QLC+: 200 us and 20 us.
constexpr std::uint8_t kBreakCode = 181, kMarkCode = 250;
constexpr std::uint8_t kWaitForTransmitter = 0x02, kForceTransmission = 0x80;

}  // namespace

PeperoniFrames peperoni_frames(std::uint16_t release) {
  if (release < 0x0400) return PeperoniFrames::kControl;
  return release < 0x0500 ? PeperoniFrames::kBulk : PeperoniFrames::kBulkWithStatus;
}

std::array<std::uint8_t, kPeperoniBulkSize> encode_peperoni_bulk(
    int universe, std::span<const std::uint8_t, kSlotCountMax> snapshot) {
  FL_CHECK(universe == 0 || universe == 1);
  constexpr std::uint8_t kSetFirst = 0, kSetSecond = 4;
  std::array<std::uint8_t, kPeperoniBulkSize> message{0x01, universe == 0 ? kSetFirst : kSetSecond, 0x00, 0x02};
  std::copy(snapshot.begin(), snapshot.end(), message.begin() + 4);
  return message;
}

std::array<std::uint8_t, kPeperoniStatusFrameSize> encode_peperoni_with_status(
    int universe, std::span<const std::uint8_t, kSlotCountMax> snapshot) {
  FL_CHECK(universe == 0 || universe == 1);
  constexpr std::size_t kCommandSize = 13, kDataHeadSize = 7;
  constexpr std::size_t kDataSize = kDataHeadSize + kSlotCountMax, kLineSize = 1 + kSlotCountMax;
  const std::uint8_t settings[] = {0x00,  // set
                                   static_cast<std::uint8_t>(universe),
                                   kDataSize & 0xFF,
                                   kDataSize >> 8,
                                   kWaitForTransmitter | kForceTransmission,
                                   kPeperoniWaitMs,
                                   0,
                                   kBreakCode,
                                   kMarkCode};
  constexpr std::uint8_t kDataHead[] = {kLineSize & 0xFF, kLineSize >> 8, 0x00};
  std::array<std::uint8_t, kPeperoniStatusFrameSize> message{};
  auto at = std::copy(std::begin(kMagic), std::end(kMagic), message.begin());
  at = std::copy(std::begin(settings), std::end(settings), at);
  FL_CHECK_EQ(at - message.begin(), static_cast<std::ptrdiff_t>(kCommandSize));
  at = std::copy(std::begin(kMagic), std::end(kMagic), at);
  at = std::copy(std::begin(kDataHead), std::end(kDataHead), at);
  std::copy(snapshot.begin(), snapshot.end(), at);
  return message;
}

std::optional<PeperoniStatus> decode_peperoni_status(std::span<const std::uint8_t> answer) {
  if (answer.size() != kPeperoniStatusSize || !std::equal(std::begin(kMagic), std::end(kMagic), answer.begin()))
    return std::nullopt;
  return static_cast<PeperoniStatus>(answer[6]);
}

}  // namespace footlight::drivers

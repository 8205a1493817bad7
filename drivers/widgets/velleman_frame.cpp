#include "drivers/widgets/velleman_frame.h"

#include <algorithm>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::uint8_t kSlots = 2, kOneSlot = 3, kStart = 4, kZerosAndSlots = 5, kCountedSlots = 6;
// Other programs keep to 100 with the original firmware, although a byte could hold more: above it the device
// misbehaves.
constexpr std::size_t kZerosMax = 100, kUpgradedZerosMax = 254;
constexpr std::size_t kUpgradedReportCountMax = 9;  // 62 + 7 x 63 + 9 slots
static_assert(kUpgradedReportCountMax * kVellemanUpgradedReportSize <= kVellemanReportCountMax * kVellemanReportSize);

}  // namespace

VellemanReports::VellemanReports(std::span<const std::uint8_t, kSlotCountMax> snapshot, std::size_t report_size)
    : stride_(report_size) {
  FL_CHECK(report_size == kVellemanReportSize || report_size == kVellemanUpgradedReportSize);
  const bool upgraded = report_size == kVellemanUpgradedReportSize;
  const std::size_t zeros_max = upgraded ? kUpgradedZerosMax : kZerosMax;
  const std::size_t plain_count = report_size - 1, counted_count = report_size - 2;

  std::span<const std::uint8_t> rest = snapshot;
  const auto leading_zeros = [&] {
    const std::size_t limit = std::min(zeros_max, rest.size() - counted_count);
    return static_cast<std::size_t>(
        std::find_if(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(limit), [](auto v) { return v != 0; }) -
        rest.begin());
  };
  const auto put = [&](std::span<std::uint8_t> into, std::size_t slot_count) {
    std::copy_n(rest.begin(), slot_count, into.begin());
    rest = rest.subspan(slot_count);
  };
  const auto put_zeros_and_slots = [&](std::uint8_t type, std::size_t zeros, std::size_t extra) {
    const auto body = add(type);
    body[0] = static_cast<std::uint8_t>(zeros + extra);
    rest = rest.subspan(zeros);
    put(body.subspan(1), counted_count);
  };

  put_zeros_and_slots(kStart, leading_zeros(), 1);
  while (rest.size() >= plain_count) {
    if (const std::size_t zeros = leading_zeros(); zeros > 0)
      put_zeros_and_slots(kZerosAndSlots, zeros, 0);
    else
      put(add(kSlots), plain_count);
  }
  if (upgraded && !rest.empty()) {
    const auto body = add(kCountedSlots);
    body[0] = static_cast<std::uint8_t>(rest.size());
    put(body.subspan(1), rest.size());
  }
  while (!rest.empty()) put(add(kOneSlot), 1);
}

std::span<std::uint8_t> VellemanReports::add(std::uint8_t type) {
  FL_CHECK_LE((count_ + 1) * stride_, bytes_.size());
  const auto report = std::span(bytes_).subspan(count_++ * stride_, stride_);
  report[0] = type;
  return report.subspan(1);
}

}  // namespace footlight::drivers

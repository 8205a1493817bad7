#include "drivers/widgets/nodle_frame.h"

#include <algorithm>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::uint8_t kModeReport = 16;

}  // namespace

NodleReport encode_nodle_mode(std::uint8_t mode) {
  NodleReport report{};
  report[1] = kModeReport;
  report[2] = mode;
  return report;
}

NodleReport encode_nodle_block(int block, std::span<const std::uint8_t, kSlotCountMax> snapshot) {
  FL_CHECK(block >= 0 && block < kNodleBlockCount);
  NodleReport report{};
  report[1] = static_cast<std::uint8_t>(block);
  std::copy_n(snapshot.begin() + std::ptrdiff_t{block} * kNodleBlockSize, kNodleBlockSize, report.begin() + 2);
  return report;
}

std::optional<int> apply_nodle_report(std::span<const std::uint8_t> report,
                                      std::span<std::uint8_t, kSlotCountMax> slots) {
  // A report is never cut on the way: one that is too long is not of this family.
  if (report.size() != std::tuple_size_v<NodleReport> || report[1] >= kNodleBlockCount) return std::nullopt;
  const int block = report[1];
  std::copy_n(report.begin() + 2, kNodleBlockSize, slots.begin() + std::ptrdiff_t{block} * kNodleBlockSize);
  return block;
}

}  // namespace footlight::drivers

// Properties of the parser for any bytes as an input report of the Nodle family. Shared by a test and a fuzz target.
#pragma once

#include <span>
#include <string>

#include <fmt/format.h>

#include "drivers/widgets/nodle_frame.h"

namespace footlight::testing {

// Empty if all hold, else the one that does not.
inline std::string check_nodle_report(std::span<const std::uint8_t> report) {
  constexpr std::uint8_t kBefore = 0x5A;
  Slots slots;
  slots.fill(kBefore);
  const auto block = drivers::apply_nodle_report(report, slots);
  const bool is_block = report.size() == 34 && report[1] < 16;
  if (block.has_value() != is_block) return fmt::format("a report of {} bytes is accepted wrongly", report.size());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const bool inside = block && i / 32 == static_cast<std::size_t>(*block);
    const std::uint8_t expected = inside ? report[2 + i % 32] : kBefore;
    if (slots[i] != expected) return fmt::format("slot {} is {}, not {}", i, slots[i], expected);
  }
  return {};
}

}  // namespace footlight::testing

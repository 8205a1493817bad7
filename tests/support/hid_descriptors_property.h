// Properties of the parser for any bytes as a configuration descriptor. Shared by a test and a fuzz target.
#pragma once

#include <span>
#include <string>

#include <fmt/format.h>

#include "drivers/transport/hid_descriptors.h"

namespace footlight::testing {

// Empty if all hold, else the one that does not.
inline std::string check_hid_descriptor(std::span<const std::uint8_t> bytes) {
  const auto found = drivers::find_hid_output(bytes);
  if (!found) return {};
  if (found->report_size < 1 || found->report_size > 2047)
    return fmt::format("a report of {} bytes", found->report_size);
  if (found->interval_ms < 1 || found->interval_ms > 255)
    return fmt::format("an interval of {} ms", found->interval_ms);
  return {};
}

}  // namespace footlight::testing

// The words of --flashes.
#pragma once

#include <string_view>

#include "sim/core/result.h"

namespace footlight::tools {

enum class FlashMode { kOff, kWarn, kLimit };

// "off", "warn" or "limit"; kBadInput for others.
[[nodiscard]] inline Result<FlashMode> flash_mode_of(std::string_view word) {
  if (word == "off") return FlashMode::kOff;
  if (word == "warn") return FlashMode::kWarn;
  if (word == "limit") return FlashMode::kLimit;
  return fail(ErrorCode::kBadInput, "--flashes {}: expected off, warn or limit", word);
}

}  // namespace footlight::tools

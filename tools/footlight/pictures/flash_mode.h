// The words of --flashes.
#pragma once

#include <string_view>

#include "sim/core/result.h"

namespace footlight::tools {

enum class FlashMode { kOff, kWarn, kLimit };

inline constexpr FlashMode kFlashModes[] = {FlashMode::kOff, FlashMode::kWarn, FlashMode::kLimit};
[[nodiscard]] constexpr const char* word_of(FlashMode mode) {
  return mode == FlashMode::kOff ? "off" : mode == FlashMode::kWarn ? "warn" : "limit";
}
// What it does, for menus.
[[nodiscard]] constexpr const char* words_of(FlashMode mode) {
  return mode == FlashMode::kOff    ? "off: are not looked for"
         : mode == FlashMode::kWarn ? "warn: a message"
                                    : "limit: the last harmless picture stays";
}
[[nodiscard]] constexpr FlashMode next_of(FlashMode mode) {
  return mode == FlashMode::kOff ? FlashMode::kWarn : mode == FlashMode::kWarn ? FlashMode::kLimit : FlashMode::kOff;
}

// "off", "warn" or "limit"; kBadInput for others.
[[nodiscard]] inline Result<FlashMode> flash_mode_of(std::string_view word) {
  if (word == "off") return FlashMode::kOff;
  if (word == "warn") return FlashMode::kWarn;
  if (word == "limit") return FlashMode::kLimit;
  return fail(ErrorCode::kBadInput, "--flashes {}: expected off, warn or limit", word);
}

}  // namespace footlight::tools

// Errors of libav as values. Included by files that use libav.
#pragma once

#include <array>
#include <string>

extern "C" {
#include <libavutil/error.h>
}

#include "sim/core/result.h"

namespace footlight::tools {

[[nodiscard]] inline std::string av_text(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

[[nodiscard]] inline Status av_check(int code, const std::string& name, const char* what,
                                     ErrorCode error = ErrorCode::kIo) {
  if (code >= 0) return {};
  return fail(error, "{}: {} failed: {}", name, what, av_text(code));
}

}  // namespace footlight::tools

// "1 fixture", "3 fixtures": for sentences that people read.
#pragma once

#include <string>
#include <string_view>

#include <fmt/format.h>

namespace footlight {

// The plural is the word with an s.
[[nodiscard]] inline std::string counted(auto count, std::string_view word) {
  return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s");
}

}  // namespace footlight

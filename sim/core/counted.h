// "1 fixture", "3 fixtures": a count with its noun, for messages.
#pragma once

#include <string>
#include <string_view>

#include <fmt/format.h>

namespace footlight {

// The plural is the word plus "s".
[[nodiscard]] inline std::string counted(auto count, std::string_view word) {
  return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s");
}

}  // namespace footlight

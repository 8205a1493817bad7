// Counts the calls of operator new in this executable, and the memory that is held: it replaces the global operators.
#pragma once

#include <cstdint>

namespace footlight::testing {

[[nodiscard]] std::uint64_t allocation_count();
[[nodiscard]] std::int64_t live_bytes();

}  // namespace footlight::testing

// How often this executable has asked for memory with operator new, and how much of it is held: the global operators
// are replaced to count it.
#pragma once

#include <cstdint>

namespace footlight::testing {

[[nodiscard]] std::uint64_t allocation_count();
[[nodiscard]] std::int64_t live_bytes();

}  // namespace footlight::testing

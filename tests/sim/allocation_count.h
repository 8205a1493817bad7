// How often this executable has asked for memory with operator new: the global operators are replaced to count it.
#pragma once

#include <cstdint>

namespace footlight::testing {

std::uint64_t allocation_count();

}  // namespace footlight::testing

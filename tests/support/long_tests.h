// Tests that take long run with `tools/test --long` only, which sets FOOTLIGHT_LONG_TESTS.
#pragma once

#include <cstdlib>

namespace footlight::testing {

[[nodiscard]] inline bool runs_long_tests() { return std::getenv("FOOTLIGHT_LONG_TESTS") != nullptr; }

}  // namespace footlight::testing

// Returns the value of a Result, or ends the test with the error's message.
#pragma once

#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "sim/core/result.h"

namespace footlight::testing {

template <class T>
T must(Result<T> result) {
  REQUIRE_MESSAGE(result.has_value(), (result ? std::string() : result.error().message));
  return std::move(*result);
}
inline void must(const Status& status) {
  REQUIRE_MESSAGE(status.has_value(), (status ? std::string() : status.error().message));
}

}  // namespace footlight::testing

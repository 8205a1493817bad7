#include "sim/core/histogram.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

using footlight::DurationNs;
using footlight::Histogram;

TEST_CASE("an empty histogram returns 0") {
  const Histogram histogram;
  CHECK(histogram.count() == 0);
  CHECK(histogram.quantile_ns(0.5) == 0);
  CHECK(histogram.max_ns() == 0);
}

TEST_CASE("a quantile is never below the true one and at most an eighth above it") {
  // Values over the whole range: a geometric series with jitter, from 0 ns to 15 minutes.
  std::vector<DurationNs> values;
  std::uint64_t random = 7;
  for (double base = 1.0; base < 9e11; base *= 1.01) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    values.push_back(static_cast<DurationNs>(base * (1.0 + static_cast<double>(random >> 40) * 1e-8)));
  }
  values.push_back(0);
  Histogram histogram;
  for (const DurationNs value : values) histogram.record(value);
  std::sort(values.begin(), values.end());
  CHECK(histogram.count() == values.size());
  CHECK(histogram.max_ns() == values.back());
  CHECK(histogram.sum_ns() == std::accumulate(values.begin(), values.end(), std::uint64_t{0}));
  for (int power = 3; power < 40; ++power) {
    const auto end = std::lower_bound(values.begin(), values.end(), DurationNs{1} << power);
    CHECK(histogram.count_below_power(power) == static_cast<std::uint64_t>(end - values.begin()));
  }
  for (const double share : {0.0, 0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto wanted = static_cast<std::size_t>(std::max(1.0, std::ceil(share * static_cast<double>(values.size()))));
    const DurationNs exact = values[wanted - 1];
    CHECK(histogram.quantile_ns(share) >= exact);
    CHECK(histogram.quantile_ns(share) <= exact + exact / 8);
  }
}

TEST_CASE("durations below 0 count as 0, and beyond the range as the largest") {
  Histogram histogram;
  histogram.record(-5);
  CHECK(histogram.quantile_ns(1.0) == 0);
  histogram.record(INT64_MAX);
  CHECK(histogram.max_ns() == INT64_MAX);
  CHECK(histogram.quantile_ns(1.0) == INT64_MAX);
  histogram.clear();
  CHECK(histogram.count() == 0);
}

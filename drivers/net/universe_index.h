// Maps a universe's number to its place in a port's list, in constant time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace footlight::drivers {

class UniverseIndex {
 public:
  // Numbers are at least 0 and appear once. Memory: four octets per number between the smallest and the largest.
  explicit UniverseIndex(const std::vector<int>& numbers) {
    if (numbers.empty()) return;
    const auto [least, greatest] = std::minmax_element(numbers.begin(), numbers.end());
    first_ = *least;
    places_.assign(static_cast<std::size_t>(*greatest - *least) + 1, -1);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      places_[static_cast<std::size_t>(numbers[i] - first_)] = static_cast<std::int32_t>(i);
    }
  }
  // -1 if the number is not in the list.
  [[nodiscard]] int find(int number) const {
    const long long offset = static_cast<long long>(number) - first_;
    if (offset < 0 || offset >= static_cast<long long>(places_.size())) return -1;
    return places_[static_cast<std::size_t>(offset)];
  }

 private:
  int first_ = 0;
  std::vector<std::int32_t> places_;
};

}  // namespace footlight::drivers

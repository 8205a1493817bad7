// Random numbers that are the same on every machine and with every standard library: SplitMix64 (Steele, Lea, Flood,
// 2014). Not for secrets.
#pragma once

#include <cstddef>
#include <cstdint>

namespace footlight {

// The output function: every bit of z changes half of the result's bits.
[[nodiscard]] constexpr std::uint64_t mixed_bits(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}
inline constexpr std::uint64_t kMixStep = 0x9e3779b97f4a7c15u;

class SeededNumbers {
 public:
  explicit SeededNumbers(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() { return mixed_bits(state_ += kMixStep); }
  // 0 <= uniform() < 1.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  // 0 to count - 1.
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(next() % count); }

 private:
  std::uint64_t state_;
};

}  // namespace footlight

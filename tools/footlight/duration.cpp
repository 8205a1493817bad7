#include "tools/footlight/duration.h"

#include <cmath>
#include <cstdint>

#include "sim/core/words.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kDurationMaxNs = kNsPerS * 3'600 * 10'000;

struct Unit {
  std::string_view name;
  DurationNs size_ns;
};
// Large to small.
constexpr Unit kUnits[] = {{"h", 3'600 * kNsPerS}, {"m", 60 * kNsPerS}, {"s", kNsPerS},
                           {"ms", kNsPerMs},       {"us", kNsPerUs},    {"ns", 1}};

bool is_letter(char c) { return c >= 'a' && c <= 'z'; }

}  // namespace

Result<DurationNs> parse_duration(std::string_view text) {
  const auto refuse = [&] {
    return fail(ErrorCode::kBadInput, "expected a time such as 12.5s, 40ms or 1m30s (at most 10000h), got \"{}\"",
                text);
  };
  std::string_view rest = text;
  DurationNs total_ns = 0;
  DurationNs smallest_ns = INT64_MAX;  // units get smaller from left to right
  do {
    // Digits as an integer with a decimal scale, so that 0.1s is exact.
    std::size_t at = 0;
    std::int64_t digits = 0;
    std::int64_t scale = 1;
    bool any = false;
    bool after_point = false;
    for (; at < rest.size() && (is_digit(rest[at]) || (rest[at] == '.' && !after_point)); ++at) {
      if (rest[at] == '.') {
        after_point = true;
        continue;
      }
      any = true;
      if (digits > INT64_MAX / 100 || (after_point && scale > INT64_MAX / 100)) return refuse();
      digits = digits * 10 + (rest[at] - '0');
      if (after_point) scale *= 10;
    }
    if (!any) return refuse();
    rest.remove_prefix(at);
    std::size_t letters = 0;
    while (letters < rest.size() && is_letter(rest[letters])) ++letters;
    const std::string_view name = rest.substr(0, letters);
    rest.remove_prefix(letters);

    DurationNs size_ns = 0;
    for (const Unit& unit : kUnits)
      if (unit.name == name) size_ns = unit.size_ns;
    if (name.empty() && smallest_ns == INT64_MAX && rest.empty()) size_ns = kNsPerS;  // a plain number
    if (size_ns == 0 || size_ns >= smallest_ns) return refuse();
    smallest_ns = size_ns;

    const std::int64_t whole = digits / scale;
    const std::int64_t part = digits % scale;
    if (whole > kDurationMaxNs / size_ns) return refuse();
    total_ns += whole * size_ns +
                static_cast<DurationNs>(std::llround(static_cast<long double>(part) / static_cast<long double>(scale) *
                                                     static_cast<long double>(size_ns)));
    if (total_ns > kDurationMaxNs) return refuse();
  } while (!rest.empty());
  return total_ns;
}

std::string show_duration(DurationNs duration_ns) {
  const auto ns = static_cast<double>(duration_ns);
  if (duration_ns == 0) return "0 s";
  if (duration_ns < kNsPerUs) return fmt::format("{} ns", duration_ns);
  // 999.5 of a unit rounds to 1000, which is 1 of the next one.
  if (2 * duration_ns < 1'999 * kNsPerUs) return fmt::format("{:.3g} us", ns / 1e3);
  if (2 * duration_ns < 1'999 * kNsPerMs) return fmt::format("{:.3g} ms", ns / 1e6);
  // In the same way, 59.995 s is a minute.
  if (duration_ns < 60 * kNsPerS - 5 * kNsPerMs) return fmt::format("{:.2f} s", ns / 1e9);
  const std::int64_t tenths = (duration_ns + kNsPerS / 20) / (kNsPerS / 10);
  const std::int64_t minutes = tenths / 600;
  const std::int64_t rest = tenths % 600;
  if (minutes < 60) return fmt::format("{}:{:02}.{}", minutes, rest / 10, rest % 10);
  return fmt::format("{}:{:02}:{:02}.{}", minutes / 60, minutes % 60, rest / 10, rest % 10);
}

Status check_span(DurationNs from_ns, DurationNs end_ns) {
  if (from_ns <= end_ns) return {};
  return fail(ErrorCode::kBadInput, "--from {}: the log or --until ends at {}; expected an earlier time",
              show_duration(from_ns), show_duration(end_ns));
}

}  // namespace footlight::tools

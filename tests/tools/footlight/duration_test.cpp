#include "tools/footlight/duration.h"

#include <doctest/doctest.h>

namespace footlight::tools {
namespace {

TEST_CASE("durations are parsed exactly, to the nanosecond") {
  struct Case {
    const char* text;
    DurationNs duration_ns;
  };
  for (const Case& c :
       {Case{"0", 0}, Case{"5", 5 * kNsPerS}, Case{"12.5", 12'500'000'000}, Case{"12.5s", 12'500'000'000},
        Case{"40ms", 40 * kNsPerMs}, Case{"250us", 250'000}, Case{"1ns", 1}, Case{"1m30s", 90 * kNsPerS},
        Case{"2h", 7'200 * kNsPerS}, Case{"1h1m1s1ms1us1ns", 3'661'001'001'001}, Case{"0.1s", 100'000'000},
        Case{".5s", 500'000'000}, Case{"1.5m", 90 * kNsPerS}, Case{"10000h", 36'000'000 * kNsPerS},
        Case{"0.000000001", 1}, Case{"12.123456789s", 12'123'456'789}}) {
    CAPTURE(c.text);
    const auto duration_ns = parse_duration(c.text);
    REQUIRE(duration_ns.has_value());
    CHECK(*duration_ns == c.duration_ns);
  }
}

TEST_CASE("text that is not a duration is refused with an example") {
  for (const char* text : {"", "s", "-1s", "+1s", "1 s", "1S", "5x", "1s1m", "1s1s", "30s5", "1..5s", ".", "1e3", "nan",
                           "inf", "10001h", "9999999999999999999999s", "0.00000000000000000000001s", "1s "}) {
    CAPTURE(text);
    const auto duration_ns = parse_duration(text);
    REQUIRE_FALSE(duration_ns.has_value());
    CHECK(duration_ns.error().code == ErrorCode::kBadInput);
    CHECK(duration_ns.error().message.find("1m30s") != std::string::npos);
    CHECK(duration_ns.error().message.find('"' + std::string(text) + '"') != std::string::npos);
  }
}

TEST_CASE("durations are printed in a suitable unit") {
  CHECK(show_duration(0) == "0 s");
  CHECK(show_duration(999) == "999 ns");
  CHECK(show_duration(12'345) == "12.3 us");
  CHECK(show_duration(1'500'000) == "1.5 ms");
  CHECK(show_duration(1'500'000'000) == "1.50 s");
  CHECK(show_duration(90 * kNsPerS) == "1:30.0");
  CHECK(show_duration(7'384'500 * kNsPerMs) == "2:03:04.5");
}

TEST_CASE("a duration that rounds up to the next unit is printed in it, and never with an exponent") {
  CHECK(show_duration(999'400) == "999 us");
  CHECK(show_duration(999'499) == "999 us");
  CHECK(show_duration(999'500) == "1 ms");
  CHECK(show_duration(999'499'999) == "999 ms");
  CHECK(show_duration(999'500'000) == "1.00 s");
  CHECK(show_duration(999'999'999) == "1.00 s");
  CHECK(show_duration(59'994'999'999) == "59.99 s");
  CHECK(show_duration(59'995'000'000) == "1:00.0");
  CHECK(show_duration(3'599'960 * kNsPerMs) == "1:00:00.0");
  for (DurationNs duration_ns = 1; duration_ns < 20'000 * kNsPerS; duration_ns += duration_ns / 97 + 1) {
    CAPTURE(duration_ns);
    CHECK(show_duration(duration_ns).find('e') == std::string::npos);
  }
}

}  // namespace
}  // namespace footlight::tools

// What a pump did, for Prometheus: its text exposition format, version 0.0.4. The names are listed in docs/metrics.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sim/pump.h"

namespace footlight::tools {

// Of the guard against harmful flashes.
struct FlashFacts {
  std::uint64_t harmful = 0;  // stretches of time in which the looks were harmful, or would have been
  std::uint64_t held = 0;     // looks that were held back
};

// Of the program, beside what the pump counts.
struct ServiceFacts {
  std::int64_t start_unix_ns = 0;
  bool real_time = false;     // the pump's thread has real-time priority
  std::uint64_t reloads = 0;  // show files taken over while it ran
  std::uint64_t reload_failures = 0;
  std::optional<FlashFacts> flashes;  // where a guard watches
};

// Every series once; a port whose name another one of its direction has already is told apart as "name #2".
[[nodiscard]] std::string metrics_text(const PumpStatus& status, const ServiceFacts& facts);

inline constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

}  // namespace footlight::tools

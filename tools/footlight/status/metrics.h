// Metrics of a pump for Prometheus: text exposition format, version 0.0.4. docs/metrics.md lists the names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sim/pump.h"

namespace footlight::tools {

// Of the flash guard (output_guard.h).
struct FlashFacts {
  std::uint64_t harmful = 0;  // periods of harmful flashes, held back or not
  std::uint64_t held = 0;     // snapshots that were held back
};

// Of the program, in addition to the pump's counters.
struct ServiceFacts {
  std::int64_t start_unix_ns = 0;
  bool real_time = false;     // the pump's thread has real-time priority
  std::uint64_t reloads = 0;  // show files used while running
  std::uint64_t reload_failures = 0;
  std::optional<FlashFacts> flashes;  // if there is a flash guard
};

// Each series appears once. The second port of one direction with the same name is "name #2".
[[nodiscard]] std::string metrics_text(const PumpStatus& status, const ServiceFacts& facts);

inline constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

}  // namespace footlight::tools

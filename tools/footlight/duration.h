// Durations as text: "12.5s", "40ms", "250us", "1m30s", "2h", and a plain number for seconds.
#pragma once

#include <string>
#include <string_view>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::tools {

// 0 to 10,000 hours, exact to the nanosecond. Units from large to small, each once: h, m, s, ms, us, ns.
// kBadInput: anything else.
[[nodiscard]] Result<DurationNs> parse_duration(std::string_view text);

// About three digits: "0 s", "12.3 us", "1.50 s", "2:03:04.5" from one minute on.
[[nodiscard]] std::string show_duration(DurationNs duration_ns);

// Fails if there is no time from --from to --until, or to the end of the log where that is not given.
[[nodiscard]] Status check_span(DurationNs from_ns, DurationNs end_ns);

}  // namespace footlight::tools

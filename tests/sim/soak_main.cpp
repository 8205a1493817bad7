// soak [--hours H] [--rate HZ] [--seed N]: the soak of soak.h at any length, rate and seed. Exit code 1: a check
// failed; standard output lists it.
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

#include "tests/sim/soak.h"

int main(int argc, char** argv) {
  footlight::testing::SoakOptions options;
  for (int i = 1; i < argc; i += 2) {
    const std::string_view key = argv[i];
    const bool known = key == "--hours" || key == "--rate" || key == "--seed";
    if (!known || i + 1 == argc) {
      fmt::print(stderr, "soak: expected --hours H, --rate HZ or --seed N, got {}\n", key);
      return 2;
    }
    if (key == "--hours") options.hours = std::atof(argv[i + 1]);
    if (key == "--rate") options.rate_hz = std::atof(argv[i + 1]);
    if (key == "--seed") options.seed = std::strtoull(argv[i + 1], nullptr, 10);
  }
  if (!(options.hours > 0.0) || !(options.rate_hz >= 0.1 && options.rate_hz <= 10'000.0)) {
    fmt::print(stderr, "soak: expected hours above 0 and a rate from 0.1 to 10000\n");
    return 2;
  }
  const footlight::testing::SoakReport report = footlight::testing::run_soak(options);
  for (const std::string& offence : report.offences) fmt::print("{}\n", offence);
  fmt::print(
      "{} h at {} Hz, seed {}: {} offences\n{} frames, {} snapshots at sinks, {} ticks, {} minutes checked, {} bytes "
      "more "
      "held at most\nsilences {}, endings {}, bursts {}, priority changes {}, claims {}, source failures {}, sink "
      "failures {}, stalls {}, jumps {}, reloads {}, takeovers {}\n",
      options.hours, options.rate_hz, options.seed, report.offences.size(), report.frames, report.snapshots,
      report.ticks, report.minutes_checked, report.memory_growth_bytes, report.silences, report.endings, report.bursts,
      report.priority_changes, report.claim_changes, report.source_failures, report.sink_failures, report.stalls,
      report.jumps, report.reloads, report.takeovers);
  return report.offences.empty() ? 0 : 1;
}

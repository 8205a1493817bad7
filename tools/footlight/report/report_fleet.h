// Steps many moving heads on the GPU. Measures the time per fixture and the largest differences between the GPU's float
// and the CPU's double.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/vk/device.h"
#include "sim/core/result.h"

namespace footlight::tools {

struct FleetOptions {
  int fixtures = 100'000;  // 1 to 1,000,000; generic/profile, 16 bit: pan, tilt and zoom motors, strobe, gobo spin
  int runs = 21;           // timed steps, after 3 warm-up steps
};

// The value with the largest difference between the GPU's float and the CPU's double.
struct FleetWorst {
  std::string value;  // "pan_rad"
  int fixture = 0;    // index
  int step = 0;
  double gpu = 0;
  double cpu = 0;        // in double
  double float_cpu = 0;  // in float on the CPU; equals `gpu` if both round in the same way
};

struct FleetReport {
  std::string device;
  double gpu_ms_p10 = 0, gpu_ms_p50 = 0, gpu_ms_p90 = 0;  // of one step of all fixtures
  double levels_ms = 0;                                   // median upload time, not included in gpu_ms
  double walker_ns = 0;                                   // one step of one fixture in float on one CPU core
  std::uint64_t table_bytes = 0;
  std::uint64_t state_bytes = 0;  // of all fixtures
  int judged_fixtures = 0;
  int judged_steps = 0;
  std::vector<FleetWorst> worst;  // one per value, the largest difference first
};

// A step is 1/60 s. Every second step, one slot in 16 changes at random. The first 1,000 fixtures are compared over 240
// steps. If every slot changed, no motor would reach its target. A time-optimal motor that never arrives is chaotic: a
// difference of 1e-7 grows tenfold in 60 steps, in any precision. The difference vanishes when a target is held
// (docs/numerics.md).
[[nodiscard]] Result<FleetReport> make_fleet_report(render::vk::Device& device, const FleetOptions& options);
[[nodiscard]] std::string text_of(const FleetReport& report, const FleetOptions& options);
[[nodiscard]] std::string json_of(const FleetReport& report, const FleetOptions& options);

}  // namespace footlight::tools

// Many moving heads stepped on the GPU and on the CPU: what a fixture costs, and where float parts from double.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/vk/device.h"
#include "sim/core/result.h"

namespace footlight::tools {

struct FleetOptions {
  int fixtures = 100'000;  // 1 to 1,000,000; generic/profile, 16 bit: pan, tilt and zoom motors, strobe, gobo spin
  int runs = 21;           // timed steps, after 3
};

// One value of one head where the GPU's float is furthest from the CPU's double.
struct FleetWorst {
  std::string value;  // "pan_rad"
  int fixture = 0;    // index
  int step = 0;
  double gpu = 0;
  double cpu = 0;        // in double
  double float_cpu = 0;  // in float on the CPU: equal to `gpu` where the devices round alike
};

struct FleetReport {
  std::string device;
  double gpu_ms_p10 = 0, gpu_ms_p50 = 0, gpu_ms_p90 = 0;  // of one step of all fixtures
  double levels_ms = 0;                                   // median of their way to the GPU, not part of the above
  double cpu_ns = 0;     // a fixture's step in float, on one core, in batches (fixtures/simulate/fleet.h)
  double walker_ns = 0;  // the same head by head
  std::uint64_t table_bytes = 0;
  std::uint64_t state_bytes = 0;  // of all fixtures
  int judged_fixtures = 0;
  int judged_steps = 0;
  std::vector<FleetWorst> worst;  // one for each value, the largest difference first
};

// Steps are 1/60 s, and at each second one a sixteenth of all slots changes at random. Judged are the first 1,000
// fixtures over 240 steps. (Where every slot changes each second step no motor ever arrives, and a time-optimal motor
// that never arrives is chaotic: 1e-7 of difference grows tenfold in 60 steps, in any precision. It is gone as soon as
// a target is held: docs/numerics.md.)
[[nodiscard]] Result<FleetReport> make_fleet_report(render::vk::Device& device, const FleetOptions& options);
[[nodiscard]] std::string text_of(const FleetReport& report, const FleetOptions& options);
[[nodiscard]] std::string json_of(const FleetReport& report, const FleetOptions& options);

}  // namespace footlight::tools

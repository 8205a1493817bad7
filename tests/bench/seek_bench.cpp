// How long a seek in a long log takes, with an index of moments and from the start; and what the index costs.
//
//   bench_seek [HOURS [FIXTURES]]     default 3, 24: generic/profile, all heads moving, each universe at 44 Hz
//
// Only the steps of the fixtures are made, no pictures. On the device that FOOTLIGHT_TEST_DEVICE names a part of, else
// on the best one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "fixtures/model/rig.h"
#include "render/frame.h"
#include "render/passes/step.h"
#include "sim/dmx_log/log_output.h"
#include "sim/system_clock.h"
#include "tools/footlight/pictures/seek_index.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kPeriodNs = kNsPerS / 44;
constexpr DurationNs kExposureNs = 20 * kNsPerMs;
constexpr int kSeeks = 200;

template <class T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}\n", result.error().message);
  std::exit(1);
}
void must(const Status& status) {
  if (status) return;
  fmt::print(stderr, "{}\n", status.error().message);
  std::exit(1);
}

std::string rig_text(int fixtures) {
  return fmt::format(
      "[rig]\nname = \"x\"\n[[fixture]]\nname = \"Spot {{}}\"\ntype = \"generic/profile\"\nposition = [0, 0, 6]\n"
      "universe = 1\naddress = 1\ncount = {}\nposition_step = [0.5, 0, 0]\nper_universe = 36\n",
      fixtures);
}

// Every slot a slow wave of its own.
dmx_log::Bytes waves(DurationNs length_ns, const std::vector<Universe>& universes) {
  dmx_log::Bytes bytes;
  LogWriter writer = must(dmx_log::make_writer(dmx_log::memory_output(bytes, "waves"), {}));
  Slots slots;
  for (DurationNs round_ns = 0; round_ns < length_ns; round_ns += kPeriodNs) {
    const double seconds = static_cast<double>(round_ns) * 1e-9;
    for (std::size_t u = 0; u < universes.size(); ++u) {
      for (std::size_t i = 0; i < slots.size(); ++i) {
        const double phase = seconds * (0.2 + 0.001 * static_cast<double>(i)) + static_cast<double>(i);
        slots[i] = static_cast<std::uint8_t>(127.5 + 127.4 * std::sin(phase));
      }
      FrameView frame;
      frame.universe = universes[u];
      frame.slots = slots;
      frame.stamp_ns = round_ns + kPeriodNs * static_cast<DurationNs>(u) / static_cast<DurationNs>(universes.size());
      must(writer.append(frame));
    }
  }
  must(writer.close(length_ns));
  return bytes;
}

double ms_since(Clock& clock, TimeNs begun_ns) { return static_cast<double>(clock.now_ns() - begun_ns) * 1e-6; }

int run(double hours, int fixtures) {
  const fixtures::Rig rig = must(fixtures::parse_rig(rig_text(fixtures), "bench.toml"));
  const fixtures::CompiledRig compiled = must(fixtures::compile(rig));
  const auto length_ns = static_cast<DurationNs>(hours * 3600e9);
  const dmx_log::Bytes bytes = waves(length_ns, compiled.universes);
  const auto timeline = [&] {
    return Timeline(must(LogReader::open_bytes({bytes.begin(), bytes.end()}, "waves")), compiled);
  };
  render::vk::DeviceOptions options;
  if (const char* name = std::getenv("FOOTLIGHT_TEST_DEVICE")) options.name_contains = name;
  const auto device = must(render::vk::Device::create(options));
  const auto frame =
      must(render::Frame::create(*device, rig, compiled, {.width = 16, .height = 16}, {&render::kStepPass}));
  SystemClock clock;
  const auto advance = [&](Timeline& from, TimeNs until_ns) {
    must(from.advance(until_ns, kExposureNs,
                      [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                        frame->step(levels, dt_ns, new_exposure);
                        if (frame->pending_steps() >= 512) must(frame->run_steps());
                      }));
    must(frame->run_steps());
  };
  fmt::print("{}: {} fixtures, {} universes, {} h\n", device->name(), fixtures, compiled.universes.size(), hours);

  SeekIndex index(timeline());
  TimeNs begun_ns = clock.now_ns();
  int calls = 0;
  double longest_ms = 0;
  for (; !index.done(); ++calls) {
    const TimeNs call_ns = clock.now_ns();
    must(index.work(*frame, clock, 5 * kNsPerMs));
    longest_ms = std::max(longest_ms, ms_since(clock, call_ns));
  }
  fmt::print("index: {:.1f} s, {} calls of 5 ms (longest {:.1f} ms), {} moments, {:.1f} MiB\n",
             ms_since(clock, begun_ns) * 1e-3, calls, longest_ms, index.moments().size(),
             static_cast<double>(index.bytes()) / (1 << 20));

  Timeline shown = timeline();
  std::vector<double> ms;
  for (int i = 0; i < kSeeks; ++i) {
    const double share = std::fmod(0.5 + i * 0.6180339887498949, 1.0);
    const auto until_ns = static_cast<TimeNs>(share * static_cast<double>(length_ns));
    begun_ns = clock.now_ns();
    if (const SeekIndex::Moment* moment = index.before(until_ns - kExposureNs)) {
      must(shown.go_to(moment->position));
      must(frame->load_state(moment->state));
    } else {
      continue;
    }
    advance(shown, until_ns);
    ms.push_back(ms_since(clock, begun_ns));
  }
  std::sort(ms.begin(), ms.end());
  fmt::print("{} seeks: p50 {:.1f} ms, p99 {:.1f} ms, longest {:.1f} ms\n", ms.size(), ms[ms.size() / 2],
             ms[ms.size() * 99 / 100], ms.back());

  Timeline whole = timeline();
  const render::FrameState zero{.heads = std::vector<std::byte>(must(frame->save_state()).heads.size()), .air = {}};
  must(frame->load_state(zero));
  begun_ns = clock.now_ns();
  advance(whole, length_ns);
  fmt::print("from the start to the end: {:.0f} ms\n", ms_since(clock, begun_ns));
  return 0;
}

}  // namespace
}  // namespace footlight::tools

int main(int count, char** words) {
  const double hours = count > 1 ? std::atof(words[1]) : 3;
  const int fixtures = count > 2 ? std::atoi(words[2]) : 24;
  if (!(hours > 0 && hours <= 24 && fixtures >= 1 && fixtures <= 10'000)) {
    fmt::print(stderr, "usage: bench_seek [HOURS [FIXTURES]]\n");
    return 2;
  }
  return footlight::tools::run(hours, fixtures);
}

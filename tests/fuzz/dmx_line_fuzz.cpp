// Arbitrary samples of a DMX line, as runs: a byte of length each, whose highest bit is the level, times a step from
// the second byte. The first byte selects the sample rate.
//
// Frames come in the order of their breaks, lie within the samples, have the properties that the header states for
// valid ones, and do not depend on how the samples are divided.
#include <vector>

#include "drivers/capture/dmx_line.h"
#include "tests/drivers/capture/line_signal.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using namespace footlight::drivers;
using footlight::testing::require;

namespace {

constexpr std::uint64_t kRatesHz[] = {500'000, 1'000'000, 2'000'000, 4'000'000, 12'000'000, 24'000'000, 25'175'000};

}  // namespace

void footlight::testing::add_seeds(Seeds& seeds) {
  for (std::uint8_t rate = 0; rate < 4; ++rate) {
    LineSignal signal(kRatesHz[rate]);
    signal.mark(1e5);
    for (const int value : {0x00, 0x55, 0xFF}) {
      const std::vector<std::uint8_t> bytes = {0, static_cast<std::uint8_t>(value), 1, 0x80};
      signal.frame(bytes, {48'000 + 10'000 * rate, 4'000, 1'000 * rate, 4'000.0, 2});
    }
    signal.mark(2e5);
    std::vector<std::uint8_t> input = {rate, 0};
    const auto& samples = signal.samples();
    for (std::size_t at = 0; at < samples.size();) {
      std::size_t end = at;
      while (end < samples.size() && samples[end] == samples[at] && end - at < 127) ++end;
      input.push_back(static_cast<std::uint8_t>((samples[at] != 0 ? 128 : 0) | (end - at)));
      at = end;
    }
    seeds.add("rate-" + std::to_string(rate), input);
  }
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::uint64_t rate_hz = kRatesHz[data[0] % std::size(kRatesHz)];
  const std::uint64_t step = 1 + data[1] % 16;
  DmxLineDecoder whole(rate_hz);
  DmxLineDecoder cut(rate_hz);
  for (std::size_t i = 2; i < size; ++i) {
    const std::uint64_t count = (data[i] & 127) * step;
    whole.feed(data[i] >= 128, count);
    cut.feed(data[i] >= 128, count / 3);
    cut.feed(data[i] >= 128, count - count / 3);
  }
  whole.finish();
  cut.finish();
  LineFrame frame;
  LineFrame other;
  TimeNs before_ns = -1;
  std::uint64_t sound = 0;
  while (whole.take(frame)) {
    require(cut.take(other) && other.bytes == frame.bytes && other.timing.start_ns == frame.timing.start_ns);
    const LineFrameTiming& timing = frame.timing;
    require(timing.start_ns > before_ns);
    before_ns = timing.start_ns;
    require(timing.break_ns >= kLineBreakMinNs && timing.slot_count >= 0 && timing.slot_count <= kSlotCountMax);
    require(timing.period_ns >= 0 && timing.start_ns + timing.break_ns <= whole.now_ns());
    require(frame.slots().size() == static_cast<std::size_t>(timing.slot_count));
    if (timing.fault != LineFault::kNone) continue;
    ++sound;
    require(timing.break_ns <= kLineBreakMaxNs && timing.mab_ns >= kLineMabMinNs);
    require(timing.gap_min_ns <= timing.gap_max_ns && timing.end_ns > timing.start_ns + timing.break_ns);
    require(timing.start_code == frame.bytes[0]);
  }
  require(!cut.take(other) && sound == whole.counters().sound);
  return 0;
}

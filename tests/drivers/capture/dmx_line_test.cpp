#include "drivers/capture/dmx_line.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <vector>

#include <doctest/doctest.h>

#include "tests/drivers/capture/line_signal.h"

namespace footlight::drivers {
namespace {

using footlight::testing::LineProfile;
using footlight::testing::LineSignal;

std::vector<std::uint8_t> snapshot(std::size_t slots, int seed) {
  std::vector<std::uint8_t> bytes(1 + slots, 0);
  for (std::size_t i = 1; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(i % 3 == 0 ? 0 : i * 7 + static_cast<std::size_t>(seed) * 31);
  }
  return bytes;
}

std::vector<LineFrame> decode(const std::vector<std::uint8_t>& samples, std::uint64_t rate_hz, bool inverted = false,
                              std::size_t piece = SIZE_MAX, LineCounters* counters = nullptr) {
  DmxLineDecoder decoder(rate_hz);
  std::span<const std::uint8_t> left = samples;
  while (!left.empty()) {
    const std::size_t size = std::min(piece, left.size());
    decoder.feed_samples(left.first(size), 1, 0, inverted);
    left = left.subspan(size);
  }
  decoder.finish();
  std::vector<LineFrame> frames;
  for (LineFrame frame; decoder.take(frame);) frames.push_back(frame);
  if (counters != nullptr) *counters = decoder.counters();
  return frames;
}

std::vector<LineFrame> decode(const LineSignal& signal, std::uint64_t rate_hz) {
  return decode(signal.samples(), rate_hz);
}

bool has_bytes(const LineFrame& frame, const std::vector<std::uint8_t>& bytes) {
  return frame.timing.slot_count + 1 == static_cast<int>(bytes.size()) &&
         std::equal(bytes.begin(), bytes.end(), frame.bytes.begin());
}

// The fault of the third frame, between two valid frames before it and one after it.
LineFault fault_of(const std::function<void(LineSignal&)>& third) {
  constexpr std::uint64_t kRateHz = 4'000'000;
  LineSignal signal(kRateHz);
  signal.mark(200e3);
  signal.frame(snapshot(30, 1));
  signal.frame(snapshot(30, 2));
  third(signal);
  signal.frame(snapshot(30, 3));
  signal.mark(5e6);
  const auto frames = decode(signal, kRateHz);
  REQUIRE(frames.size() == 4);
  for (const std::size_t sound : {std::size_t{0}, std::size_t{1}, std::size_t{3}}) {
    CHECK(frames[sound].timing.fault == LineFault::kNone);
    CHECK(frames[sound].timing.slot_count == 30);
  }
  return frames[2].timing.fault;
}

}  // namespace

TEST_CASE("the frames of five devices are decoded with their timing at every sample rate from 1 to 24 MHz") {
  struct Device {
    const char* name;
    LineProfile profile;
    std::size_t slots;
  };
  // Breaks, marks after break and gaps as measured on these devices.
  const Device devices[] = {
      {"DMX4ALL Mini-USB-DMX", {98'200, 21'400, 14'850, 4'000.0, 2}, 512},
      {"MA Lighting dot2", {196'000, 11'000, 0, 3'960.0, 2}, 512},
      {"Nicolaudie Suite2", {181'000, 22'000, 4'000, 4'000.0, 2}, 512},
      {"SGM Regia 256", {308'000, 4'000, 500, 4'000.0, 2}, 256},
      {"uDMX", {50'000, 19'000, 0, 4'000.0, 2}, 512},
  };
  for (const Device& device : devices) {
    for (const std::uint64_t rate_mhz : std::initializer_list<std::uint64_t>{1, 2, 3, 4, 6, 8, 12, 16, 24}) {
      CAPTURE(device.name);
      CAPTURE(rate_mhz);
      const double sample_ns = 1e3 / static_cast<double>(rate_mhz);
      LineSignal signal(rate_mhz * 1'000'000);
      signal.mark(100'300);
      std::vector<double> starts;
      for (int i = 0; i < 3; ++i) {
        starts.push_back(signal.now_ns());
        signal.frame(snapshot(device.slots, i), device.profile);
        signal.mark(70e3 + 333.0 * i);
      }
      signal.mark(3e6);
      const auto frames = decode(signal, rate_mhz * 1'000'000);
      REQUIRE(frames.size() == 3);
      for (std::size_t i = 0; i < 3; ++i) {
        const LineFrameTiming& timing = frames[i].timing;
        CHECK(timing.fault == LineFault::kNone);
        CHECK(!timing.unfinished);
        CHECK(has_bytes(frames[i], snapshot(device.slots, static_cast<int>(i))));
        const auto near = [&](DurationNs measured, double true_ns) {
          return std::abs(static_cast<double>(measured) - true_ns) <= sample_ns + 1.0;
        };
        CHECK(near(timing.start_ns, starts[i]));
        CHECK(near(timing.break_ns, static_cast<double>(device.profile.break_ns)));
        CHECK(near(timing.mab_ns, static_cast<double>(device.profile.mab_ns)));
        const double pitch_ns = static_cast<double>(device.profile.gap_ns) + 11 * device.profile.bit_ns;
        const double gap_ns = std::max(pitch_ns - 44'000.0, 0.0);
        CHECK(near(timing.gap_min_ns, gap_ns));
        CHECK(near(timing.gap_max_ns, gap_ns));
        CHECK(near(timing.pitch_min_ns, pitch_ns));
        if (i < 2) CHECK(near(timing.period_ns, starts[i + 1] - starts[i]));
      }
      CHECK(frames[2].timing.period_ns == 0);
    }
  }
}

TEST_CASE("a slot of zeros is never a break, and a break from 48 us, or a tenth less, always is") {
  for (const std::uint64_t rate_mhz : std::initializer_list<std::uint64_t>{1, 2, 5, 24}) {
    CAPTURE(rate_mhz);
    LineSignal signal(rate_mhz * 1'000'000);
    signal.mark(1e5);
    const std::vector<std::uint8_t> zeros(513, 0);
    LineProfile profile;
    profile.bit_ns = 4'080.0;  // 2 % slow: 36.7 us of low
    int sent = 0;
    for (DurationNs break_ns = 45'000; break_ns <= 66'000; break_ns += 700, ++sent) {
      profile.break_ns = break_ns;
      signal.frame(zeros, profile);
    }
    signal.mark(3e6);
    const auto frames = decode(signal, rate_mhz * 1'000'000);
    REQUIRE(frames.size() == static_cast<std::size_t>(sent));
    for (const LineFrame& frame : frames) CHECK(has_bytes(frame, zeros));
  }
}

TEST_CASE("senders that are four percent fast or slow are decoded to the last slot, with one stop bit or two") {
  for (const double bit_ns : {3'840.0, 3'920.0, 4'000.0, 4'080.0, 4'160.0}) {
    for (const int stop_bits : {1, 2}) {
      CAPTURE(bit_ns);
      CAPTURE(stop_bits);
      LineSignal signal(8'000'000);
      LineProfile profile;
      profile.bit_ns = bit_ns;
      profile.stop_bits = stop_bits;
      signal.mark(1e5);
      signal.frame(snapshot(512, 5), profile);
      signal.mark(3e6);
      const auto frames = decode(signal, 8'000'000);
      REQUIRE(frames.size() == 1);
      CHECK(has_bytes(frames[0], snapshot(512, 5)));
    }
  }
}

TEST_CASE("a gap is never negative at any sample rate, a fast sender or one stop bit shows in the pitch") {
  for (const std::uint64_t rate_hz : std::initializer_list<std::uint64_t>{1'000'000, 3'000'000, 24'000'000}) {
    for (const double bit_ns : {3'920.0, 3'990.0, 4'000.0}) {
      for (const int stop_bits : {1, 2}) {
        CAPTURE(rate_hz);
        CAPTURE(bit_ns);
        CAPTURE(stop_bits);
        LineSignal signal(rate_hz);
        LineProfile profile;
        profile.bit_ns = bit_ns;
        profile.stop_bits = stop_bits;
        signal.mark(1e5);
        signal.frame(snapshot(512, 5), profile);
        signal.mark(3e6);
        const auto frames = decode(signal, rate_hz);
        REQUIRE(frames.size() == 1);
        const LineFrameTiming& timing = frames[0].timing;
        CHECK(timing.gap_min_ns == 0);
        CHECK(timing.gap_max_ns >= 0);
        CHECK(timing.gap_sum_ns >= 0);
        const double sample_ns = 1e9 / static_cast<double>(rate_hz);
        const double pitch_ns = (9 + stop_bits) * bit_ns;
        CHECK(static_cast<double>(timing.pitch_min_ns) <= pitch_ns + 1);
        CHECK(static_cast<double>(timing.pitch_min_ns) >= pitch_ns - sample_ns - 1);
      }
    }
  }
}

TEST_CASE("glitches below 1.5 us change no level, also in the middle of bits, and are counted") {
  LineSignal signal(4'000'000);
  signal.mark(1e5);
  signal.frame(snapshot(512, 1));
  signal.mark(2e6);
  const auto clean = decode(signal, 4'000'000);
  std::uint64_t state = 1;
  std::uint64_t glitches = 0;
  // A pulse of 1 us, at least 1.5 us away from every edge: nearer, it would move the edge.
  std::vector<std::uint8_t>& samples = signal.samples();
  for (std::size_t at = 10; at + 20 < samples.size();) {
    if (std::all_of(samples.begin() + static_cast<std::ptrdiff_t>(at),
                    samples.begin() + static_cast<std::ptrdiff_t>(at) + 16,
                    [&](std::uint8_t level) { return level == samples[at]; })) {
      for (std::size_t i = 6; i < 10; ++i) samples[at + i] ^= 1;
      ++glitches;
    }
    state = state * 6364136223846793005u + 1442695040888963407u;
    at += 17 + (state >> 33) % 50;
  }
  LineCounters counters;
  const auto noisy = decode(samples, 4'000'000, false, SIZE_MAX, &counters);
  CHECK(glitches > 200);
  CHECK(counters.glitches == glitches);
  REQUIRE(noisy.size() == 1);
  CHECK(has_bytes(noisy[0], snapshot(512, 1)));
  CHECK(noisy[0].timing.break_ns == clean[0].timing.break_ns);
}

TEST_CASE("samples that are divided anywhere, or inverted from DMX-, give the same frames") {
  LineSignal signal(1'000'000);
  signal.mark(1e5);
  for (int i = 0; i < 4; ++i) {
    signal.frame(snapshot(100, i));
    signal.mark(1e5);
  }
  const auto whole = decode(signal, 1'000'000);
  REQUIRE(whole.size() == 4);
  for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{1000}}) {
    const auto pieces = decode(signal.samples(), 1'000'000, false, piece);
    REQUIRE(pieces.size() == whole.size());
    for (std::size_t i = 0; i < whole.size(); ++i) {
      CHECK(pieces[i].bytes == whole[i].bytes);
      CHECK(pieces[i].timing.start_ns == whole[i].timing.start_ns);
    }
  }
  std::vector<std::uint8_t> minus = signal.samples();
  for (std::uint8_t& level : minus) level ^= 1;
  const auto turned = decode(minus, 1'000'000, true);
  REQUIRE(turned.size() == 4);
  CHECK(turned[3].bytes == whole[3].bytes);
}

TEST_CASE("a rejected frame has its reason and costs no other frame") {
  const auto bytes = snapshot(30, 7);
  CHECK(fault_of([&](LineSignal& signal) { signal.frame(bytes); }) == LineFault::kNone);
  CHECK(fault_of([&](LineSignal& signal) {
          signal.frame(bytes, {100'000, 2'000, 0, 4'000.0, 2});
        }) == LineFault::kMabShort);
  CHECK(fault_of([&](LineSignal& signal) { signal.frame({}); }) == LineFault::kNoStartCode);
  CHECK(fault_of([&](LineSignal& signal) {  // 41 us of low: neither a slot nor a break
          signal.frame(bytes);
          signal.space(41e3);
          signal.mark(20e3);
        }) == LineFault::kNoStopBit);
  CHECK(fault_of([&](LineSignal& signal) {  // four bits of a slot, then the next break
          signal.frame(bytes);
          signal.space(4e3);
          signal.mark(12e3);
        }) == LineFault::kCutSlot);
  CHECK(fault_of([&](LineSignal& signal) { signal.frame(snapshot(513, 7)); }) == LineFault::kTooManySlots);
  CHECK(fault_of([&](LineSignal& signal) {
          signal.space(1.2e9);
          signal.mark(12e3);
          signal.slot(0);
        }) == LineFault::kBreakLong);
}

TEST_CASE("a frame is unfinished if the samples end inside it, and whole if the line rests after it") {
  constexpr std::uint64_t kRateHz = 1'000'000;
  const auto tail = [&](double rest_ns) {
    LineSignal signal(kRateHz);
    signal.mark(1e5);
    signal.frame(snapshot(24, 1));
    signal.mark(rest_ns);
    const auto frames = decode(signal, kRateHz);
    REQUIRE(frames.size() == 1);
    CHECK(frames[0].timing.fault == LineFault::kNone);
    CHECK(has_bytes(frames[0], snapshot(24, 1)));
    return frames[0].timing.unfinished;
  };
  CHECK(tail(20e3));
  CHECK(!tail(2e6));
  LineSignal begun(kRateHz);  // the samples start inside a break, which then has no length
  begun.space(90e3);
  begun.mark(12e3);
  begun.slot(0);
  begun.slot(9);
  begun.mark(2e6);
  CHECK(decode(begun, kRateHz).empty());
  LineSignal cut(kRateHz);
  cut.mark(1e5);
  cut.space(100e3);
  cut.mark(5e3);
  const auto frames = decode(cut, kRateHz);
  REQUIRE(frames.size() == 1);
  CHECK(frames[0].timing.fault == LineFault::kUnfinished);
}

TEST_CASE("only the selected bit of samples of several bytes is used") {
  LineSignal signal(2'000'000);
  signal.mark(1e5);
  signal.frame(snapshot(40, 3));
  signal.mark(2e6);
  std::vector<std::uint8_t> wide;
  for (const std::uint8_t level : signal.samples()) {
    wide.push_back(static_cast<std::uint8_t>(wide.size() * 37));  // other probes
    wide.push_back(static_cast<std::uint8_t>((wide.size() * 91 & 0xFB) | (level != 0 ? 4 : 0)));
  }
  DmxLineDecoder decoder(2'000'000);
  decoder.feed_samples(wide, 2, 10, false);
  decoder.finish();
  LineFrame frame;
  REQUIRE(decoder.take(frame));
  CHECK(has_bytes(frame, snapshot(40, 3)));
}

}  // namespace footlight::drivers

// Fuzzes the reader of DMX logs. The first byte selects the use of the rest: as a file (0: checksums checked, 1:
// ignored), or as the content of a block (2 and up), so that mutations reach the decoder past checksums and
// compression.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/dmx_log/log_output.h"
#include "tests/fuzz/fuzz.h"
#include "tests/sim/dmx_log/exercise.h"

void footlight::testing::add_seeds(Seeds& seeds) {
  constexpr int kFrames = 21;  // as the seed with 5 requires below
  dmx_log::Bytes file;
  auto writer = dmx_log::make_writer(dmx_log::memory_output(file, "seed"), {.block_span_ns = 200 * kNsPerMs});
  require(writer.has_value());
  dmx_log::BlockEncoder block;
  Slots slots{};
  for (int i = 0; i < kFrames; ++i) {
    FrameView frame;
    frame.universe = 1 + i % 2 * 9;
    frame.stamp_ns = (1 + i * 25) * kNsPerMs;
    frame.sender = i < 15 ? 5 : 6;
    frame.sequence = static_cast<std::uint32_t>(i / 2);
    frame.terminated = i == 19;
    for (std::size_t slot = 0; slot < 40; ++slot)
      slots[slot] = static_cast<std::uint8_t>(slot * 3 + static_cast<std::size_t>(i) / 4);
    frame.slots = std::span(slots).first(frame.terminated ? 0 : i < 10 ? 24 : 512);
    block.add(frame.stamp_ns, frame, true);
    require(writer->append(frame).has_value());
  }
  require(writer->close(kNsPerS).has_value());
  file.insert(file.begin(), 0);
  seeds.add("file", file);
  file.front() = 1;
  seeds.add("file-unchecked", file);
  dmx_log::Bytes raw;
  block.encode(raw);
  raw.insert(raw.begin(), 5);
  seeds.add("block", raw);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::vector<std::uint8_t> bytes(data + 1, data + size);
  switch (data[0] % 3) {
    case 0: footlight::testing::exercise_log(std::move(bytes), true); break;
    case 1: footlight::testing::exercise_log(std::move(bytes), false); break;
    default: {
      constexpr footlight::DurationNs kFirstNs = 1'000'000;
      footlight::testing::exercise_block(bytes, static_cast<std::uint32_t>(1 + data[0] * 4), kFirstNs,
                                         60 * footlight::kNsPerS);
    }
  }
  return 0;
}

// Calls everything that a reader offers, on a log or on arbitrary bytes. Used by the fuzz target and by the replay of
// mutated inputs: no input may crash, hang or read out of bounds.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "sim/core/check.h"
#include "sim/dmx_log/block.h"
#include "sim/dmx_log/dmx_log.h"

namespace footlight::testing {

// Returns the number of frames read.
inline std::uint64_t exercise_log(std::vector<std::uint8_t> bytes, bool check_checksums) {
  auto reader = LogReader::open_bytes(std::move(bytes), "mutated.dmxlog", {.check_checksums = check_checksums});
  if (!reader) {
    FL_CHECK(!reader.error().message.empty());
    return 0;
  }
  std::uint64_t frames = 0;
  DurationNs before_ns = 0;
  DurationNs middle_ns = 0;
  LogFrame frame;
  while (frames < 20'000 && reader->next(frame).value_or(false)) {
    FL_CHECK_LE(before_ns, frame.time_ns);
    FL_CHECK_EQ(frame.levels.size(), std::size_t{512});
    FL_CHECK(is_universe(frame.universe) && frame.slot_count >= 0 && frame.slot_count <= 512);
    for (const SlotRun& run : frame.changes) FL_CHECK(run.count > 0 && run.first + run.count <= 512);
    before_ns = frame.time_ns;
    if (frames++ % 2 == 0) middle_ns = frame.time_ns / 2;
  }
  for (const DurationNs time_ns : {middle_ns, before_ns, DurationNs{-1}, reader->info().duration_ns, kTimeNever}) {
    FL_CHECK(reader->seek(time_ns));
    std::uint64_t sum = 0;
    for (const LogSnapshot& snapshot : reader->snapshot())
      sum += snapshot.levels[511] + static_cast<std::uint64_t>(snapshot.universe);
    for (int i = 0; i < 5 && reader->next(frame).value_or(false); ++i) {
      FL_CHECK_LT(time_ns, frame.time_ns);
      sum += frame.levels[0];
    }
    frames += sum % 2;  // so that the reads are not optimised away
  }
  FL_CHECK_LE(reader->info().damage.size(), std::size_t{64});
  return frames;
}

// The same for the content of a block, past checksum and compression.
inline void exercise_block(const std::vector<std::uint8_t>& raw, std::uint32_t frame_count, DurationNs first_ns,
                           DurationNs last_ns) {
  dmx_log::BlockDecoder decoder;
  if (!decoder.load(raw, frame_count, first_ns, last_ns)) return;
  Slots before{};
  while (decoder.has_next()) {
    FL_CHECK(decoder.next_time_ns() >= first_ns && decoder.next_time_ns() <= last_ns);
    const auto step = decoder.next(before);
    if (!step) break;
    FL_CHECK_LT(step->index, decoder.states().size());
  }
}

}  // namespace footlight::testing
